// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures are read back as they were written: exact to the bit where the format can, within its precision
//! otherwise. The oracle is the picture that was written, or the library's own decoder.

mod common;

use common::{colors_only, file, files, picture, tiff};
use gnurt_image::{
    BACKGROUND, ExrCompression, ExrPixels, Layer, Opacity, Picture, PictureFormat, StoredValues, TexelData,
    Texels, ToneCurve, Workers, WorkingSpace, WriteOptions, compare, decode, decode_data_texture,
    decode_texture, encode, encode_with, read, read_stored, read_texture, read_texture_with, read_with,
    screen_bytes, srgb, write,
};

/// Odd values that a float format must keep, bit by bit.
const ODD: [f32; 8] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1e-42, f32::MAX, -3.5, 65_519.0];

fn with_odd_values() -> Picture {
    let mut picture = picture(8, 3);
    for (i, value) in ODD.into_iter().enumerate() {
        picture.color[i + 3][i % 3] = value;
    }
    picture
}

fn assert_same_bits(found: &Picture, expected: &Picture, channels: usize, what: &str) {
    assert_eq!((found.width, found.height), (expected.width, expected.height), "{what}: size");
    for (i, (a, b)) in found.color.iter().zip(&expected.color).enumerate() {
        let [a, b] = [a, b].map(|pixel| pixel[..channels].iter().map(|v| v.to_bits()).collect::<Vec<_>>());
        assert_eq!(a, b, "{what}: pixel {i}");
    }
}

#[test]
fn pfm_is_exact() {
    let picture = with_odd_values();
    let back = decode(&file(&picture, PictureFormat::PFM), "").expect("our own file");
    assert_same_bits(&back, &picture, 3, "PFM");
    assert!(back.color.iter().all(|pixel| pixel[3] == 1.0), "what has no opacity is opaque");
}

#[test]
fn grey_and_big_endian_pfm_are_read() {
    let grey = decode(b"Pf 2 1 1.0\n\x3f\x80\0\0\x40\0\0\0", "").expect("a grey picture, big-endian");
    assert_eq!(grey.color, [[1.0; 4], [2.0, 2.0, 2.0, 1.0]], "grey is the same in all colours");
    let scaled = decode(b"Pf\n1 2\n-2.0\n\0\0\x80\x3f\0\0\0\x40", "").expect("a grey picture, little-endian");
    assert_eq!(
        scaled.color,
        [[4.0, 4.0, 4.0, 1.0], [2.0, 2.0, 2.0, 1.0]],
        "rows run upwards, values are scaled"
    );
}

#[test]
fn exr_is_exact() {
    let picture = Picture { opacity: Opacity::Associated, ..with_odd_values() };
    let back = decode(&file(&picture, PictureFormat::EXR), "").expect("our own file");
    assert_same_bits(&back, &picture, 4, "EXR");
    assert_eq!(back.layers, picture.layers, "layers, their names, types and values");
    assert_eq!(back.metadata, picture.metadata, "metadata");
}

/// Noise of 200 lines, which are several blocks; workers that begin at the end, and some at once.
#[test]
fn workers_do_not_show_in_exr() {
    let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
    let mut picture = Picture::new(40, 200);
    for (i, pixel) in (0..).zip(&mut picture.color) {
        *pixel = [noise(4 * i), noise(4 * i + 1), noise(4 * i + 2), 1.0];
    }
    let backwards: Workers = &|count, job| (0..count).rev().for_each(job);
    let at_once: Workers = &|count, job| {
        std::thread::scope(|scope| (0..count).for_each(|k| drop(scope.spawn(move || job(k)))));
    };
    for compression in [ExrCompression::None, ExrCompression::Zip, ExrCompression::Zips, ExrCompression::Piz]
    {
        for exr_tile in [None, Some(16), Some(64)] {
            let options = WriteOptions { exr_compression: compression, exr_tile, ..WriteOptions::default() };
            let one = encode(&picture, PictureFormat::EXR, &options).expect("it fits an EXR");
            let back = decode(&one, "").expect("our own file");
            assert_eq!([back.width, back.height], [40, 200], "{compression}");
            let folder = tempfile::tempdir().expect("a folder");
            let file = folder.path().join("p.exr");
            std::fs::write(&file, &one).expect("a file");
            for workers in [backwards, at_once] {
                let bytes = encode_with(&picture, PictureFormat::EXR, &options, workers);
                assert!(bytes.expect("it fits an EXR") == one, "{compression}: the same bytes");
                let read = read_with(&file, workers).expect("our own file");
                assert_same_bits(&read, &back, 4, "read by others");
                let texels = read_texture_with(&file, workers).expect("our own file");
                assert_eq!(texels, Texels::from(back.clone()), "{compression}: the same texels");
            }
        }
    }
}

