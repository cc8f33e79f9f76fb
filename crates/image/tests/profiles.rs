// SPDX-License-Identifier: GPL-3.0-or-later
//! Colours and orientations that files state: ICC profiles, chunks of PNG, EXIF, chromaticities of EXR.

use std::io::Cursor;

use gnurt_image::chromaticities::{ACES_CG, Chromaticities, REC709};
use gnurt_image::{
    Picture, PictureFormat, TexelData, WriteOptions, decode, decode_data_texture, decode_texture, encode,
};
use image::codecs::{jpeg::JpegEncoder, png::PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use moxcms::ColorProfile;

/// A PNG of pixels in a row, with a profile.
fn png_with(profile: Option<&ColorProfile>, pixels: &[u8], kind: ExtendedColorType) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = PngEncoder::new(&mut file);
    if let Some(profile) = profile {
        encoder.set_icc_profile(profile.encode().expect("a profile")).expect("room for it");
    }
    let bytes = usize::from(kind.bits_per_pixel() / 8);
    encoder.write_image(pixels, (pixels.len() / bytes) as u32, 1, kind).expect("a file");
    file
}

/// The file with a chunk in front of its pixels.
fn with_chunk(png: &[u8], kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let crc = |bytes: &[u8]| {
        let step = |mut c: u32| {
            (0..8).for_each(|_| c = if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 });
            c
        };
        !bytes.iter().fold(!0_u32, |c, &byte| step((c ^ u32::from(byte)) & 255) ^ (c >> 8))
    };
    let body = [&kind[..], data].concat();
    // Signature and header take 33 bytes.
    let (head, tail) = png.split_at(33);
    [head, &(data.len() as u32).to_be_bytes(), &body, &crc(&body).to_be_bytes(), tail].concat()
}

fn bytes_of(file: &[u8]) -> Vec<[u8; 4]> {
    match decode_texture(file, "t").expect("a texture").data {
        TexelData::Srgb8(texels) => texels,
        other => panic!("{other:?}"),
    }
}

fn close(found: [u8; 4], expected: [u8; 4], what: &str) {
    let is = found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1);
    assert!(is, "{what}: {found:?}, not {expected:?}");
}

#[test]
fn profiles_are_applied_to_colours_alone() {
    let pixels = [200, 100, 50, 255, 255, 0, 0, 128];
    let kind = ExtendedColorType::Rgba8;
    let p3 = png_with(Some(&ColorProfile::new_display_p3()), &pixels, kind);
    let texels = bytes_of(&p3);
    // By P3's matrix: (0.578, 0.127, 0.032) in P3 is (0.679, 0.109, 0.014) here.
    close(texels[0], [215, 93, 31, 255], "a colour of P3");
    close(texels[1], [255, 0, 0, 128], "outside of sRGB, cut off; opacity stays");
    let srgb = png_with(Some(&ColorProfile::new_srgb()), &pixels, kind);
    assert_eq!(
        bytes_of(&srgb),
        bytes_of(&png_with(None, &pixels, kind)),
        "sRGB changes nothing, not by rounding"
    );
    let data = decode_data_texture(&p3, "t").expect("data").data;
    assert!(
        matches!(&data, TexelData::Linear8(texels) if texels[0] == [200, 100, 50, 255]),
        "numbers have no profile"
    );
    let mut jpeg = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut jpeg, 100);
    encoder.set_icc_profile(ColorProfile::new_display_p3().encode().expect("a profile")).expect("room");
    let flat: Vec<u8> = [200, 100, 50].repeat(64);
    encoder.write_image(&flat, 8, 8, ExtendedColorType::Rgb8).expect("a file");
    let [r, g, b, _] = bytes_of(&jpeg)[0];
    assert!(r.abs_diff(215) <= 3 && g.abs_diff(93) <= 3 && b.abs_diff(31) <= 5, "in a JPEG: {r} {g} {b}");
}

