// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures as OSL's tools read them, by properties known without them: ramps stay ramps, derivatives are
//! those of values, means stay.

use gnurt_image::{Picture, PictureFormat, WriteOptions, encode};
use gnurt_sl::exec::TextureOptions;
use gnurt_sl::hir::Data;
use gnurt_sl::stored::Textures;
use gnurt_sl::types::Type;
use gnurt_sl_lib::Dual;
use gnurt_sl_shading::StoredTextures;

/// A file of floats: red grows with s, green with t, blue is noise.
fn ramp(folder: &std::path::Path, [width, height]: [u32; 2]) -> String {
    let mut picture = Picture::new(width, height);
    for (i, pixel) in picture.color.iter_mut().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let noise = (i as u32).wrapping_mul(2_654_435_761) >> 24;
        *pixel = [x as f32 + 0.5, y as f32 + 0.5, noise as f32 / 255.0, 1.0];
    }
    let path = folder.join(format!("{width}x{height}.pfm"));
    let bytes = encode(&picture, PictureFormat::PFM, &WriteOptions::default()).expect("consistent");
    std::fs::write(&path, bytes).expect("written");
    path.to_string_lossy().into_owned()
}

fn at(s: f32, t: f32, width: f32) -> [Dual<f32>; 2] {
    [Dual::new(s, width, 0.0), Dual::new(t, 0.0, width)]
}

fn options(interpolation: &str, wrap: &str) -> TextureOptions {
    let wrap: std::sync::Arc<str> = wrap.into();
    TextureOptions {
        interpolation: interpolation.into(),
        wrap: std::array::from_fn(|_| wrap.clone()),
        ..TextureOptions::default()
    }
}

#[test]
fn ramps_stay_ramps_and_changes_are_those_of_values() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, textures) = (ramp(folder.path(), [16, 8]), StoredTextures::default());
    for interpolation in ["linear", "cubic", "smartcubic"] {
        let read = |s: f32, t: f32| {
            textures.texture(&file, at(s, t, 0.001), &options(interpolation, "clamp")).expect("a picture")
        };
        let [red, green, blue, _] = read(0.4, 0.55);
        assert!(
            (red.value - 6.4).abs() < 1e-4 && (green.value - 4.4).abs() < 1e-4,
            "{interpolation}: {red:?} {green:?}"
        );
        assert!(
            (red.dx - 0.016).abs() < 1e-5 && red.dy.abs() < 1e-6,
            "{interpolation}: 16 texels along s: {red:?}"
        );
        // Against small steps.
        let step = 1e-3;
        let slope =
            (read(0.4 + step, 0.55)[2].value - read(0.4 - step, 0.55)[2].value) / (2.0 * step) * 0.001;
        assert!((blue.dx - slope).abs() < 2e-4, "{interpolation}: {} and {slope}", blue.dx);
    }
    let closest =
        textures.texture(&file, at(0.4, 0.55, 0.0), &options("closest", "clamp")).expect("a picture");
    assert_eq!([closest[0].value, closest[1].value], [6.5, 4.5], "the texel itself");
}

#[test]
fn pictures_go_on_as_they_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, textures) = (ramp(folder.path(), [16, 8]), StoredTextures::default());
    let red = |s: f32, wrap: &str| {
        textures.texture(&file, at(s, 0.5, 0.0), &options("closest", wrap)).expect("a picture")[0].value
    };
    for (wrap, expected) in
        [("black", [0.0, 0.0]), ("clamp", [0.5, 15.5]), ("periodic", [15.5, 0.5]), ("mirror", [0.5, 15.5])]
    {
        assert_eq!([red(-0.01, wrap), red(1.01, wrap)], expected, "{wrap}");
    }
    assert_eq!(red(2.01, "mirror"), 0.5, "twice mirrored");
    assert_eq!(red(-0.01, ""), 0.0, "black where nobody says else");
}

