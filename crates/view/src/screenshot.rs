// SPDX-License-Identifier: GPL-3.0-or-later
//! Screenshots, without the overlay: view-0001.png, view-0002.png, ... Old files are not overwritten; a file
//! appears whole or not at all. Tests: `tests`.

use std::path::{Path, PathBuf};

use gnurt::image::{Picture, PictureFormat, WriteOptions, encode, replace_file};

use crate::exposure::Exposure;

/// Writes a picture into `folder` under the first free name, and returns the name.
pub(crate) fn write(
    folder: &Path,
    colors: &[[f32; 4]],
    [width, height]: [u32; 2],
    exposure: Exposure,
) -> Result<PathBuf, String> {
    // On a screen the background is part of the picture.
    let color = colors.iter().map(|&[r, g, b, _]| [r, g, b, 1.0]).collect();
    let picture = Picture { width, height, color, ..Picture::default() };
    let options = WriteOptions { tone: exposure.tone, exposure: exposure.stops, ..WriteOptions::default() };
    let bytes = encode(&picture, PictureFormat::PNG, &options).map_err(|error| error.to_string())?;
    let name = |number: u32| folder.join(format!("view-{number:04}.png"));
    let free = (1..u32::MAX).map(name).find(|path| !path.exists()).ok_or("all file names are in use")?;
    replace_file(&free, &bytes).map_err(|error| error.to_string())?;
    Ok(free)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_count_up_and_pixels_are_kept() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let colors = [[0.25, 0.5, 1.0, 0.0], [2.0, 0.0, 0.0, 1.0]];
        let exposure = Exposure { stops: 1.0, ..Exposure::default() };
        let first = write(folder.path(), &colors, [2, 1], exposure).expect("it can be written");
        let second = write(folder.path(), &colors, [2, 1], exposure).expect("it can be written");
        assert!(
            first.ends_with("view-0001.png") && second.ends_with("view-0002.png"),
            "{first:?} {second:?}"
        );
        let picture = gnurt::image::read(&first).expect("a picture");
        let [r, g, b, a] = picture.pixel(0, 0).expect("a pixel");
        assert!(
            (r - 0.5).abs() < 0.01 && g == 1.0 && b == 1.0 && a == 1.0,
            "a stop brighter: {r} {g} {b} {a}"
        );
        let nowhere = write(&folder.path().join("none"), &colors, [2, 1], exposure);
        assert!(nowhere.is_err_and(|why| why.contains("none")), "the file is named");
    }
}
