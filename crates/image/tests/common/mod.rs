// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures and files that the tests of this folder share.
#![allow(dead_code, reason = "each test program uses some of these")]

use std::io::Read;

use gnurt_image::{ExrPixels, Layer, Picture, PictureFormat, WriteOptions, encode};

/// A picture with values of all magnitudes and three layers.
pub(crate) fn picture(width: u32, height: u32) -> Picture {
    let mut picture = Picture::new(width, height);
    let count = picture.pixel_count();
    for (i, pixel) in picture.color.iter_mut().enumerate() {
        let x = i as f32 / count as f32;
        *pixel = [x, (x * 7.0).exp2(), 1.0 / (i + 1) as f32, if i % 3 == 0 { 0.25 } else { 1.0 }];
    }
    let floats = |scale: f32| (0..count).map(|i| i as f32 * scale - 1.0).collect();
    // In the alphabetical order of an EXR's channels.
    picture.layers = vec![
        Layer::floats("N", [("X", floats(0.1)), ("Y", floats(0.2)), ("Z", floats(0.3))]),
        Layer::floats("", [("Z", floats(1e-3))]),
        Layer::ids("id", [("object", (0..count as u32).map(|i| u32::MAX - i).collect())]),
    ];
    picture.set_metadata("software", gnurt_image::SOFTWARE);
    picture.set_metadata("commandLine", "gnurt render Schloß.obj");
    picture
}

/// The same picture, with nothing but its colours.
pub(crate) fn colors_only(picture: &Picture) -> Picture {
    Picture { layers: vec![], metadata: vec![], ..picture.clone() }
}

/// The bytes of a file, colours exact where the format can.
pub(crate) fn file(picture: &Picture, format: &'static PictureFormat) -> Vec<u8> {
    let options = WriteOptions { exr_pixels: ExrPixels::Float, ..WriteOptions::default() };
    encode(picture, format, &options).expect("the picture is consistent")
}

/// Small files of all formats that can be read, with the name that tells their format.
pub(crate) fn files(width: u32, height: u32) -> Vec<(String, Vec<u8>)> {
    let source = picture(width, height);
    let ours =
        PictureFormat::written().map(|format| (format!("x.{}", format.extension()), file(&source, format)));
    let bytes: Vec<u8> = (0..width * height).flat_map(|i| [i as u8, (i * 7) as u8, (i / 2) as u8]).collect();
    let rgb = image::RgbImage::from_raw(width, height, bytes).expect("three bytes a pixel");
    let formats = [
        ("x.jpg", image::ImageFormat::Jpeg),
        ("x.tga", image::ImageFormat::Tga),
        ("x.bmp", image::ImageFormat::Bmp),
        ("x.webp", image::ImageFormat::WebP),
    ];
    let theirs = formats.map(|(name, format)| {
        let mut file = std::io::Cursor::new(Vec::new());
        rgb.write_to(&mut file, format).expect("the library writes this format");
        (name.to_string(), file.into_inner())
    });
    let tiff =
        ("x.tif".to_string(), tiff::<tiff::encoder::colortype::RGB8>(&[([width, height], rgb.as_raw())]));
    ours.into_iter().chain(theirs).chain([tiff]).collect()
}

/// A TIFF of pictures one after the other, packed.
pub(crate) fn tiff<C: tiff::encoder::colortype::ColorType>(pictures: &[([u32; 2], &[C::Inner])]) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut file = std::io::Cursor::new(Vec::new());
    let encoder = tiff::encoder::TiffEncoder::new(&mut file).expect("memory can be written");
    let mut encoder = encoder.with_compression(tiff::encoder::Compression::Deflate(Default::default()));
    for ([width, height], values) in pictures {
        encoder.write_image::<C>(*width, *height, values).expect("sizes fit");
    }
    file.into_inner()
}

/// The bytes that gzip packed.
pub(crate) fn unpacked(packed: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(packed).read_to_end(&mut bytes).unwrap();
    bytes
}
