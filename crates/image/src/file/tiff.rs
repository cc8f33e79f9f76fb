// SPDX-License-Identifier: GPL-3.0-or-later
//! TIFF, as cameras, scanners and makers of textures (`.tx`) write it: grey or RGB, with or without opacity and further channels.
//! Source: TIFF 6.0; the `tiff` library decodes strips and tiles, whole or packed by LZW, deflate or runs of bytes. Tags of textures
//! are those of Pixar and OpenImageIO. Directories that follow and are half as large each are the smaller copies of a picture.
//! Invariants: sizes are checked against `limits` before pixels are decoded; a panic of the library becomes an error.
//! Not read, with an error: palettes, CMYK, channels that are stored one after the other, fewer than 8 bits.
//! Tests: `tests/{round_trip,broken}.rs`.

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::format::{Meaning, PictureFormat, Readers, Signature};
use super::guard::decode_guarded;
use super::limits::{PICTURE_BYTES, check_density};
use super::source::Source;
use crate::{Budget, Error, Picture, Stored, StoredLevel, StoredValues, TexelData, Texels, srgb};

/// Most pixels that a byte of the file can become: deflate's 1032 bytes of one channel.
const MOST_DENSE: u64 = 1032;
/// Most bytes of a text or a list of offsets.
const TAG_BYTES: usize = 16 << 20;
/// Most channels.
const MAX_CHANNELS: usize = 64;
/// Levels of the largest picture.
const MAX_LEVELS: usize = 32;
/// The tag's value for opacity that colours are multiplied with.
const ASSOCIATED: u16 = 1;

/// The format.
pub(super) const FORMAT: PictureFormat = PictureFormat {
    name: "TIFF",
    extensions: &["tif", "tiff"],
    notes: "grey and RGB of 8 bits and more; no palettes, CMYK, separate planes",
    is_for_screens: false,
    has_opacity: false,
    has_layers: false,
    is_whole: false,
    signature: Signature::Head(|head| {
        matches!(head, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..])
    }),
    read: Readers {
        picture: |source, length, budget, _| {
            texels(source, length, Meaning::Color, budget).map(Picture::from)
        },
        texels: Some(texels),
        stored: Some(stored),
    },
    write: None,
    bands: None,
};

fn library_error(error: tiff::TiffError) -> Error {
    let what = match error {
        tiff::TiffError::IoError(error) => return Error::reading(error),
        tiff::TiffError::LimitsExceeded => "it needs too much memory".into(),
        tiff::TiffError::UnsupportedError(what) => format!("not supported: {what}"),
        other => other.to_string(),
    };
    // On one line, in words of users.
    let parts = what.split_whitespace().collect::<Vec<_>>().join(" ").replace("::", " ");
    Error::corrupt("TIFF", parts)
}

/// How pixels of a directory are stored.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Shape {
    size: [usize; 2],
    channels: usize,
}

type Reader<'a> = Decoder<&'a mut dyn Source>;

fn shape(reader: &mut Reader<'_>) -> Result<Shape, Error> {
    let (width, height) = reader.dimensions().map_err(library_error)?;
    let refuse = |what: &str| Err(Error::corrupt("TIFF", format!("{what} are not read, only grey and RGB")));
    let (channels, bits) = match reader.colortype().map_err(library_error)? {
        ColorType::Gray(bits) => (1, bits),
        ColorType::GrayA(bits) => (2, bits),
        ColorType::RGB(bits) => (3, bits),
        ColorType::RGBA(bits) => (4, bits),
        ColorType::Multiband { bit_depth, num_samples } => (usize::from(num_samples), bit_depth),
        ColorType::Palette(_) => return refuse("palettes"),
        _ => return refuse("CMYK, YCbCr and Lab"),
    };
    if bits < 8 {
        return refuse("channels of fewer than 8 bits");
    }
    if channels == 0 || channels > MAX_CHANNELS {
        return Err(Error::corrupt("TIFF", format!("{channels} channels; at most {MAX_CHANNELS} are read")));
    }
    let planes = reader.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).map_err(library_error)?;
    if planes == Some(2) && channels > 1 {
        return refuse("channels that are stored one after the other");
    }
    Ok(Shape { size: [width as usize, height as usize], channels })
}

