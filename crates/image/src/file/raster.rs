// SPDX-License-Identifier: GPL-3.0-or-later
//! PNG, JPEG, TGA, BMP and WebP, decoded by the `image` library behind checks of our own.
//! In: bytes. Out: texels, rows from the top: 8-bit values as they are, 16-bit ones of measures too, those of colours as linear floats.
//! Invariants: sizes and memory are checked against `limits` before pixels are decoded; a panic of the
//! library becomes an error. Colour profiles (`icc`) are applied to colours, orientation tags to all. Tests:
//! `tests/{round_trip,broken,profiles}.rs`.

use std::io::SeekFrom;

use image::codecs::{
    bmp::BmpDecoder, jpeg::JpegDecoder, png::PngDecoder, tga::TgaDecoder, webp::WebPDecoder,
};
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, Limits};

use super::format::{Meaning, PictureFormat, Readers, Signature};
use super::guard::decode_guarded;
use super::limits::{PICTURE_BYTES, check_bytes, check_density};
use super::source::Source;
use super::{icc, jpeg, png_chunks, screens, webp};
use crate::{Budget, Error, Picture, Stored, StoredValues, TexelData, Texels, srgb};

/// A format that the library decodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RasterFormat {
    Png,
    Jpeg,
    Tga,
    Bmp,
    Webp,
}

/// Pixels that a byte of a run-length encoded picture holds at most: runs of 128 or 255 in two bytes.
const RUN_PIXELS_PER_BYTE: u64 = 128;

/// Pixels that a byte of a WebP is believed to hold: flat areas of it take next to nothing.
const WEBP_PIXELS_PER_BYTE: u64 = 1024;

/// Memory that a decoder may take in addition to the pixels: tables, profiles, texts.
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

/// The readers of a format that the library decodes.
macro_rules! reader {
    ($format:expr) => {
        Readers {
            picture: |source, length, budget, _| picture(source, length, $format, budget),
            texels: Some(|source, length, meaning, budget| texels(source, length, $format, meaning, budget)),
            stored: Some(|source, length, budget| stored(source, length, $format, budget)),
        }
    };
}

/// The readers of PNG.
pub(super) const PNG: Readers = reader!(RasterFormat::Png);

const READ_ONLY: PictureFormat = PictureFormat {
    name: "",
    extensions: &[],
    notes: "no colour profiles",
    is_for_screens: false,
    has_opacity: false,
    has_layers: false,
    is_whole: true,
    signature: Signature::Head(|_| false),
    read: PNG,
    write: None,
    bands: None,
};

/// The format.
pub(super) const JPEG: PictureFormat = PictureFormat {
    name: "JPEG",
    extensions: &["jpg", "jpeg"],
    notes: "8 bits, sRGB; profiles and orientation are applied",
    is_for_screens: true,
    signature: Signature::Head(|head| head.starts_with(&[0xff, 0xd8, 0xff])),
    read: reader!(RasterFormat::Jpeg),
    write: Some(|picture, options, _| screens::encode_jpeg(picture, options)),
    ..READ_ONLY
};

/// The format.
pub(super) const TGA: PictureFormat = PictureFormat {
    name: "TGA",
    extensions: &["tga", "icb", "vda", "vst"],
    signature: Signature::Foot(b"TRUEVISION-XFILE.\0"),
    read: reader!(RasterFormat::Tga),
    ..READ_ONLY
};

/// The format.
pub(super) const BMP: PictureFormat = PictureFormat {
    name: "BMP",
    extensions: &["bmp"],
    signature: Signature::Head(|head| head.starts_with(b"BM")),
    read: reader!(RasterFormat::Bmp),
    ..READ_ONLY
};

/// The format.
pub(super) const WEBP: PictureFormat = PictureFormat {
    name: "WebP",
    extensions: &["webp"],
    notes: "written without loss; first frame of an animation",
    is_for_screens: true,
    has_opacity: true,
    signature: Signature::Head(|head| head.starts_with(b"RIFF") && head.ends_with(b"WEBP")),
    read: reader!(RasterFormat::Webp),
    write: Some(|picture, options, _| screens::encode_webp(picture, options)),
    ..READ_ONLY
};

/// The picture in linear light.
fn picture(
    source: &mut dyn Source,
    length: u64,
    format: RasterFormat,
    budget: &Budget,
) -> Result<Picture, Error> {
    let request = Request { floats: true, wide: PICTURE_BYTES, is_color: true, space: None, budget };
    Ok(texels_of(decode(source, length, format, request)?, Meaning::Color)?.into())
}

/// The picture as a texture.
fn texels(
    source: &mut dyn Source,
    length: u64,
    format: RasterFormat,
    meaning: Meaning,
    budget: &Budget,
) -> Result<Texels, Error> {
    let is_color = meaning == Meaning::Color;
    let request = Request { floats: false, wide: 8, is_color, space: None, budget };
    let image = decode(source, length, format, request)?;
    if is_color && is_wide(image.color()) { colors_of(image) } else { texels_of(image, meaning) }
}

