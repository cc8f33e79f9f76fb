// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures (rtGenTextures, rtBindTexture, rtTexImage2D, rtTexParameteri, rtDeleteTexture).
//! Source: original, after OpenGL 1.x. Integers are linear light: bytes map to value / 255 without sRGB decoding.
//! Invariant: an image has its first row at t = 0. Proof: `tests`; tests/c/scene.c, tests/c/errors.c.

use std::collections::BTreeMap;
use std::sync::Arc;

use gnurt::image::{TexelData, Texels};
use gnurt::shading::mipmap::{Minify, MipMap};
use gnurt::shading::texture::{TextureSampler, Wrap};

use crate::context::Context;
use crate::enums::{
    MinifyFilter, TexelFormat, TexelType, TextureFilter, TextureParameter, TextureTarget, TextureWrap,
};
use crate::error::{Error, Result, not_null};
use crate::ids::Ids;

/// `v = 1 - t`: samplers have the first row at v = 1, OpenRT has it at t = 0.
const FIRST_ROW_AT_0: [f32; 6] = [1.0, 0.0, 0.0, -1.0, 0.0, 1.0];

/// Texels along one side at most.
const MAX_SIZE: i32 = 1 << 15;

/// A texture; without an image it is white.
#[derive(Clone, Debug, Default)]
struct Texture {
    image: Option<Arc<Texels>>,
    wrap: [Wrap; 2],
    /// Smaller copies of the image.
    mips: Option<Arc<MipMap>>,
    /// Linear if the program has not said.
    filter: Option<TextureFilter>,
    /// Linear if the program has not said.
    minify: Option<MinifyFilter>,
}

/// All textures and which of them is bound.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    ids: Ids,
    /// Those that were changed since they were generated.
    changed: BTreeMap<u32, Texture>,
    bound: Option<u32>,
    /// Counts changes.
    revision: u64,
}

impl Textures {
    /// What shaders see of texture `id`; nothing if it does not exist or has no image.
    #[must_use]
    pub fn sampler(&self, id: i32) -> Option<Arc<TextureSampler>> {
        let texture = self.changed.get(&u32::try_from(id).ok()?)?;
        let texels = texture.image.clone()?;
        let linear = texture.filter != Some(TextureFilter::Nearest);
        let minify = texture.minify.unwrap_or(MinifyFilter::Linear).minify();
        // Levels between are made when a ray first wants one: on the frame's threads.
        let minify = texture.mips.clone().map(|mips| (minify, mips));
        let (wrap, uv_from_mesh) = (texture.wrap, FIRST_ROW_AT_0);
        Some(Arc::new(TextureSampler { texels, wrap, linear, minify, uv_from_mesh }))
    }

    /// Rises whenever a texture changes.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Ids of all that may have a picture.
    pub fn ids(&self) -> impl Iterator<Item = u32> + '_ {
        self.changed.keys().copied()
    }

    fn bound_mut(&mut self) -> Result<&mut Texture> {
        let id = self.bound.ok_or(Error::InvalidOperation)?;
        self.revision += 1;
        Ok(self.changed.entry(id).or_default())
    }
}

/// The numbers of rtTexImage2D.
#[derive(Clone, Copy, Debug)]
pub struct ImageDescription {
    /// Which kind of texture.
    pub target: u32,
    /// Mip level.
    pub level: i32,
    /// Channels to keep: 1, 3 or 4, or the constant of a format.
    pub internal_format: i32,
    /// Columns and rows.
    pub size: [i32; 2],
    /// Must be 0.
    pub border: i32,
    /// Channels in memory.
    pub format: u32,
    /// Type in memory.
    pub texel_type: u32,
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

    /// What a texture with this internal format keeps of a texel.
    fn keep<T: Copy>(self, [r, g, b, a]: [T; 4], one: T) -> [T; 4] {
        match self {
            Self::Luminance => [r, r, r, one],
            Self::Rgb | Self::Bgr => [r, g, b, one],
            Self::Rgba | Self::Bgra => [r, g, b, a],
        }
    }

