// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures: their ids, pictures and how they are read.
//! Source: after OpenGL 1.x. Integers are linear light: bytes map to value / 255 without sRGB decoding.
//! Invariant: an image has its first row at t = 0. Tests: `tests`; tests/c/scene.c, tests/c/errors.c.

use std::collections::BTreeMap;
use std::sync::Arc;

use gnurt::image::{TexelData, Texels};
use gnurt::shading::mipmap::{Minify, MipMap};
use gnurt::shading::texture::{TextureSampler, Wrap};

use super::enums::{MinifyFilter, TexelFormat, TexelType, TextureFilter, TextureWrap};
use super::error::{Error, Result};
use super::ids::Ids;

/// `v = 1 - t`: samplers have the first row at v = 1, OpenRT has it at t = 0.
const FIRST_ROW_AT_0: [f32; 6] = [1.0, 0.0, 0.0, -1.0, 0.0, 1.0];

/// Texels along one side at most.
const MAX_SIZE: i32 = 1 << 15;

/// A texture; without an image it is white.
#[derive(Clone, Debug, Default)]
pub(crate) struct Texture {
    image: Option<Arc<Texels>>,
    wrap: [Wrap; 2],
    /// Smaller copies of the image.
    mips: Option<Arc<MipMap>>,
    /// Linear if the program has not set it.
    pub(crate) filter: Option<TextureFilter>,
    /// Linear if the program has not set it.
    pub(crate) minify: Option<MinifyFilter>,
}

impl Texture {
    /// Wrapping outside of it along an axis.
    pub(crate) fn set_wrap(&mut self, axis: usize, wrap: TextureWrap) {
        self.wrap[axis] = match wrap {
            TextureWrap::Clamp | TextureWrap::ClampToEdge => Wrap::Clamp,
            TextureWrap::Repeat => Wrap::Repeat,
            TextureWrap::MirroredRepeat => Wrap::Mirror,
        };
    }

    /// Gives it another picture; none without texels.
    pub(crate) fn set_image(&mut self, image: Option<Texels>) {
        self.image = image.map(Arc::new);
        self.mips = self.image.clone().map(|image| Arc::new(MipMap::new(image)));
    }
}

/// All textures and which of them is bound.
#[derive(Clone, Debug, Default)]
pub(crate) struct Textures {
    /// Which ids there are.
    pub(crate) ids: Ids,
    /// Those that were changed since they were generated.
    changed: BTreeMap<u32, Texture>,
    bound: Option<u32>,
    /// Counts changes.
    revision: u64,
}

impl Textures {
    /// The sampler of texture `id`; `None` if it does not exist or has no image.
    #[must_use]
    pub(crate) fn sampler(&self, id: i32) -> Option<Arc<TextureSampler>> {
        let texture = self.changed.get(&u32::try_from(id).ok()?)?;
        let texels = texture.image.clone()?;
        let linear = texture.filter != Some(TextureFilter::Nearest);
        let minify = texture.minify.unwrap_or(MinifyFilter::Linear).minify();
        // Levels between are made when a ray first needs one: on the frame's threads.
        let minify = texture.mips.clone().map(|mips| (minify, mips));
        let (wrap, uv_from_mesh) = (texture.wrap, FIRST_ROW_AT_0);
        Some(Arc::new(TextureSampler { texels, wrap, linear, minify, uv_from_mesh, attribute: None }))
    }

    /// Rises whenever a texture changes.
    #[must_use]
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// Ids of all that may have a picture.
    pub(crate) fn ids(&self) -> impl Iterator<Item = u32> + '_ {
        self.changed.keys().copied()
    }

    /// Binds a texture that exists, or none.
    pub(crate) fn bind(&mut self, id: Option<u32>) {
        self.bound = id;
    }

    /// Removes an existing one.
    pub(crate) fn remove(&mut self, id: u32) -> Result<()> {
        self.ids.remove(id)?;
        self.revision += 1;
        self.changed.remove(&id);
        self.bound = self.bound.filter(|&bound| bound != id);
        Ok(())
    }

    /// Fails if none is bound.
    pub(crate) fn check_bound(&self) -> Result<()> {
        self.bound.map(drop).ok_or(Error::InvalidOperation)
    }

    /// The bound one, to be changed.
    pub(crate) fn bound_mut(&mut self) -> Result<&mut Texture> {
        let id = self.bound.ok_or(Error::InvalidOperation)?;
        self.revision += 1;
        Ok(self.changed.entry(id).or_default())
    }
}