/// The picture as it is stored.
fn stored(
    source: &mut dyn Source,
    length: u64,
    format: RasterFormat,
    budget: &Budget,
) -> Result<Stored, Error> {
    let request = Request { floats: false, wide: PICTURE_BYTES, is_color: false, space: None, budget };
    let image = decode(source, length, format, request)?;
    let size = [image.width() as usize, image.height() as usize];
    let channels = usize::from(image.color().channel_count());
    let values = match image {
        DynamicImage::ImageLuma8(image) => StoredValues::U8(image.into_raw()),
        DynamicImage::ImageLumaA8(image) => StoredValues::U8(image.into_raw()),
        DynamicImage::ImageRgb8(image) => StoredValues::U8(image.into_raw()),
        DynamicImage::ImageRgba8(image) => StoredValues::U8(image.into_raw()),
        DynamicImage::ImageLuma16(image) => StoredValues::U16(image.into_raw()),
        DynamicImage::ImageLumaA16(image) => StoredValues::U16(image.into_raw()),
        DynamicImage::ImageRgb16(image) => StoredValues::U16(image.into_raw()),
        DynamicImage::ImageRgba16(image) => StoredValues::U16(image.into_raw()),
        _ => return Err(Error::corrupt(format.name(), "its pixel format is unsupported")),
    };
    Ok(Stored::plain(size, channels, values))
}

/// The requested form of a picture, and its budget.
#[derive(Clone)]
struct Request<'a> {
    /// Whether bytes become floats in the end.
    floats: bool,
    /// Bytes that a texel of 16-bit values becomes.
    wide: u64,
    /// Whether it holds colours, which have a profile.
    is_color: bool,
    /// The space of its colours by chunks of its own.
    space: Option<icc::Conversion>,
    budget: &'a Budget,
}

fn decode(
    source: &mut dyn Source,
    length: u64,
    format: RasterFormat,
    request: Request<'_>,
) -> Result<DynamicImage, Error> {
    let library_error = |error: image::ImageError| Error::corrupt(format.name(), describe(&error));
    decode_guarded(format.name(), || match format {
        // In addition to the pixels a decoder takes rows, or for each pixel a number of bytes of
        // coefficients, planes or frames.
        RasterFormat::Png => {
            let (pixel_bytes, space) = png_chunks::check(source, length)?;
            let limits = alloc_limits(pixel_bytes, request.budget);
            let space =
                space.filter(|_| request.is_color).and_then(|space| icc::Conversion::of_space(&space));
            let request = Request { space, ..request };
            let decoder = PngDecoder::with_limits(source, limits).map_err(library_error)?;
            decode_within(Box::new(decoder), Sidecar::pixels(0), format, request)
        }
        RasterFormat::Jpeg => {
            let in_scans = jpeg::check(source, length)?;
            let decoder = JpegDecoder::new(source).map_err(library_error)?;
            decode_within(Box::new(decoder), Sidecar::pixels(if in_scans { 8 } else { 0 }), format, request)
        }
        RasterFormat::Tga => {
            check_tga(source, length)?;
            let decoder = TgaDecoder::new(source).map_err(library_error)?;
            decode_within(Box::new(decoder), Sidecar::pixels(4), format, request)
        }
        RasterFormat::Bmp => {
            let decoder = BmpDecoder::new(source).map_err(library_error)?;
            check_density(format.name(), size_of(&decoder), length, RUN_PIXELS_PER_BYTE)?;
            decode_within(Box::new(decoder), Sidecar::pixels(4), format, request)
        }
        RasterFormat::Webp => {
            let tables = webp::check(source, length, request.budget)?;
            let decoder = WebPDecoder::new(source).map_err(library_error)?;
            check_density(format.name(), size_of(&decoder), length, WEBP_PIXELS_PER_BYTE)?;
            // An animation's frame is put together with those before.
            let pixel_bytes = if decoder.has_animation() { 16 } else { 8 };
            decode_within(Box::new(decoder), Sidecar { pixel_bytes, bytes: tables }, format, request)
        }
    })
}

fn size_of(decoder: &dyn ImageDecoder) -> [u64; 2] {
    let (width, height) = decoder.dimensions();
    [u64::from(width), u64::from(height)]
}

/// Memory of a decoder in addition to its output.
#[derive(Clone, Copy)]
struct Sidecar {
    /// For each pixel.
    pixel_bytes: u64,
    /// For all.
    bytes: u64,
}

impl Sidecar {
    fn pixels(pixel_bytes: u64) -> Self {
        Self { pixel_bytes, bytes: 0 }
    }
}

