// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures written in bands hold what the same pictures hold that are written at once.

use std::path::Path;

use gnurt_image::{
    Channel, ChannelData, ExrCompression, ExrPixels, Layer, Picture, WorkingSpace, WriteOptions, band_unit,
    read, write, write_bands,
};

/// A picture with a value of its own everywhere, and two layers.
fn picture([width, height]: [u32; 2]) -> Picture {
    let mut picture = Picture::new(width, height);
    let pixels = picture.pixel_count();
    for (i, pixel) in picture.color.iter_mut().enumerate() {
        let x = i as f32 / pixels as f32;
        *pixel = [x, 2.0 - x, (40.0 * x).sin().abs(), 0.25 + 0.75 * x];
    }
    picture.layers.push(Layer::floats("N", [("X", (0..pixels).map(|i| i as f32).collect())]));
    let ids = ChannelData::U32((0..pixels as u32).map(|i| i * 7).collect());
    picture.layers.push(Layer {
        name: "id".into(),
        channels: vec![Channel { name: "object".into(), data: ids, half: false }],
    });
    picture.set_metadata("seed", "9");
    picture
}

/// Rows of a picture.
fn band(picture: &Picture, [top, end]: [u32; 2]) -> Picture {
    let width = picture.width as usize;
    let range = top as usize * width..end as usize * width;
    let mut band = picture.clone();
    band.height = end - top;
    band.color = picture.color[range.clone()].to_vec();
    for channel in band.layers.iter_mut().flat_map(|layer| &mut layer.channels) {
        channel.data = match &channel.data {
            ChannelData::F32(values) => ChannelData::F32(values[range.clone()].to_vec()),
            ChannelData::U32(values) => ChannelData::U32(values[range.clone()].to_vec()),
        };
    }
    band
}

fn write_in_bands(
    path: &Path,
    picture: &Picture,
    rows: u32,
    options: &WriteOptions,
) -> Result<bool, gnurt_image::Error> {
    let workers = &|count: usize, job: &(dyn Fn(usize) + Sync)| (0..count).rev().for_each(job);
    let size = [picture.width, picture.height];
    write_bands(path, size, rows, options, workers, &mut |rows| Some(band(picture, rows)), || true)
}

#[test]
fn bands_make_the_file_of_the_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, banded) = (folder.path().join("whole"), folder.path().join("banded"));
    let picture = picture([75, 150]);
    let options = WriteOptions { exr_pixels: ExrPixels::Float, ..WriteOptions::default() };
    let mut cases = vec![
        ("png", options),
        ("png", WriteOptions { png_16_bits: true, ..options }),
        ("exr", WriteOptions { exr_pixels: ExrPixels::Half, exr_space: WorkingSpace::AcesCg, ..options }),
        ("exr", WriteOptions { exr_tile: Some(32), ..options }),
        ("exr", WriteOptions { exr_tile: Some(24), ..options }),
    ];
    cases.extend(
        ExrCompression::ALL.map(|exr_compression| ("exr", WriteOptions { exr_compression, ..options })),
    );
    for (extension, options) in cases {
        let (whole, banded) = (whole.with_extension(extension), banded.with_extension(extension));
        write(&picture, &whole, &options).expect("a file");
        let format = gnurt_image::PictureFormat::from_path(&whole).expect("a format");
        let unit = band_unit(format, &options).expect("bands");
        for rows in [unit, 3 * unit, 480] {
            let is_there =
                write_in_bands(&banded, &picture, rows.next_multiple_of(unit), &options).expect("a file");
            assert!(
                is_there && read(&banded).expect("whole") == read(&whole).expect("whole"),
                "{extension} {options:?} {rows}"
            );
            if extension == "exr" {
                let bytes = |path: &Path| std::fs::read(path).expect("bytes").len();
                assert_eq!(bytes(&banded), bytes(&whole), "the same blocks: {options:?} {rows}");
            }
        }
    }
}

#[test]
fn what_does_not_fit_is_an_error_and_leaves_the_old_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    let picture = picture([20, 64]);
    let options = WriteOptions { exr_pixels: ExrPixels::Float, ..WriteOptions::default() };
    assert!(write_in_bands(&path, &picture, 32, &options).expect("a file"));
    let old = std::fs::read(&path).expect("bytes");
    let workers = &|count: usize, job: &(dyn Fn(usize) + Sync)| (0..count).for_each(job);
    let try_bands = |make: &mut dyn FnMut([u32; 2]) -> Option<Picture>| {
        write_bands(&path, [20, 64], 32, &options, workers, make, || true)
    };
    assert_eq!(
        try_bands(&mut |[top, end]| (top == 0).then(|| band(&picture, [top, end]))).ok(),
        Some(false),
        "stopped"
    );
    let short = try_bands(&mut |[top, _]| Some(band(&picture, [top, top + 16]))).expect_err("too few rows");
    assert!(short.to_string().contains("rows 0 to 32"), "{short}");
    let other = try_bands(&mut |[top, end]| {
        let mut band = band(&picture, [top, end]);
        band.layers.truncate(if top == 0 { 2 } else { 1 });
        Some(band)
    });
    assert!(other.expect_err("a layer less").to_string().contains("other layers"), "named");
    assert_eq!(std::fs::read(&path).expect("bytes"), old, "nothing has changed");
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1, "no rest");
    for (name, rows, options, text) in [
        ("a.jpg", 16, options, ".png and .exr"),
        ("a.exr", 16, WriteOptions::default(), "half or float"),
        ("a.exr", 24, options, "multiple of 16"),
    ] {
        let error = write_in_bands(&folder.path().join(name), &picture, rows, &options).expect_err("refused");
        assert!(error.to_string().contains(text), "{error}");
    }
}
