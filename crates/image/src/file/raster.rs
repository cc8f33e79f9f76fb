// SPDX-License-Identifier: GPL-3.0-or-later
//! PNG, JPEG, TGA, BMP and WebP, decoded by the `image` library behind checks of our own.
//! Source: original. In: bytes. Out: texels, rows from the top: 8-bit values as they are, 16-bit ones as linear floats.
//! Invariants: sizes are checked against `limits` before pixels are decoded; a panic of the library becomes an error.
//! Colour profiles and orientation tags are not read. Proof: `tests/{round_trip,broken}.rs`.

use std::io::SeekFrom;
use std::panic::{AssertUnwindSafe, catch_unwind};

use image::codecs::{
    bmp::BmpDecoder, jpeg::JpegDecoder, png::PngDecoder, tga::TgaDecoder, webp::WebPDecoder,
};
use image::{DynamicImage, ImageDecoder, ImageResult, Limits};

use super::limits::{check_bytes, check_density};
use super::{Source, jpeg, png};
use crate::{Error, TexelData, Texels, srgb};

/// A format that the library decodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RasterFormat {
    Png,
    Jpeg,
    Tga,
    Bmp,
    Webp,
}

/// What integers of a file mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// sRGB colours.
    Color,
    /// Linear values.
    Measure,
}

/// Pixels that a byte of a run-length encoded picture holds at most: runs of 128 or 255 in two bytes.
const RUN_PIXELS_PER_BYTE: u64 = 128;

/// Pixels that a byte of a WebP is believed to hold: flat areas of it take next to nothing.
const WEBP_PIXELS_PER_BYTE: u64 = 1024;

/// Memory that a decoder may take beside the pixels: tables, profiles, texts.
const EXTRA_BYTES: u64 = 1 << 26;

impl RasterFormat {
    fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Tga => "TGA",
            Self::Bmp => "BMP",
            Self::Webp => "WebP",
        }
    }
}

pub(super) fn decode(
    source: &mut dyn Source,
    length: u64,
    format: RasterFormat,
    meaning: Meaning,
) -> Result<Texels, Error> {
    let library_error = |error: image::ImageError| Error::corrupt(format.name(), describe(&error));
    let decoded = catch_unwind(AssertUnwindSafe(|| match format {
        RasterFormat::Png => {
            let limits = alloc_limits(png::check(source, length)?);
            PngDecoder::with_limits(source, limits)
                .and_then(DynamicImage::from_decoder)
                .map_err(library_error)
        }
        RasterFormat::Jpeg => {
            jpeg::check(source, length)?;
            JpegDecoder::new(source).and_then(DynamicImage::from_decoder).map_err(library_error)
        }
        RasterFormat::Tga => {
            check_tga(source, length)?;
            TgaDecoder::new(source).and_then(DynamicImage::from_decoder).map_err(library_error)
        }
        RasterFormat::Bmp => decode_checked(BmpDecoder::new(source), length, format, RUN_PIXELS_PER_BYTE),
        RasterFormat::Webp => {
            check_webp(source, length)?;
            decode_checked(WebPDecoder::new(source), length, format, WEBP_PIXELS_PER_BYTE)
        }
    }));
    let image =
        decoded.unwrap_or_else(|_| Err(Error::corrupt(format.name(), "the data contradicts itself")))?;
    texels(image, meaning)
}

fn decode_checked(
    decoder: ImageResult<impl ImageDecoder>,
    length: u64,
    format: RasterFormat,
    pixels_per_byte: u64,
) -> Result<DynamicImage, Error> {
    let library_error = |error: image::ImageError| Error::corrupt(format.name(), describe(&error));
    let decoder = decoder.map_err(library_error)?;
    let (width, height) = decoder.dimensions();
    check_density(format.name(), [u64::from(width), u64::from(height)], length, pixels_per_byte)?;
    DynamicImage::from_decoder(decoder).map_err(library_error)
}

fn alloc_limits(pixel_bytes: u64) -> Limits {
    let mut limits = Limits::no_limits();
    // Palettes and low depths grow by up to 8 x 4 when expanded to bytes.
    limits.max_alloc = Some(pixel_bytes.saturating_mul(33).saturating_add(EXTRA_BYTES));
    limits
}

/// Checks a TGA's header, which has no magic number, and its length.
fn check_tga(source: &mut dyn Source, length: u64) -> Result<(), Error> {
    let mut header = [0; 18];
    source.read_exact(&mut header).map_err(Error::reading)?;
    source.seek(SeekFrom::Start(0)).map_err(Error::reading)?;
    let size = [12, 14].map(|at| u64::from(u16::from_le_bytes([header[at], header[at + 1]])));
    let [image_type, depth] = [header[2], header[16]];
    match image_type {
        1..=3 => check_bytes("TGA", size, 18 + size[0] * size[1] * u64::from(depth).div_ceil(8), length),
        9..=11 => check_density("TGA", size, length, RUN_PIXELS_PER_BYTE),
        _ => Err(Error::corrupt("TGA", format!("there is no image type {image_type}"))),
    }
}

/// Checks the length that a WebP's container declares: the decoder takes some truncated files for whole ones.
fn check_webp(source: &mut dyn Source, length: u64) -> Result<(), Error> {
    let mut header = [0; 12];
    source.read_exact(&mut header).map_err(Error::reading)?;
    source.seek(SeekFrom::Start(0)).map_err(Error::reading)?;
    let declared = u64::from(u32::from_le_bytes([header[4], header[5], header[6], header[7]])) + 8;
    if declared > length {
        return Err(Error::corrupt(
            "WebP",
            format!("{length} of {declared} bytes are there; it is truncated"),
        ));
    }
    Ok(())
}

fn texels(image: DynamicImage, meaning: Meaning) -> Result<Texels, Error> {
    let (width, height) = (image.width(), image.height());
    let sixteen_bits = matches!(
        image,
        DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_)
    );
    let data = if sixteen_bits {
        let unit = |value: u16| f32::from(value) / 65535.0;
        let color = |value| if meaning == Meaning::Color { srgb::decode_u16(value) } else { unit(value) };
        let pixels = image.into_rgba16();
        let texel = |p: &image::Rgba<u16>| [color(p[0]), color(p[1]), color(p[2]), unit(p[3])];
        TexelData::Float(pixels.pixels().map(texel).collect())
    } else {
        let bytes = bytemuck::try_cast_vec(image.into_rgba8().into_raw());
        let pixels = bytes.map_err(|_| Error::corrupt("picture", "its pixels are incomplete"))?;
        if meaning == Meaning::Color { TexelData::Srgb8(pixels) } else { TexelData::Linear8(pixels) }
    };
    Ok(Texels { width, height, data })
}

/// The library's words on one line, without the format's name, which ours say already.
fn describe(error: &image::ImageError) -> String {
    let words = match error {
        image::ImageError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            "the file ends too early".into()
        }
        image::ImageError::Limits(_) => "it needs too much memory".into(),
        _ => std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string),
    };
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}