/// Colours of another space come back; ids of Cryptomatte are bits, and stay so.
#[test]
fn exr_states_the_space_of_its_colours() {
    let mut picture = Picture { opacity: Opacity::Associated, ..picture(8, 3) };
    let id = |i: usize| f32::from_bits(0x3f12_3456 + i as u32);
    // Files have channels in the order of their names.
    let four = ["A", "B", "G", "R"].map(|name| (name, (0..24).map(id).collect()));
    picture.layers.push(Layer::floats("CryptoObject00", four));
    picture.layers.push(Layer::floats("albedo", ["R", "G", "B"].map(|name| (name, vec![0.25; 24]))));
    picture.set_metadata("cryptomatte/f834d0a/name", "CryptoObject");
    let options = WriteOptions {
        exr_space: WorkingSpace::AcesCg,
        exr_pixels: ExrPixels::Float,
        ..WriteOptions::default()
    };
    let bytes = encode(&picture, PictureFormat::EXR, &options).expect("it fits an EXR");
    let name = b"chromaticities\0chromaticities\0";
    let at = bytes.windows(name.len()).position(|some| some == name).expect("the attribute") + name.len() + 4;
    let number = |k: usize| f32::from_le_bytes(std::array::from_fn(|i| bytes[at + 4 * k + i]));
    let expected = [0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767];
    assert_eq!(std::array::from_fn::<f32, 8, _>(number), expected, "AP1 under the white of ACES");
    let back = decode(&bytes, "").expect("our own file");
    for (a, b) in back.color.as_flattened().iter().zip(picture.color.as_flattened()) {
        assert!((a - b).abs() <= 1e-5 * (1.0 + b.abs()), "{a} beside {b}");
    }
    let ids = |picture: &Picture| picture.layer("CryptoObject00").cloned();
    assert_eq!(ids(&back), ids(&picture), "ids");
}

/// The first attribute `tiles` of a header: width, height, levels; and whether the version says that there are some.
fn tiles_of(bytes: &[u8]) -> (bool, Option<[u32; 2]>) {
    let name = b"tiles\0tiledesc\0";
    let number = |at: usize| u32::from_le_bytes(std::array::from_fn(|k| bytes[at + k]));
    let at = bytes.windows(name.len()).position(|some| some == name).map(|at| at + name.len() + 4);
    (bytes[5] & 2 != 0, at.map(|at| [number(at), number(at + 4)]))
}

#[test]
fn exr_has_the_tiles_that_were_asked_for() {
    let mut picture = Picture::new(100, 70);
    for (i, pixel) in picture.color.iter_mut().enumerate() {
        *pixel = [i as f32, 0.5, -2.0, 1.0];
    }
    for (exr_tile, expected) in [(None, (false, None)), (Some(32), (true, Some([32, 32])))] {
        let options = WriteOptions { exr_tile, exr_pixels: ExrPixels::Float, ..WriteOptions::default() };
        let bytes = encode(&picture, PictureFormat::EXR, &options).expect("it fits an EXR");
        assert_eq!(tiles_of(&bytes), expected, "{exr_tile:?}");
        let back = decode(&bytes, "").expect("our own file");
        assert_same_bits(&back, &picture, 4, "tiles at the edges are smaller");
    }
}