/// Returns a number of bytes of the program's memory.
pub(crate) type ReadTexels<'a> = &'a dyn Fn(usize) -> &'a [u8];

/// The numbers of rtTexImage2D.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageDescription {
    /// Which kind of texture.
    pub(crate) target: u32,
    /// Mip level.
    pub(crate) level: i32,
    /// Channels to keep: 1, 3 or 4, or the constant of a format.
    pub(crate) internal_format: i32,
    /// Columns and rows.
    pub(crate) size: [i32; 2],
    /// Must be 0.
    pub(crate) border: i32,
    /// Channels in memory.
    pub(crate) format: u32,
    /// Type in memory.
    pub(crate) texel_type: u32,
}

/// The valid request of an rtTexImage2D.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CheckedImage {
    size: [u32; 2],
    format: TexelFormat,
    texel_type: TexelType,
    internal: TexelFormat,
}

impl ImageDescription {
    /// The image, if the library takes such images. The target is not checked.
    pub(crate) fn check(&self) -> Result<CheckedImage> {
        let format = TexelFormat::from_code(self.format)?;
        let texel_type = TexelType::from_code(self.texel_type)?;
        let sizes_fit = self.size.iter().all(|size| (0..=MAX_SIZE).contains(size));
        let internal = TexelFormat::from_internal(self.internal_format)?;
        if !sizes_fit || self.level < 0 || self.border != 0 {
            return Err(Error::InvalidValue);
        }
        Ok(CheckedImage { size: self.size.map(i32::unsigned_abs), format, texel_type, internal })
    }
}

impl CheckedImage {
    /// Its texels. None if a side is 0.
    pub(crate) fn texels(&self, read: ReadTexels<'_>) -> Result<Option<Texels>> {
        let [width, height] = self.size;
        let count = width as usize * height as usize;
        if count == 0 {
            return Ok(None);
        }
        let bytes = read(count * self.format.components() * self.texel_type.size());
        let data = decode_texels(bytes, self.format, self.texel_type, self.internal)?;
        Ok(Some(Texels { width, height, data }))
    }
}

impl TexelFormat {
    /// Numbers per texel.
    fn components(self) -> usize {
        match self {
            Self::Luminance => 1,
            Self::Rgb | Self::Bgr => 3,
            Self::Rgba | Self::Bgra => 4,
        }
    }

    /// Red, green, blue, alpha from a texel's numbers.
    fn rgba<T: Copy>(self, v: &[T], one: T) -> [T; 4] {
        match self {
            Self::Luminance => [v[0], v[0], v[0], one],
            Self::Rgb => [v[0], v[1], v[2], one],
            Self::Bgr => [v[2], v[1], v[0], one],
            Self::Rgba => [v[0], v[1], v[2], v[3]],
            Self::Bgra => [v[2], v[1], v[0], v[3]],
        }
    }

    /// The components of a texel that a texture with this internal format keeps.
    fn keep<T: Copy>(self, [r, g, b, a]: [T; 4], one: T) -> [T; 4] {
        match self {
            Self::Luminance => [r, r, r, one],
            Self::Rgb | Self::Bgr => [r, g, b, one],
            Self::Rgba | Self::Bgra => [r, g, b, a],
        }
    }

    /// The internal format of OpenGL 1.x with this code.
    fn from_internal(code: i32) -> Result<Self> {
        match code {
            1 => Ok(Self::Luminance),
            3 => Ok(Self::Rgb),
            4 => Ok(Self::Rgba),
            _ => match u32::try_from(code).ok().map(Self::from_code) {
                Some(Ok(format @ (Self::Luminance | Self::Rgb | Self::Rgba))) => Ok(format),
                _ => Err(Error::InvalidValue),
            },
        }
    }
}

impl MinifyFilter {
    /// The filter of the sampler.
    fn minify(self) -> Minify {
        let mipmap = |linear, interpolate_levels| Minify::Mipmap { linear, interpolate_levels };
        match self {
            Self::Nearest => Minify::Nearest,
            Self::Linear => Minify::Linear,
            Self::NearestMipmapNearest => mipmap(false, false),
            Self::LinearMipmapNearest => mipmap(true, false),
            Self::NearestMipmapLinear => mipmap(false, true),
            Self::LinearMipmapLinear => mipmap(true, true),
        }
    }
}

impl TexelType {
    /// Bytes per number.
    fn size(self) -> usize {
        match self {
            Self::Byte | Self::UnsignedByte => 1,
            Self::Short | Self::UnsignedShort => 2,
            Self::Int | Self::UnsignedInt | Self::Float => 4,
        }
    }

