// SPDX-License-Identifier: GPL-3.0-or-later
//! PNG: 8 or 16 bits per channel in sRGB with opacity when written; its chunks are checked before it is decoded.
//! From the PNG specification, third edition. In: linear light. Out: straight opacity. Invariants: the same picture gives
//! the same bytes (no time, no metadata but the program's name); NaN becomes 0. Tests: `tests/round_trip.rs`.

use std::fs::File;
use std::io::{BufWriter, Write};

use super::bands::{BandWriter, Bands};
use super::format::{PictureFormat, Signature};
use super::options::{Workers, WriteOptions};
use super::raster;
use crate::{Error, Picture, TexelData, Texels, screen_bytes, srgb};

/// The format.
pub(super) const FORMAT: PictureFormat = PictureFormat {
    name: "PNG",
    extensions: &["png"],
    notes: "sRGB, 8 or 16 bits; profiles are applied",
    is_for_screens: true,
    has_opacity: true,
    has_layers: false,
    is_whole: true,
    signature: Signature::Head(|head| head.starts_with(b"\x89PNG\r\n\x1a\n")),
    read: raster::PNG,
    write: Some(|picture, options, _| encode(picture, options)),
    bands: Some(BandWriter { unit: |_| Ok(1), write: write_bands }),
};

fn encode(picture: &Picture, options: &WriteOptions) -> Result<Vec<u8>, Error> {
    let meaning = Some(png::SrgbRenderingIntent::RelativeColorimetric);
    let size = [picture.width, picture.height];
    let (depth, compression) = (depth(options), png::Compression::default());
    encode_with(size, png::ColorType::Rgba, depth, compression, meaning, &pixels(picture, options))
}

/// Row after row, in the compression of [`encode`].
fn write_bands(file: &mut File, bands: &mut Bands, options: &WriteOptions, _: Workers) -> Result<(), Error> {
    let [width, height] = bands.size;
    let meaning = Some(png::SrgbRenderingIntent::RelativeColorimetric);
    let file = BufWriter::new(file);
    let encoder = encoder(
        file,
        [width, height],
        png::ColorType::Rgba,
        depth(options),
        png::Compression::default(),
        meaning,
    );
    let mut header = encoder.and_then(png::Encoder::write_header).map_err(|error| bands.failed(&error))?;
    let mut writer = header.stream_writer().map_err(|error| bands.failed(&error))?;
    while let Some((_, band)) = bands.next()? {
        writer.write_all(&pixels(&band, options)).map_err(|error| bands.failed(&error))?;
    }
    writer.finish().map_err(|error| bands.failed(&error))
}

fn depth(options: &WriteOptions) -> png::BitDepth {
    if options.png_16_bits { png::BitDepth::Sixteen } else { png::BitDepth::Eight }
}

/// The numbers of all pixels.
fn pixels(picture: &Picture, options: &WriteOptions) -> Vec<u8> {
    if options.png_16_bits {
        return wide_pixels(picture, options);
    }
    let bytes = |color| screen_bytes(color, options.tone, options.exposure);
    picture.on_screen().flat_map(bytes).collect()
}

/// With 16 bits for each channel.
fn wide_pixels(picture: &Picture, options: &WriteOptions) -> Vec<u8> {
    let gain = options.exposure.exp2();
    // `as` saturates and turns NaN into 0.
    let wide = |value: f32| ((value * 65535.0 + 0.5) as u16).to_be_bytes();
    let texel = |[r, g, b, a]: [f32; 4]| {
        let [r, g, b] = options.tone.apply_rgb([r * gain, g * gain, b * gain]).map(srgb::encode);
        [r, g, b, a].map(wide)
    };
    picture.on_screen().flat_map(texel).flatten().collect()
}