/// Other programs compose the foreground over something else; our own reader restores the visible colour.
#[test]
fn exr_is_associated_over_nothing() {
    let mut picture = Picture::new(3, 1);
    picture.opacity = Opacity::Associated;
    picture.color = vec![[0.5, 0.25, 1.0, 0.0], [0.75, 0.5, 0.5, 0.5], [1.0, 1.0, 1.0, 1.0]];
    let halves = |first: f32| vec![first, 0.25, 0.0];
    let channels = [("R", halves(0.5)), ("G", halves(0.25)), ("B", halves(1.0)), ("A", vec![1.0, 0.5, 0.0])];
    let without = picture.clone();
    picture.layers.push(Layer::floats(BACKGROUND, channels));
    let bytes = file(&picture, PictureFormat::EXR);
    let back = decode(&bytes, "").expect("our own file");
    assert_eq!(back.color, picture.color, "what is seen");
    // As a program reads it that does not know the layer.
    let mut bare = back.clone();
    let background = bare.layers.pop().expect("the layer");
    for (i, pixel) in bare.color.iter_mut().enumerate() {
        let values = |name: &str| match &background.channel(name).expect("a channel").data {
            gnurt_image::ChannelData::F32(values) => values[i],
            gnurt_image::ChannelData::U32(_) => panic!("floats"),
        };
        pixel[..3].iter_mut().zip(["R", "G", "B"]).for_each(|(x, name)| *x -= values(name));
    }
    assert_eq!(bare.color, [[0.0; 4], [0.5, 0.25, 0.25, 0.5], [1.0; 4]], "nothing where alpha is 0");
    // On a screen it is opaque; without the layer a half covered pixel is half transparent, and keeps its
    // colour.
    let png = |picture: &Picture| decode(&file(picture, PictureFormat::PNG), "").expect("our own file").color;
    assert!(png(&back).iter().all(|pixel| pixel[3] == 1.0), "{:?}", png(&back));
    let shown = png(&without)[1];
    assert!((shown[3] - 0.5).abs() < 0.01 && shown[0] == 1.0 && (shown[1] - 1.0).abs() < 0.01, "{shown:?}");
    // A PNG's colours are straight: in an EXR they are multiplied.
    let straight = Picture { color: vec![[0.5, 0.5, 0.5, 0.5]], ..Picture::new(1, 1) };
    let multiplied = decode(&file(&straight, PictureFormat::EXR), "").expect("our own file");
    assert_eq!(multiplied.color, [[0.25, 0.25, 0.25, 0.5]], "associated");
}

#[test]
fn exr_layers_may_be_half() {
    let mut picture = picture(4, 4);
    picture.layers[0].channels[0].half = true;
    let back = decode(&file(&picture, PictureFormat::EXR), "").expect("our own file");
    let channel = back.layer("N").and_then(|layer| layer.channel("X")).expect("the layer is there");
    assert!(channel.half, "the precision is kept");
}

#[test]
fn exr_in_half_precision_stays_close_and_finite() {
    let picture = Picture { opacity: Opacity::Associated, ..with_odd_values() };
    let options = WriteOptions { exr_pixels: ExrPixels::Half, ..WriteOptions::default() };
    let bytes = encode(&picture, PictureFormat::EXR, &options).expect("the picture is consistent");
    let back = decode(&bytes, "").expect("our own file");
    for (a, b) in back.color.iter().flatten().zip(picture.color.iter().flatten()) {
        let expected = if b.is_finite() { b.clamp(-65_504.0, 65_504.0) } else { *b };
        let close = (a - expected).abs() <= expected.abs() / 2048.0 + 1e-7;
        assert!(a.to_bits() == b.to_bits() || close || (a.is_nan() && b.is_nan()), "{b} became {a}");
    }
}

/// Without a wish, colours are half where that holds them, and float where it does not.
#[test]
fn exr_does_not_cut_light_off() {
    let size = |value: f32, behind: f32| {
        let mut picture = Picture::new(4, 4);
        picture.color.fill([behind, behind, behind, 1.0]);
        picture.color[5][0] += value;
        let channel = |name: &str| gnurt_image::Channel {
            name: name.into(),
            data: gnurt_image::ChannelData::F32(vec![behind; 16]),
            half: true,
        };
        if behind > 0.0 {
            let channels = ["R", "G", "B", "A"].map(channel).into();
            picture.layers.push(Layer { name: BACKGROUND.into(), channels });
        }
        picture.opacity = Opacity::Associated;
        let bytes = encode(&picture, PictureFormat::EXR, &WriteOptions::default()).expect("it is consistent");
        (bytes.len(), decode(&bytes, "").expect("our own file").color[5][0])
    };
    let (half, sun) = (size(1000.0, 0.0), size(1e6, 0.0));
    assert_eq!((half.1, sun.1), (1000.0, 1e6), "both are kept");
    assert_eq!(size(65504.0, 0.0).1, 65504.0, "the largest half");
    assert_eq!(size(f32::INFINITY, 0.0).1, f32::INFINITY, "which infinity is no reason for");
    assert_eq!(size(1.0, 1e6).1, 1e6 + 1.0, "what lies behind");
}

#[test]
fn double_channels_are_refused() {
    let mut picture = picture(2, 2);
    picture.layers.push(picture.layers[0].clone());
    let error =
        encode(&picture, PictureFormat::EXR, &WriteOptions::default()).expect_err("N.X is there twice");
    assert!(error.to_string().contains("'N.X'"), "the message names the channel: {error}");
}

