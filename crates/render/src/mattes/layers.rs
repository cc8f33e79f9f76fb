// SPDX-License-Identifier: GPL-3.0-or-later
//! Mattes as layers of a picture: pairs of id and coverage, two in each layer.
//! Source: [FJ16], version 1.2.0: `CryptoObject00` with R = the first id, G = its coverage, B and A the second.
//! Tests: crates/render/tests/mattes.rs, crates/cli/tests/program/mattes.rs.

use gnurt_image::{Layer, Picture};

use super::kinds::Mattes;
use crate::film::TileFilm;
use crate::pixel_grid::PixelGrid;

/// Adds the layers of all tiles.
pub(crate) fn add_mattes(picture: &mut Picture, tiles: &[TileFilm], grid: PixelGrid, mattes: &Mattes) {
    for (kind, which) in mattes.kinds.iter().enumerate() {
        let count = mattes.layers() as usize;
        let mut planes = vec![vec![0.0_f32; grid.count()]; 4 * count];
        for tile in tiles.iter().filter(|tile| tile.samples > 0) {
            let scale = 1.0 / f64::from(tile.samples);
            for (i, pixel) in tile.pixels().enumerate() {
                let at = grid.at(pixel);
                for (rank, (id, weight)) in
                    tile.mattes.ranked(kind, i).into_iter().take(2 * count).enumerate()
                {
                    planes[2 * rank][at] = f32::from_bits(id);
                    planes[2 * rank + 1][at] = (f64::from(weight) * scale) as f32;
                }
            }
        }
        let mut planes = planes.into_iter();
        for number in 0..count {
            let four: Vec<(&str, Vec<f32>)> = ["R", "G", "B", "A"].into_iter().zip(planes.by_ref()).collect();
            picture.layers.push(Layer::floats(&format!("{}{number:02}", which.layer()), four));
        }
    }
}