fn values(reader: &mut Reader<'_>, shape: Shape) -> Result<StoredValues, Error> {
    let values = match reader.read_image().map_err(library_error)? {
        DecodingResult::U8(list) => StoredValues::U8(list),
        DecodingResult::U16(list) => StoredValues::U16(list),
        DecodingResult::U32(list) => {
            StoredValues::F32(list.iter().map(|&x| (f64::from(x) / f64::from(u32::MAX)) as f32).collect())
        }
        DecodingResult::F16(list) => StoredValues::F32(list.iter().map(|x| x.to_f32()).collect()),
        DecodingResult::F32(list) => StoredValues::F32(list),
        DecodingResult::F64(list) => StoredValues::F32(list.iter().map(|&x| x as f32).collect()),
        _ => return Err(Error::corrupt("TIFF", "integers with a sign are not read")),
    };
    let needed = shape.size[0] * shape.size[1] * shape.channels;
    if values.len() != needed {
        return Err(Error::corrupt("TIFF", format!("{} values instead of {needed}", values.len())));
    }
    Ok(values)
}

/// The texts of the file. OpenImageIO stores some of its own in the description, as `oiio:name=value`.
fn texts(reader: &mut Reader<'_>) -> Vec<(String, String)> {
    let known = [
        ("ImageDescription", Tag::ImageDescription),
        ("DateTime", Tag::DateTime),
        ("Software", Tag::Software),
        ("Artist", Tag::Artist),
        ("textureformat", Tag::Unknown(33302)),
        ("wrapmodes", Tag::Unknown(33303)),
    ];
    let mut found: Vec<(String, String)> = known
        .into_iter()
        .filter_map(|(name, tag)| {
            let text = reader.get_tag_ascii_string(tag).ok()?;
            Some((name.to_owned(), text.trim_end_matches('\0').to_owned()))
        })
        .collect();
    let description = found.iter().find(|(name, _)| name == "ImageDescription").map(|(_, text)| text.clone());
    for token in description.iter().flat_map(|text| text.split_whitespace()) {
        if let Some((name, value)) = token.split_once('=').filter(|(name, _)| name.starts_with("oiio:")) {
            found.push((name.to_owned(), value.to_owned()));
        }
    }
    found
}

/// The first picture of the file and the smaller copies of it that follow.
fn stored(source: &mut dyn Source, length: u64, budget: &Budget) -> Result<Stored, Error> {
    read(source, length, budget, true).map(|(stored, _)| stored)
}

/// The first picture of the file and, where `all`, the smaller copies of it that follow; and whether its colours are multiplied with their opacity.
fn read(source: &mut dyn Source, length: u64, budget: &Budget, all: bool) -> Result<(Stored, bool), Error> {
    decode_guarded("TIFF", || {
        let limits = {
            let mut limits = Limits::default();
            limits.decoding_buffer_size = usize::try_from(budget.left()).unwrap_or(usize::MAX);
            limits.intermediate_buffer_size = limits.decoding_buffer_size;
            limits.ifd_value_size = TAG_BYTES;
            limits
        };
        let mut reader: Reader<'_> = Decoder::new(source).map_err(library_error)?.with_limits(limits);
        let first = shape(&mut reader)?;
        let size = first.size.map(|n| n as u64);
        check_density("TIFF", size, length, MOST_DENSE)?;
        // Values of at most 8 bytes, the stored ones, and the result; smaller copies are a third more of the
        // stored ones.
        let copies = if all { 2 } else { 0 };
        budget.check("TIFF", size, first.channels as u64 * (8 + 4 + copies) + PICTURE_BYTES)?;
        let values_of_first = values(&mut reader, first)?;
        let mut stored = Stored::plain(first.size, first.channels, values_of_first);
        if let ColorType::Multiband { num_samples: 4.., .. } = reader.colortype().map_err(library_error)? {
            stored.alpha = Some(3);
        }
        let extra = reader.find_tag_unsigned_vec::<u16>(Tag::ExtraSamples).ok().flatten();
        let is_associated = extra.is_some_and(|kinds| kinds.first() == Some(&ASSOCIATED));
        stored.levels[0].tile = tile(&mut reader);
        stored.texts = texts(&mut reader);
        while all && reader.more_images() && stored.levels.len() < MAX_LEVELS {
            reader.next_image().map_err(library_error)?;
            let next = shape(&mut reader)?;
            let before = &stored.levels[stored.levels.len() - 1];
            let halves = [before.width, before.height].map(|n| (n / 2).max(1));
            if next.channels != first.channels || next.size != halves {
                break;
            }
            let values = values(&mut reader, next)?;
            let [width, height] = next.size;
            stored.levels.push(StoredLevel { width, height, tile: tile(&mut reader), values });
        }
        Ok((stored, is_associated))
    })
}