#[test]
fn png_bytes_are_exact() {
    let mut picture = Picture::new(16, 16);
    for (i, pixel) in picture.color.iter_mut().enumerate() {
        let [r, g, b] = [i, 255 - i, i / 2].map(|byte| srgb::decode_u8(byte as u8));
        *pixel = [r, g, b, (i % 7) as f32 / 6.0];
    }
    let bytes = file(&picture, PictureFormat::PNG);
    let texels = decode_texture(&bytes, "").expect("our own file");
    let expected: Vec<_> = picture.color.iter().map(|&c| screen_bytes(c, ToneCurve::Clamp, 0.0)).collect();
    assert_eq!(texels.data, TexelData::Srgb8(expected), "the bytes of the file");
    let again = file(&decode(&bytes, "").expect("our own file"), PictureFormat::PNG);
    assert_eq!(again, bytes, "reading and writing again changes nothing");
    assert!(bytes.windows(4).any(|name| name == b"sRGB"), "the file says what its values mean");
}

#[test]
fn pngs_of_sixteen_bits_keep_them() {
    let values = image::ImageBuffer::<image::Rgba<u16>, _>::from_raw(1, 1, vec![65535, 0, 32768, 13107]);
    let mut file = std::io::Cursor::new(Vec::new());
    let written = values.expect("four values").write_to(&mut file, image::ImageFormat::Png);
    written.expect("the library writes this format");
    let color = decode_texture(file.get_ref(), "").expect("a PNG of 16 bits");
    let middle = (srgb::decode_u16(32768) * 65535.0).round() as u16;
    let expected = TexelData::Linear16(vec![[65535, 0, middle, 13107]]);
    assert_eq!(color.data, expected, "colours are sRGB, opacity is linear");
    let measure = decode_data_texture(file.get_ref(), "").expect("a PNG of 16 bits");
    assert_eq!(measure.data, TexelData::Linear16(vec![[65535, 0, 32768, 13107]]), "measures are linear");
}

#[test]
fn hdr_is_close() {
    for width in [5, 40] {
        let picture = colors_only(&picture(width, 9));
        let back = decode(&file(&picture, PictureFormat::HDR), "").expect("our own file");
        for (a, b) in back.color.iter().zip(&picture.color) {
            let largest = b[0].max(b[1]).max(b[2]);
            for c in 0..3 {
                assert!((a[c] - b[c]).abs() <= largest / 256.0, "{b:?} became {a:?}");
            }
        }
    }
}

/// The library's own decoder is the oracle for the meaning of our files to other programs.
#[test]
fn others_read_our_files() {
    let picture = colors_only(&picture(40, 9));
    for (format, tolerance) in [(PictureFormat::PNG, 0.0), (PictureFormat::HDR, 1.0 / 128.0)] {
        let bytes = file(&picture, format);
        let theirs = image::load_from_memory(&bytes).expect("the library reads our file").to_rgb32f();
        let ours = decode(&bytes, "").expect("our own file");
        for (theirs, ours) in theirs.pixels().zip(&ours.color) {
            for c in 0..3 {
                let ours_c = if format == PictureFormat::PNG { srgb::encode(ours[c]) } else { ours[c] };
                let largest = ours[0].max(ours[1]).max(ours[2]);
                let close = (theirs[c] - ours_c).abs() <= tolerance * largest + 1e-6;
                assert!(close, "{format:?}: {theirs:?} is not {ours:?}");
            }
        }
    }
}

#[test]
fn all_formats_are_read() {
    for (name, bytes) in files(12, 10) {
        let picture = decode(&bytes, &name).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!((picture.width, picture.height), (12, 10), "size of {name}");
        let texels = decode_texture(&bytes, &name).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(Picture::from(texels).color, picture.color, "texels of {name} are its pixels");
    }
}

#[test]
fn the_same_picture_gives_the_same_bytes() {
    let picture = picture(33, 21);
    for format in [PictureFormat::PNG, PictureFormat::PFM, PictureFormat::HDR] {
        assert_eq!(file(&picture, format), file(&picture.clone(), format), "bytes of {format:?}");
    }
}

#[test]
fn files_are_written_and_read() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let picture = picture(6, 5);
    for format in PictureFormat::written() {
        let path = folder.path().join(format!("a.{}", format.extension()));
        write(&picture, &path, &WriteOptions::default()).expect("the folder can be written to");
        let back = read(&path).expect("our own file");
        assert_eq!((back.width, back.height), (6, 5), "size of {}", path.display());
        read_texture(&path).expect("our own file as a texture");
    }
}

