// SPDX-License-Identifier: GPL-3.0-or-later
//! The colours of a picture that grows, in bands: rows of tiles, which threads take one after the other and go on with while they
//! are in the cache. Bands do not overlap, and all of them together are the region that was rendered.
//! Tests: crates/render/tests/accumulation.rs.

use std::ops::Range;

use crate::film::{self, BLOCK, TileFilm};

/// Some rows of a picture; see [`Accumulation::film_bands`](crate::Accumulation::film_bands).
#[derive(Clone, Copy, Debug)]
pub struct FilmBand<'a> {
    /// Adjacent ones; at least one.
    tiles: &'a [TileFilm],
}

impl<'a> FilmBand<'a> {
    /// All of them, from the upper one on.
    pub(crate) fn all_of(tiles: &'a [TileFilm]) -> impl Iterator<Item = Self> {
        tiles.chunk_by(|a, b| a.rect[1] == b.rect[1]).map(|tiles| Self { tiles })
    }

    /// Which rows of the picture.
    #[must_use]
    pub fn rows(&self) -> Range<u32> {
        let [_, top, _, bottom] = self.tiles[0].rect;
        top..bottom
    }

    /// Calls `with([column, row], colours)` for pieces of rows, of which the first pixel is at that column and row, in any
    /// order: each pixel once, red, green, blue and opacity, the mean of its samples.
    pub fn pieces(&self, mut with: impl FnMut([u32; 2], &[[f32; 4]])) {
        let mut means = [[0.0; 4]; BLOCK as usize];
        for tile in self.tiles {
            let mut begin = 0;
            for [x0, y0, x1, y1] in film::blocks(tile.rect) {
                let means = &mut means[..(x1 - x0) as usize];
                for y in y0..y1 {
                    with([x0, y], tile.means(begin, means));
                    begin += means.len();
                }
            }
        }
    }
}

/// Some rows of a picture that are still to be written; see [`Accumulation::color_bands`](crate::Accumulation::color_bands).
#[derive(Debug)]
pub struct ColorBand<'a> {
    film: FilmBand<'a>,
    colors: &'a mut [[f32; 4]],
    width: usize,
}

impl<'a> ColorBand<'a> {
    pub(crate) fn new(film: FilmBand<'a>, colors: &'a mut [[f32; 4]], width: usize) -> Self {
        Self { film, colors, width }
    }

    /// Which rows of the picture.
    #[must_use]
    pub fn rows(&self) -> Range<u32> {
        self.film.rows()
    }

    /// Writes the colours, and shows them: whole rows, from the upper one on.
    pub fn write(self) -> &'a [[f32; 4]] {
        let top = self.rows().start;
        self.film.pieces(|[x, y], means| {
            let begin = (y - top) as usize * self.width + x as usize;
            let end = (begin + means.len()).min(self.colors.len());
            if let Some(pixels) = self.colors.get_mut(begin..end) {
                pixels.copy_from_slice(&means[..end - begin]);
            }
        });
        self.colors
    }
}
