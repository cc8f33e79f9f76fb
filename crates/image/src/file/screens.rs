// SPDX-License-Identifier: GPL-3.0-or-later
//! JPEG and WebP for screens: sRGB bytes behind exposure and tone curve.
//! In: linear light. JPEG has no opacity: what is transparent lies over black. WebP is written without loss.
//! Invariant: the same picture gives the same bytes. Tests: `tests/round_trip.rs`.

use image::codecs::{jpeg::JpegEncoder, webp::WebPEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::options::WriteOptions;
use crate::{Error, Picture, screen_bytes};

pub(super) fn encode_jpeg(picture: &Picture, options: &WriteOptions) -> Result<Vec<u8>, Error> {
    let over_black = |[r, g, b, a]: [f32; 4]| [r * a, g * a, b * a, 1.0];
    let bytes = |color| {
        let [r, g, b, _] = screen_bytes(over_black(color), options.tone, options.exposure);
        [r, g, b]
    };
    let pixels: Vec<u8> = picture.on_screen().flat_map(bytes).collect();
    let mut file = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut file, options.jpeg_quality.clamp(1, 100));
    let written = encoder.write_image(&pixels, picture.width, picture.height, ExtendedColorType::Rgb8);
    written.map_err(|error| Error::Shape(format!("it does not fit a JPEG: {error}")))?;
    Ok(file)
}

pub(super) fn encode_webp(picture: &Picture, options: &WriteOptions) -> Result<Vec<u8>, Error> {
    let bytes = |color| screen_bytes(color, options.tone, options.exposure);
    let pixels: Vec<u8> = picture.on_screen().flat_map(bytes).collect();
    let mut file = Vec::new();
    let encoder = WebPEncoder::new_lossless(&mut file);
    let written = encoder.write_image(&pixels, picture.width, picture.height, ExtendedColorType::Rgba8);
    written.map_err(|error| Error::Shape(format!("it does not fit a WebP: {error}")))?;
    Ok(file)
}