#[test]
fn wide_pixels_see_means() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, textures) = (ramp(folder.path(), [64, 64]), StoredTextures::default());
    let mean = {
        let noise = |i: u32| ((i.wrapping_mul(2_654_435_761) >> 24) as f32) / 255.0;
        (0..64 * 64).map(noise).sum::<f32>() / 4096.0
    };
    for changes in [[0.5, 0.5], [0.9, 0.1], [0.1, 0.9]] {
        let at = [Dual::new(0.5, changes[0], 0.0), Dual::new(0.5, 0.0, changes[1])];
        let blue = textures.texture(&file, at, &options("", "periodic")).expect("a picture")[2].value;
        assert!((blue - mean).abs() < 0.02, "{changes:?}: {blue}, the mean is {mean}");
    }
    // Blur is width that adds to the pixel's own.
    let blurred = TextureOptions { blur: [0.5; 2], ..options("", "periodic") };
    let blue = textures.texture(&file, at(0.5, 0.5, 1e-6), &blurred).expect("a picture")[2].value;
    assert!((blue - mean).abs() < 0.02, "{blue}, the mean is {mean}");
    let y = [0.0, 1.0, 0.0].map(Dual::from);
    let up = textures.environment(&file, y, &options("", "")).expect("a picture")[1].value;
    assert!(up < 1.0, "y is up: {up}");
}

#[test]
fn files_say_what_they_are_and_what_is_wrong_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, textures) = (ramp(folder.path(), [16, 8]), StoredTextures::default());
    let info = |what: &str, ty| textures.info(&file, None, what, ty).expect("a picture");
    assert_eq!(info("resolution", Type::INT.array_of(2)), Some(Data::Int(vec![16, 8])));
    assert_eq!(info("channels", Type::INT), Some(Data::Int(vec![3])));
    assert_eq!(info("resolution", Type::FLOAT), None, "of another type");
    let Some(Data::Float(mean)) = info("averagecolor", Type::COLOR) else {
        panic!("the smallest copy is the mean")
    };
    assert!((mean[0] - 8.0).abs() < 1e-4 && (mean[1] - 4.0).abs() < 1e-4, "{mean:?}");
    // Channels that the file lacks are filled.
    let filled = TextureOptions { fill: 0.25, first_channel: 2, channels: 2, ..options("", "clamp") };
    let fill = textures.texture(&file, at(0.5, 0.5, 0.0), &filled).expect("a picture")[1].value;
    assert!((fill - 0.25).abs() < 1e-6, "{fill}");
    let missing = |name: &str| textures.texture(name, at(0.5, 0.5, 0.0), &options("", "")).expect_err("none");
    assert!(missing("no.tif").contains("no.tif") && missing("no.tif").is_empty(), "it is said once");
    // Tiles: the first of a column is there.
    let tile = folder.path().join("t.1011.pfm");
    std::fs::copy(&file, &tile).expect("copied");
    let tiles = folder.path().join("t.<UDIM>.pfm").to_string_lossy().into_owned();
    let red = textures.texture(&tiles, at(0.53, 1.5, 0.0), &options("closest", "")).expect("a tile")[0].value;
    assert_eq!(red, 8.5, "the place within the tile");
    assert_eq!(textures.info(&tiles, Some([0.5, 0.5]), "channels", Type::INT), Ok(None), "a hole");
    let shared = |name: &str, what: &str, ty| StoredTextures::default().info(name, None, what, ty);
    assert_eq!(
        shared(&tiles, "channels", Type::INT),
        Ok(Some(Data::Int(vec![3]))),
        "of the tiles that are there"
    );
    let size = Type::INT.array_of(2);
    assert_eq!(shared(&tiles, "resolution", size), Ok(Some(Data::Int(vec![16, 8]))));
    let other = ramp(folder.path(), [8, 8]);
    std::fs::copy(other, folder.path().join("t.1002.pfm")).expect("copied");
    assert_eq!(shared(&tiles, "resolution", size), Ok(None), "they differ");
    let none = folder.path().join("n.<UDIM>.pfm").to_string_lossy().into_owned();
    assert_eq!(shared(&none, "exists", Type::INT), Ok(Some(Data::Int(vec![0]))));
    assert_eq!(shared(&none, "channels", Type::INT), Ok(None));
}
