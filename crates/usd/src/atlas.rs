// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures in tiles as one picture: files for unit squares of texture coordinates, side by side.
//! All tiles get the size of the largest one. Squares without a file are black and opaque, the fallback of
//! UsdUVTexture. Between tiles texels are blended, as within one.
//! Source: the specification of UsdPreviewSurface (UDIM); names of tiles: `gnurt_image::udim`.
//! Tests: `tests/materials.rs`.

use std::sync::Arc;

use gnurt_image::Budget;
use gnurt_scene::texture::{TexelData, Texels};

/// A tile by column and row, row 0 at the bottom.
pub(crate) type Tile = ([u32; 2], Arc<Texels>);

/// Joins tiles. Returns the picture, and its columns and rows of tiles.
///
/// # Errors
/// It takes too much memory, or there are no tiles.
pub(crate) fn joined(tiles: &[Tile], budget: &Budget) -> Result<(Arc<Texels>, [u32; 2]), String> {
    let most = |of: &dyn Fn(&Tile) -> u32| tiles.iter().map(of).max().ok_or("there are no tiles");
    let count = [most(&|(at, _)| at[0] + 1)?, most(&|(at, _)| at[1] + 1)?];
    let size = [most(&|(_, tile)| tile.width)?, most(&|(_, tile)| tile.height)?];
    let is_all = |is: fn(&TexelData) -> bool| tiles.iter().all(|(_, tile)| is(&tile.data));
    let texel_bytes = match is_all(|data| matches!(data, TexelData::Srgb8(_) | TexelData::Linear8(_))) {
        true => 4,
        false => 16,
    };
    let side = |k: usize| u64::from(count[k]) * u64::from(size[k]);
    let texels = side(0).checked_mul(side(1)).filter(|_| side(0).max(side(1)) <= u64::from(u32::MAX));
    let bytes = texels.and_then(|texels| usize::try_from(texels.checked_mul(texel_bytes)?).ok());
    let bytes = bytes.ok_or("the tiles are too large for one picture")?;
    budget.hold(bytes).map_err(|excess| format!("tiles side by side: {excess}"))?;
    let places = Places { tiles, count, size };
    let data = if is_all(|data| matches!(data, TexelData::Srgb8(_))) {
        TexelData::Srgb8(places.all([0, 0, 0, 255], |data, i| match data {
            TexelData::Srgb8(all) => Some(all[i]),
            _ => None,
        }))
    } else if is_all(|data| matches!(data, TexelData::Linear8(_))) {
        TexelData::Linear8(places.all([0, 0, 0, 255], |data, i| match data {
            TexelData::Linear8(all) => Some(all[i]),
            _ => None,
        }))
    } else {
        TexelData::Float(places.linear())
    };
    Ok((Arc::new(Texels { width: side(0) as u32, height: side(1) as u32, data }), count))
}

struct Places<'a> {
    tiles: &'a [Tile],
    count: [u32; 2],
    size: [u32; 2],
}

impl Places<'_> {
    /// Calls `with(tile, column, row)` for each texel of the picture, row by row from the upper left one; `None` where
    /// there is no tile.
    fn each(&self, mut with: impl FnMut(Option<&Texels>, usize, usize)) {
        let ([columns, rows], [width, height]) = (self.count, self.size);
        for row in (0..rows).rev() {
            let tile =
                |column: u32| self.tiles.iter().find(|(at, _)| *at == [column, row]).map(|(_, tile)| &**tile);
            let across: Vec<Option<&Texels>> = (0..columns).map(tile).collect();
            for y in 0..height {
                for &tile in &across {
                    let own =
                        |i: u32, of: u32, to: u32| (u64::from(i) * u64::from(to) / u64::from(of)) as usize;
                    let [w, h] = tile.map_or([1, 1], |tile| [tile.width, tile.height]);
                    (0..width).for_each(|x| with(tile, own(x, width, w), own(y, height, h)));
                }
            }
        }
    }

    fn all<T: Copy>(&self, missing: T, texel: impl Fn(&TexelData, usize) -> Option<T>) -> Vec<T> {
        let mut out = Vec::new();
        self.each(|tile, x, y| {
            let of = |tile: &Texels| texel(&tile.data, y * tile.width as usize + x);
            out.push(tile.and_then(of).unwrap_or(missing));
        });
        out
    }

    fn linear(&self) -> Vec<[f32; 4]> {
        let mut out = Vec::new();
        self.each(|tile, x, y| out.push(tile.map_or([0.0, 0.0, 0.0, 1.0], |tile| tile.texel(x, y))));
        out
    }
}