fn tile(reader: &mut Reader<'_>) -> Option<[usize; 2]> {
    let side = |reader: &mut Reader<'_>, tag| reader.find_tag_unsigned::<u32>(tag).ok().flatten();
    let (width, height) = (side(reader, Tag::TileWidth)?, side(reader, Tag::TileLength)?);
    Some([width as usize, height as usize])
}

/// Divides colours by their opacity, which is the last channel. Fully transparent colours are unchanged.
fn straighten(values: &mut StoredValues, channels: usize) {
    fn divide<T: Copy>(list: &mut [T], channels: usize, by: impl Fn(T, T) -> T) {
        for pixel in list.chunks_exact_mut(channels) {
            let opacity = pixel[channels - 1];
            pixel[..channels - 1].iter_mut().for_each(|x| *x = by(*x, opacity));
        }
    }
    let whole = |x: u32, opacity: u32, most: u32| match opacity {
        0 => x,
        _ => ((x * most + opacity / 2) / opacity).min(most),
    };
    match values {
        StoredValues::U8(list) => divide(list, channels, |x, a| whole(x.into(), a.into(), 255) as u8),
        StoredValues::U16(list) => {
            divide(list, channels, |x, a| {
                let (x, a) = (u64::from(x), u64::from(a));
                (x * 65535 + a / 2).checked_div(a).map_or(x as u16, |x| x.min(65535) as u16)
            });
        }
        StoredValues::F32(list) => divide(list, channels, |x, a| if a > 0.0 { x / a } else { x }),
    }
}

/// The picture as a texture: bytes stay bytes, numbers of 16 bits that are measures too, others become linear floats.
fn texels(source: &mut dyn Source, length: u64, meaning: Meaning, budget: &Budget) -> Result<Texels, Error> {
    let (Stored { channels, mut levels, .. }, is_associated) = read(source, length, budget, false)?;
    let StoredLevel { width, height, mut values, .. } = levels.swap_remove(0);
    if is_associated && matches!(channels, 2 | 4) {
        straighten(&mut values, channels);
    }
    // Grey is red, green and blue at once.
    let channel_index = |c: usize| match (c, channels) {
        (0..=2, 1 | 2) => Some(0),
        (3, 2) => Some(1),
        (c, n) if c < n => Some(c),
        _ => None,
    };
    let data = match values {
        StoredValues::U8(list) => {
            let pixels = list.chunks_exact(channels);
            let pixels =
                pixels.map(|p| std::array::from_fn(|c| channel_index(c).map_or(255, |k| p[k]))).collect();
            if meaning == Meaning::Color { TexelData::Srgb8(pixels) } else { TexelData::Linear8(pixels) }
        }
        StoredValues::U16(list) => {
            let pixels = list.chunks_exact(channels);
            if meaning == Meaning::Measure {
                let whole = |p: &[u16]| std::array::from_fn(|c| channel_index(c).map_or(u16::MAX, |k| p[k]));
                let data = TexelData::Linear16(pixels.map(whole).collect());
                return Ok(Texels { width: width as u32, height: height as u32, data });
            }
            let value = |c: usize, x: u16| match c {
                0..=2 => srgb::decode_u16(x),
                _ => f32::from(x) / 65535.0,
            };
            let pixel = |p: &[u16]| std::array::from_fn(|c| channel_index(c).map_or(1.0, |k| value(c, p[k])));
            TexelData::Float(pixels.map(pixel).collect())
        }
        StoredValues::F32(list) => {
            let pixels = list.chunks_exact(channels);
            let pixel = |p: &[f32]| std::array::from_fn(|c| channel_index(c).map_or(1.0, |k| p[k]));
            TexelData::Float(pixels.map(pixel).collect())
        }
    };
    Ok(Texels { width: width as u32, height: height as u32, data })
}