/// Decodes within the memory budget, upright.
fn decode_within(
    mut decoder: Box<dyn ImageDecoder + '_>,
    beside: Sidecar,
    format: RasterFormat,
    request: Request<'_>,
) -> Result<DynamicImage, Error> {
    let color = decoder.color_type();
    let native = u64::from(color.bytes_per_pixel());
    let texel = if is_wide(color) { request.wide } else { 4 };
    // First the decoder's memory and its output, then the output and the texels, then those and the floats.
    let last = if request.floats && texel < PICTURE_BYTES { texel + PICTURE_BYTES } else { 0 };
    let size = size_of(&*decoder);
    let decoded = (native + texel).max(last);
    request.budget.check(format.name(), size, decoded.max(beside.pixel_bytes + native))?;
    request.budget.check_bytes(size, size[0] * size[1] * (beside.pixel_bytes + native) + beside.bytes)?;
    let broken = |error: image::ImageError| Error::corrupt(format.name(), describe(&error));
    // A broken tag means nothing.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let profile = match request.is_color {
        true => decoder.icc_profile().ok().flatten().and_then(|bytes| icc::Conversion::of_profile(&bytes)),
        false => None,
    };
    let mut image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    if let Some(conversion) = profile.or(request.space) {
        conversion.apply(&mut image);
    }
    if orientation != Orientation::NoTransforms {
        // Sides may change places, for which the pixels are there twice.
        request.budget.check(format.name(), size, 2 * native)?;
        image.apply_orientation(orientation);
    }
    Ok(image)
}

/// Whether a channel has more than eight bits.
fn is_wide(color: image::ColorType) -> bool {
    color.bytes_per_pixel() > color.channel_count()
}

fn alloc_limits(pixel_bytes: u64, budget: &Budget) -> Limits {
    let mut limits = Limits::no_limits();
    // Palettes and low depths grow by up to 8 x 4 when expanded to bytes.
    let needed = pixel_bytes.saturating_mul(33).saturating_add(EXTRA_BYTES);
    limits.max_alloc = Some(needed.min(budget.left()));
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
        _ => Err(Error::corrupt("TGA", format!("unknown image type {image_type}"))),
    }
}

fn texels_of(image: DynamicImage, meaning: Meaning) -> Result<Texels, Error> {
    let (width, height) = (image.width(), image.height());
    if meaning == Meaning::Measure {
        return measures_of(image);
    }
    let unit = |value: u16| f32::from(value) / 65535.0;
    let color = srgb::decode_u16;
    let grey = |value, alpha| {
        let value = color(value);
        [value, value, value, alpha]
    };
    let data = match image {
        DynamicImage::ImageLuma16(image) => {
            TexelData::Float(image.pixels().map(|p| grey(p[0], 1.0)).collect())
        }
        DynamicImage::ImageLumaA16(image) => {
            TexelData::Float(image.pixels().map(|p| grey(p[0], unit(p[1]))).collect())
        }
        DynamicImage::ImageRgb16(image) => {
            let texel = |p: &image::Rgb<u16>| [color(p[0]), color(p[1]), color(p[2]), 1.0];
            TexelData::Float(image.pixels().map(texel).collect())
        }
        DynamicImage::ImageRgba16(image) => {
            let texel = |p: &image::Rgba<u16>| [color(p[0]), color(p[1]), color(p[2]), unit(p[3])];
            TexelData::Float(image.pixels().map(texel).collect())
        }
        image => {
            let bytes = bytemuck::try_cast_vec(image.into_rgba8().into_raw());
            TexelData::Srgb8(bytes.map_err(|_| incomplete())?)
        }
    };
    Ok(Texels { width, height, data })
}

/// Colours of 16 bits as linear numbers of 16 bits: off by 1/131070 at most, where a float would take twice
/// the memory.
fn colors_of(image: DynamicImage) -> Result<Texels, Error> {
    let (width, height) = (image.width(), image.height());
    let numbers = bytemuck::try_cast_vec::<u16, [u16; 4]>(image.into_rgba16().into_raw());
    let mut texels = numbers.map_err(|_| incomplete())?;
    for [r, g, b, _] in &mut texels {
        for channel in [r, g, b] {
            *channel = (srgb::decode_u16(*channel) * 65535.0 + 0.5) as u16;
        }
    }
    Ok(Texels { width, height, data: TexelData::Linear16(texels) })
}

/// Values of measures, with the bits that they have.
fn measures_of(image: DynamicImage) -> Result<Texels, Error> {
    let (width, height) = (image.width(), image.height());
    let data = if is_wide(image.color()) {
        let numbers = bytemuck::try_cast_vec(image.into_rgba16().into_raw());
        TexelData::Linear16(numbers.map_err(|_| incomplete())?)
    } else {
        let bytes = bytemuck::try_cast_vec(image.into_rgba8().into_raw());
        TexelData::Linear8(bytes.map_err(|_| incomplete())?)
    };
    Ok(Texels { width, height, data })
}

fn incomplete() -> Error {
    Error::corrupt("picture", "its pixels are incomplete")
}

/// The library's message on one line, without the format's name, which ours contain already.
fn describe(error: &image::ImageError) -> String {
    let message = match error {
        image::ImageError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            "the file ends too early".into()
        }
        image::ImageError::Limits(_) => "it needs too much memory".into(),
        _ => std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string),
    };
    // Some come in quotes.
    message.trim_matches('"').split_whitespace().collect::<Vec<_>>().join(" ")
}
