// SPDX-License-Identifier: GPL-3.0-or-later
//! Mip levels of a picture whose file has none: each half as large as the one before, sampled between its
//! texels. Sizes and values are those of OpenImageIO's `automip`, values rounded to the type of the file. A
//! picture marked as a texture stays as it is: its maker chose to have no levels.

use gnurt_image::{Stored, StoredLevel, StoredValues};

/// Sides of the tiles of the copies.
const TILE: usize = 64;

/// The picture shown whole, with copies down to one texel.
pub(super) fn with_copies(file: Stored) -> Stored {
    let mut file = shown(file);
    if file.levels.len() > 1 || file.text("textureformat").is_some() {
        return file;
    }
    while let Some(last) = file.levels.last().filter(|level| level.width > 1 || level.height > 1) {
        let half = halved(last, file.channels);
        file.levels.push(half);
    }
    file
}

fn halved(finer: &StoredLevel, channels: usize) -> StoredLevel {
    let [width, height] = [finer.width, finer.height].map(|n| (n / 2).max(1));
    // The texels on both sides of each position, and the weight of the second.
    let samples = |n: usize, of: usize| -> Vec<(usize, usize, f32)> {
        let sample = |i: usize| {
            let x = (i as f32 + 0.5) / n as f32 * of as f32 - 0.5;
            let low = x.floor();
            (low as usize, (low as usize + 1).min(of - 1), x - low)
        };
        (0..n).map(sample).collect()
    };
    let (columns, rows) = (samples(width, finer.width), samples(height, finer.height));
    let mut values = Vec::with_capacity(width * height * channels);
    for &(y0, y1, t) in &rows {
        for &(x0, x1, s) in &columns {
            for c in 0..channels {
                let get = |x: usize, y: usize| finer.values.get((y * finer.width + x) * channels + c);
                let row = |y: usize| get(x0, y) * (1.0 - s) + get(x1, y) * s;
                values.push(row(y0) * (1.0 - t) + row(y1) * t);
            }
        }
    }
    let values = match finer.values {
        StoredValues::U8(_) => StoredValues::U8(values.iter().map(|x| (x * 255.0).round() as u8).collect()),
        StoredValues::U16(_) => {
            StoredValues::U16(values.iter().map(|x| (x * 65535.0).round() as u16).collect())
        }
        StoredValues::F32(_) => StoredValues::F32(values),
    };
    StoredLevel { width, height, tile: Some([width.min(TILE), height.min(TILE)]), values }
}

/// The contents of the display window; black where the file has no values.
fn shown(file: Stored) -> Stored {
    if file.window == file.display || file.levels.len() > 1 {
        return file;
    }
    let [left, top, right, bottom] = file.display.map(i64::from);
    let [from_x, from_y, ..] = file.window.map(i64::from);
    let (width, height) = ((right - left + 1).max(1) as usize, (bottom - top + 1).max(1) as usize);
    let level = &file.levels[0];
    let mut values = vec![0.0; width * height * file.channels];
    for y in 0..height {
        for x in 0..width {
            let sample = [x as i64 + left - from_x, y as i64 + top - from_y].map(usize::try_from);
            let [Ok(column), Ok(row)] = sample else { continue };
            if column < level.width && row < level.height {
                let (from, to) =
                    ((row * level.width + column) * file.channels, (y * width + x) * file.channels);
                for c in 0..file.channels {
                    values[to + c] = level.values.get(from + c);
                }
            }
        }
    }
    let level = StoredLevel { width, height, tile: None, values: StoredValues::F32(values) };
    Stored { levels: vec![level], ..file }
}