/// The bytes of the PNG file of a screen of that many columns and rows, row by row from the upper left pixel; pixels are
/// `0x00RRGGBB`. Quick rather than small.
///
/// # Errors
/// [`Error::Shape`] if there are more or fewer pixels than that, or none.
pub fn encode_screen(size: [u32; 2], pixels: &[u32]) -> Result<Vec<u8>, Error> {
    let channels = |&pixel: &u32| [16, 8, 0].map(|shift| (pixel >> shift) as u8);
    let pixels: Vec<u8> = pixels.iter().flat_map(channels).collect();
    encode_bytes(size, png::ColorType::Rgb, png::Compression::Fast, &pixels)
}

fn encode_bytes(
    size: [u32; 2],
    channels: png::ColorType,
    compression: png::Compression,
    pixels: &[u8],
) -> Result<Vec<u8>, Error> {
    let meaning = Some(png::SrgbRenderingIntent::RelativeColorimetric);
    encode_with(size, channels, png::BitDepth::Eight, compression, meaning, pixels)
}

fn encode_with(
    size: [u32; 2],
    channels: png::ColorType,
    depth: png::BitDepth,
    compression: png::Compression,
    meaning: Option<png::SrgbRenderingIntent>,
    pixels: &[u8],
) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let written = encoder(&mut bytes, size, channels, depth, compression, meaning)
        .and_then(png::Encoder::write_header)
        .and_then(|mut writer| writer.write_image_data(pixels).and_then(|()| writer.finish()));
    written.map_err(|error| Error::Shape(format!("it does not fit a PNG: {error}")))?;
    Ok(bytes)
}

/// The beginning of a file.
fn encoder<W: Write>(
    file: W,
    [width, height]: [u32; 2],
    channels: png::ColorType,
    depth: png::BitDepth,
    compression: png::Compression,
    meaning: Option<png::SrgbRenderingIntent>,
) -> Result<png::Encoder<'static, W>, png::EncodingError> {
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(channels);
    encoder.set_depth(depth);
    encoder.set_compression(compression);
    if let Some(intent) = meaning {
        encoder.set_source_srgb(intent);
    }
    encoder.add_text_chunk("Software".into(), crate::SOFTWARE.into())?;
    Ok(encoder)
}

/// The bytes of a texture's PNG file, 8 or 16 bits per channel as its values need. Bytes stay the bytes that they are;
/// floats are cut to `[0, 1]`, and sRGB-encoded unless they are `measures` (normals, roughness), which stay linear.
///
/// # Errors
/// [`Error::Shape`] if the number of values is not that of its columns and rows.
pub fn encode_texels(texels: &Texels, measures: bool) -> Result<Vec<u8>, Error> {
    if let TexelData::Tiled(_) = texels.data {
        return encode_texels(&texels.clone().resident(), measures);
    }
    let size = [texels.width, texels.height];
    let meaning = if measures { None } else { Some(png::SrgbRenderingIntent::RelativeColorimetric) };
    let (depth, bytes): (_, Vec<u8>) = match &texels.data {
        TexelData::Srgb8(pixels) | TexelData::Linear8(pixels) => {
            (png::BitDepth::Eight, pixels.iter().flatten().copied().collect())
        }
        TexelData::Linear16(_) | TexelData::Float(_) | TexelData::Tiled(_) => {
            // `clamp` keeps a NaN; `as` makes it 0.
            let wide = |x: f32| ((x.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16).to_be_bytes();
            let color = |x: f32| wide(if measures { x } else { srgb::encode(x.clamp(0.0, 1.0)) });
            let texel = |[r, g, b, a]: [f32; 4]| [color(r), color(g), color(b), wide(a)];
            let [width, height] = size.map(|n| n as usize);
            let pixel_positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let all = pixel_positions.map(|(x, y)| texels.texel(x, y));
            (png::BitDepth::Sixteen, all.flat_map(texel).flatten().collect())
        }
    };
    encode_with(size, png::ColorType::Rgba, depth, png::Compression::default(), meaning, &bytes)
}