    /// The internal format of OpenGL 1.x that `code` stands for.
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
    /// What the sampler does.
    fn minify(self) -> Minify {
        let mipmap = |linear, between_levels| Minify::Mipmap { linear, between_levels };
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

/// Texels from a program's memory. Bytes stay bytes.
fn decode_texels(bytes: &[u8], format: TexelFormat, kind: TexelType, internal: TexelFormat) -> TexelData {
    let texels = bytes.chunks_exact(format.components() * kind.size());
    if kind == TexelType::UnsignedByte {
        return TexelData::Linear8(texels.map(|v| internal.keep(format.rgba(v, 255), 255)).collect());
    }
    let floats = |texel: &[u8]| {
        let mut v = [0.0; 4];
        let numbers = texel.chunks_exact(kind.size());
        v.iter_mut().zip(numbers).for_each(|(number, bytes)| *number = kind.decode(bytes));
        internal.keep(format.rgba(&v, 1.0), 1.0)
    };
    TexelData::Float(texels.map(floats).collect())
}

impl Context {
    /// rtGenTextures.
    pub fn gen_textures(&mut self, count: i32) -> Result<u32> {
        self.outside_block()?;
        self.textures.ids.reserve(count)
    }

    /// rtBindTexture.
    pub fn bind_texture(&mut self, target: u32, id: u32) -> Result<()> {
        self.outside_block()?;
        TextureTarget::from_code(target)?;
        self.textures.bound = if id == 0 { None } else { Some(self.textures.ids.check(id)?) };
        Ok(())
    }

    /// rtTexImage2D; `read` gives that many bytes of the program's memory.
    pub fn tex_image(
        &mut self,
        description: &ImageDescription,
        read: Option<&dyn Fn(usize) -> Vec<u8>>,
    ) -> Result<()> {
        self.outside_block()?;
        let read = not_null(read)?;
        TextureTarget::from_code(description.target)?;
        let format = TexelFormat::from_code(description.format)?;
        let kind = TexelType::from_code(description.texel_type)?;
        let [width, height] = description.size;
        let sizes_fit = [width, height].iter().all(|size| (0..=MAX_SIZE).contains(size));
        let internal = TexelFormat::from_internal(description.internal_format)?;
        if !sizes_fit || description.level < 0 || description.border != 0 {
            return Err(Error::InvalidValue);
        }
        let texture = self.textures.bound_mut()?;
        if description.level > 0 {
            return Ok(());
        }
        let (width, height) = (width.unsigned_abs(), height.unsigned_abs());
        let texel_count = width as usize * height as usize;
        texture.image = (texel_count > 0).then(|| {
            let bytes = read(texel_count * format.components() * kind.size());
            Arc::new(Texels { width, height, data: decode_texels(&bytes, format, kind, internal) })
        });
        texture.mips = texture.image.clone().map(|image| Arc::new(MipMap::new(image)));
        Ok(())
    }

    /// rtTexParameteri.
    pub fn tex_parameter(&mut self, target: u32, name: u32, value: i32) -> Result<()> {
        self.outside_block()?;
        TextureTarget::from_code(target)?;
        let name = TextureParameter::from_code(name)?;
        let value = u32::try_from(value).map_err(|_| Error::InvalidEnum)?;
        match name {
            TextureParameter::MagFilter => {
                let filter = TextureFilter::from_code(value)?;
                self.textures.bound_mut()?.filter = Some(filter);
            }
            TextureParameter::MinFilter => {
                let filter = MinifyFilter::from_code(value)?;
                self.textures.bound_mut()?.minify = Some(filter);
            }
            TextureParameter::WrapS | TextureParameter::WrapT => {
                let wrap = match TextureWrap::from_code(value)? {
                    TextureWrap::Clamp | TextureWrap::ClampToEdge => Wrap::Clamp,
                    TextureWrap::Repeat => Wrap::Repeat,
                    TextureWrap::MirroredRepeat => Wrap::Mirror,
                };
                let axis = usize::from(name == TextureParameter::WrapT);
                self.textures.bound_mut()?.wrap[axis] = wrap;
            }
        }
        Ok(())
    }

    /// rtDeleteTexture.
    pub fn delete_texture(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        self.textures.ids.remove(id)?;
        self.textures.revision += 1;
        self.textures.changed.remove(&id);
        if self.textures.bound == Some(id) {
            self.textures.bound = None;
        }
        Ok(())
    }

    /// rtIsTexture.
    pub fn is_texture(&self, id: u32) -> Result<bool> {
        self.outside_block()?;
        Ok(self.textures.ids.exists(id))
    }
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
            let TexelData::Linear8(v) = decode_texels(bytes, format, TexelType::UnsignedByte, internal)
            else {
                panic!("bytes stay bytes")
            };
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