    /// A number as a float; integers map to [0, 1], signed ones to [-1, 1].
    fn decode(self, b: &[u8]) -> f32 {
        let signed = |value: i64, bits: u32| (2.0 * value as f64 + 1.0) / ((1_u64 << bits) - 1) as f64;
        let unsigned = |value: u64, bits: u32| value as f64 / ((1_u64 << bits) - 1) as f64;
        let value = match self {
            Self::Byte => signed(i64::from(i8::from_ne_bytes([b[0]])), 8),
            Self::UnsignedByte => unsigned(u64::from(b[0]), 8),
            Self::Short => signed(i64::from(i16::from_ne_bytes([b[0], b[1]])), 16),
            Self::UnsignedShort => unsigned(u64::from(u16::from_ne_bytes([b[0], b[1]])), 16),
            Self::Int => signed(i64::from(i32::from_ne_bytes([b[0], b[1], b[2], b[3]])), 32),
            Self::UnsignedInt => unsigned(u64::from(u32::from_ne_bytes([b[0], b[1], b[2], b[3]])), 32),
            Self::Float => return f32::from_ne_bytes([b[0], b[1], b[2], b[3]]),
        };
        value as f32
    }
}

/// Texels from a program's memory. Bytes stay bytes. Fails if memory for them is short.
fn decode_texels(
    bytes: &[u8],
    format: TexelFormat,
    kind: TexelType,
    internal: TexelFormat,
) -> Result<TexelData> {
    fn collect<T>(texels: impl ExactSizeIterator<Item = T>) -> Result<Vec<T>> {
        let mut all = Vec::new();
        all.try_reserve_exact(texels.len()).map_err(|_| Error::OutOfMemory)?;
        all.extend(texels);
        Ok(all)
    }
    let texels = bytes.chunks_exact(format.components() * kind.size());
    if kind == TexelType::UnsignedByte {
        return collect(texels.map(|v| internal.keep(format.rgba(v, 255), 255))).map(TexelData::Linear8);
    }
    let floats = |texel: &[u8]| {
        let mut v = [0.0; 4];
        let numbers = texel.chunks_exact(kind.size());
        v.iter_mut().zip(numbers).for_each(|(number, bytes)| *number = kind.decode(bytes));
        internal.keep(format.rgba(&v, 1.0), 1.0)
    };
    collect(texels.map(floats)).map(TexelData::Float)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_maps_its_range() {
        for (kind, bytes) in [
            (TexelType::UnsignedByte, u8::MAX.to_ne_bytes().to_vec()),
            (TexelType::Byte, i8::MAX.to_ne_bytes().to_vec()),
            (TexelType::UnsignedShort, u16::MAX.to_ne_bytes().to_vec()),
            (TexelType::Short, i16::MAX.to_ne_bytes().to_vec()),
            (TexelType::UnsignedInt, u32::MAX.to_ne_bytes().to_vec()),
            (TexelType::Int, i32::MAX.to_ne_bytes().to_vec()),
            (TexelType::Float, 1_f32.to_ne_bytes().to_vec()),
        ] {
            assert_eq!(kind.size(), bytes.len(), "size of {kind:?}");
            assert_eq!(kind.decode(&bytes), 1.0, "the largest {kind:?}");
        }
        assert_eq!(TexelType::Byte.decode(&i8::MIN.to_ne_bytes()), -1.0, "the smallest byte");
    }

    #[test]
    fn formats_find_their_channels() {
        let decode = |bytes: &[u8], format, internal| {
            let decoded = decode_texels(bytes, format, TexelType::UnsignedByte, internal);
            let Ok(TexelData::Linear8(v)) = decoded else { panic!("bytes stay bytes") };
            v
        };
        use TexelFormat::{Bgr, Bgra, Luminance, Rgb, Rgba};
        assert_eq!(decode(&[1, 2, 3, 4, 5, 6], Bgr, Rgb), [[3, 2, 1, 255], [6, 5, 4, 255]], "blue first");
        assert_eq!(decode(&[1, 2, 3, 4], Bgra, Rgba), [[3, 2, 1, 4]], "alpha last");
        assert_eq!(decode(&[1, 2, 3, 4], Rgba, Rgb), [[1, 2, 3, 255]], "no alpha kept");
        assert_eq!(decode(&[7], Luminance, Rgba), [[7, 7, 7, 255]], "grey");
        assert_eq!(
            decode(&[1, 2, 3], Rgb, Luminance),
            [[1, 1, 1, 255]],
            "red is the luminance, as in OpenGL"
        );
    }
}