/// A byte picture and a float picture of the same values are equal, whatever their formats.
#[test]
fn formats_may_be_mixed_when_compared() {
    let source = picture(9, 9);
    let png = decode(&file(&source, PictureFormat::PNG), "").expect("our own file");
    let exr = decode(&file(&png, PictureFormat::EXR), "").expect("our own file");
    assert_eq!(
        (png.opacity, exr.opacity),
        (Opacity::Straight, Opacity::Associated),
        "as their formats have it"
    );
    assert!(compare(&png, &exr).expect("sizes are equal").is_equal(), "PNG and EXR hold the same light");
}

#[test]
fn tiffs_are_textures() {
    use ::tiff::encoder::colortype::{Gray16, RGB8, RGB32Float, RGBA8};
    let rgb = [10, 20, 30, 40, 50, 60];
    let texels = |bytes: &[u8]| decode_texture(bytes, "x.tif").expect("a TIFF").data;
    let srgb = TexelData::Srgb8(vec![[10, 20, 30, 255], [40, 50, 60, 255]]);
    assert_eq!(texels(&tiff::<RGB8>(&[([2, 1], &rgb)])), srgb, "bytes stay bytes");
    let data = decode_data_texture(&tiff::<RGBA8>(&[([1, 1], &[1, 2, 3, 4])]), "").expect("a TIFF").data;
    assert_eq!(data, TexelData::Linear8(vec![[1, 2, 3, 4]]), "opacity is the fourth");
    let grey = TexelData::Float(vec![[1.0; 4]]);
    assert_eq!(texels(&tiff::<Gray16>(&[([1, 1], &[65535])])), grey, "grey is all colours at once");
    let bright = TexelData::Float(vec![[0.5, 7.0, -1.0, 1.0]]);
    assert_eq!(texels(&tiff::<RGB32Float>(&[([1, 1], &[0.5, 7.0, -1.0])])), bright, "floats are linear");
}

/// Textures have colours that are not multiplied with opacity; of those that are, it is divided.
#[test]
fn associated_opacity_of_tiffs_is_divided() {
    use ::tiff::{encoder::colortype::RGBA8, tags::Tag};
    let of = |kind: u16| {
        let mut file = std::io::Cursor::new(Vec::new());
        let mut encoder = ::tiff::encoder::TiffEncoder::new(&mut file).expect("memory can be written");
        let mut image = encoder.new_image::<RGBA8>(2, 1).expect("a size");
        image.encoder().write_tag(Tag::ExtraSamples, &[kind][..]).expect("a tag");
        image.write_data(&[50, 100, 20, 100, 7, 8, 9, 0]).expect("sizes fit");
        decode_texture(&file.into_inner(), "x.tif").expect("a TIFF").data
    };
    assert_eq!(of(2), TexelData::Srgb8(vec![[50, 100, 20, 100], [7, 8, 9, 0]]), "straight");
    assert_eq!(of(1), TexelData::Srgb8(vec![[128, 255, 51, 100], [7, 8, 9, 0]]), "associated");
}

#[test]
fn files_are_read_as_they_are_stored() {
    use ::tiff::encoder::colortype::RGB8;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.tx");
    let large: Vec<u8> = (0..4 * 2 * 3).collect();
    let copies = tiff::<RGB8>(&[
        ([4, 2], &large),
        ([2, 1], &[1, 2, 3, 4, 5, 6]),
        ([1, 1], &[7, 8, 9]),
        ([9, 9], &[0; 243]),
    ]);
    std::fs::write(&path, copies).expect("written");
    let stored = read_stored(&path).expect("a TIFF");
    let sizes: Vec<_> = stored.levels.iter().map(|level| [level.width, level.height]).collect();
    assert_eq!(sizes, [[4, 2], [2, 1], [1, 1]], "smaller copies follow; what is no copy does not count");
    assert_eq!(stored.levels[0].values, StoredValues::U8(large), "bytes as they are");
    assert_eq!((stored.channels, stored.alpha, stored.window), (3, None, [0, 0, 3, 1]));
    assert!((stored.levels[2].values.get(1) - 8.0 / 255.0).abs() < 1e-7, "255 is 1");

    let path = folder.path().join("x.exr");
    let picture = picture(3, 2);
    std::fs::write(&path, file(&picture, PictureFormat::EXR)).expect("written");
    let stored = read_stored(&path).expect("an EXR");
    let StoredValues::F32(values) = &stored.levels[0].values else { panic!("an EXR holds floats") };
    assert_eq!(stored.alpha, Some(3), "red, green, blue and opacity come first");
    let second = &values[stored.channels..][..4];
    assert_eq!(second, picture.color[1], "colours as they are");
    assert_eq!(values.len(), 6 * stored.channels, "all channels, those of layers as well");
}