#[test]
fn numbers_of_a_png_are_applied() {
    let plain = png_with(None, &[128, 128, 128, 200, 100, 50], ExtendedColorType::Rgb8);
    let linear = with_chunk(&plain, b"gAMA", &100_000_u32.to_be_bytes());
    close(bytes_of(&linear)[0], [188, 188, 188, 255], "linear values");
    let usual = with_chunk(&plain, b"gAMA", &45_455_u32.to_be_bytes());
    assert_eq!(bytes_of(&usual), bytes_of(&plain), "the usual curve is that of sRGB");
    let p3: Vec<u8> = [31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000_u32]
        .iter()
        .flat_map(|x| x.to_be_bytes())
        .collect();
    close(bytes_of(&with_chunk(&plain, b"cHRM", &p3))[1], [215, 93, 31, 255], "primaries of P3");
    close(bytes_of(&with_chunk(&plain, b"cICP", &[12, 13, 0, 1]))[1], [215, 93, 31, 255], "P3 by its code");
    let both = with_chunk(&with_chunk(&plain, b"gAMA", &100_000_u32.to_be_bytes()), b"sRGB", &[0]);
    assert_eq!(bytes_of(&both), bytes_of(&plain), "sRGB comes first");
}

#[test]
fn photographs_stand_upright() {
    let mut jpeg = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut jpeg, 100);
    // Big-endian TIFF with one entry: orientation 6, to be turned clockwise.
    let exif = b"MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    encoder.set_exif_metadata(exif.to_vec()).expect("room for it");
    // Two blocks side by side: white, then black.
    let row = [[255; 24], [0; 24]].concat();
    encoder.write_image(&row.repeat(8), 16, 8, ExtendedColorType::Rgb8).expect("a file");
    let texels = decode_texture(&jpeg, "t").expect("a texture");
    assert_eq!([texels.width, texels.height], [8, 16], "turned");
    assert!(texels.texel(4, 2)[0] > 0.9 && texels.texel(4, 13)[0] < 0.1, "the left side is at the top");
}

#[test]
fn sixteen_bits_stay_sixteen_bits() {
    let values: Vec<u8> = [0_u16, 257, 30_000, 65_535].iter().flat_map(|x| x.to_ne_bytes()).collect();
    let file = png_with(None, &values, ExtendedColorType::L16);
    let TexelData::Linear16(texels) = decode_texture(&file, "t").expect("a texture").data else {
        panic!("16 bits")
    };
    let expected = [0.0, 257.0, 30_000.0, 65_535.0].map(|x| gnurt_image::srgb::decode(x / 65_535.0));
    for (texel, expected) in texels.iter().zip(expected) {
        assert!((f32::from(texel[0]) / 65_535.0 - expected).abs() < 8e-6, "{texel:?}, {expected}");
    }
}

#[test]
fn chromaticities_of_exr_are_converted() {
    use exr::prelude::*;
    let color = [0.25_f32, 0.5, 0.75];
    let write = |space: Option<Chromaticities>| {
        let pixels = |_| (color[0], color[1], color[2]);
        let layer = Layer::new(
            (2, 2),
            LayerAttributes::default(),
            Encoding::UNCOMPRESSED,
            SpecificChannels::rgb(pixels),
        );
        let mut image = Image::from_layer(layer);
        let point = |[x, y]: [f32; 2]| Vec2(x, y);
        image.attributes.chromaticities = space.map(|space| {
            let [red, green, blue] = space.primaries.map(point);
            exr::meta::attribute::Chromaticities { red, green, blue, white: point(space.white) }
        });
        let mut bytes = Cursor::new(Vec::new());
        image.write().non_parallel().to_buffered(&mut bytes).expect("a file");
        decode(&bytes.into_inner(), "t.exr").expect("a picture").color[0]
    };
    assert_eq!(write(None)[..3], color, "without any: Rec. 709");
    assert_eq!(write(Some(REC709))[..3], color, "the same");
    let rows = ACES_CG.to(&REC709).expect("a matrix");
    let found = write(Some(ACES_CG));
    for (k, row) in rows.iter().enumerate() {
        let expected: f32 = (0..3).map(|c| row[c] * color[c]).sum();
        assert!((found[k] - expected).abs() < 1e-5, "channel {k}: {}, {expected}", found[k]);
    }
    let picture = Picture::new(2, 2);
    let ours = encode(&picture, PictureFormat::EXR, &WriteOptions::default()).expect("a file");
    let named = b"chromaticities\0chromaticities\0";
    assert!(ours.windows(named.len()).any(|bytes| bytes == named), "written files state theirs");
}
