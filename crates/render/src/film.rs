// SPDX-License-Identifier: GPL-3.0-or-later
//! Sums per pixel of a tile, in double precision, in the order of the samples.
//! Source: original. Memory does not depend on the number of samples.
//! Invariant: all pixels of a tile have the same number of samples; sums do not depend on how samples were cut in passes.
//! Proof: crates/render/tests/{determinism,accumulation}.rs.

use glam::Vec3;

use crate::aov::TileAovs;
use crate::checkpoint::{Words, word_f64, word_u32};
use crate::options::RenderOptions;

/// A rectangle of pixels that one thread renders at a time.
#[derive(Clone, Debug)]
pub(crate) struct TileFilm {
    /// Left, upper, right and lower edge in pixels; the latter two exclusive.
    pub(crate) rect: [u32; 4],
    /// Red, green, blue and opacity, summed over samples, row by row.
    pub(crate) sums: Vec<[f64; 4]>,
    /// Samples of each pixel so far.
    pub(crate) samples: u32,
    /// Other layers, if they were asked for.
    pub(crate) aovs: Option<TileAovs>,
    /// Cost per pixel so far, if it was asked for.
    pub(crate) costs: Vec<u64>,
    /// Squares of red, green and blue, summed over samples; empty if nobody asks for the variance.
    pub(crate) squares: Vec<[f64; 3]>,
    /// Samples that it shall get; 0 = not decided, all that the options say.
    pub(crate) target: u32,
}

/// Tiles are square, this many pixels wide, and lie on a grid from the picture's upper left corner.
pub(crate) const TILE: u32 = 16;

impl TileFilm {
    /// The parts of the tile grid that lie in a region.
    pub(crate) fn cover(region: [u32; 4], options: &RenderOptions) -> Vec<Self> {
        let [x0, y0, x1, y1] = region;
        let starts = |low: u32, high: u32| (low / TILE * TILE..high).step_by(TILE as usize);
        starts(y0, y1)
            .flat_map(|y| starts(x0, x1).map(move |x| [x, y]))
            .map(|[x, y]| [x.max(x0), y.max(y0), (x + TILE).min(x1), (y + TILE).min(y1)])
            .map(|rect| {
                let mut tile = Self::new(rect, options.aovs, options.aovs);
                if options.heatmap {
                    tile.costs = vec![0; tile.sums.len()];
                }
                tile
            })
            .collect()
    }

    pub(crate) fn new(rect: [u32; 4], aovs: bool, squares: bool) -> Self {
        let pixels = ((rect[2] - rect[0]) * (rect[3] - rect[1])) as usize;
        let sums = vec![[0.0; 4]; pixels];
        let squares = if squares { vec![[0.0; 3]; pixels] } else { Vec::new() };
        let aovs = aovs.then(|| TileAovs::new(pixels));
        Self { rect, sums, samples: 0, aovs, costs: Vec::new(), squares, target: 0 }
    }

    /// Forgets all samples; keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.sums.fill([0.0; 4]);
        self.squares.fill([0.0; 3]);
        (self.samples, self.target) = (0, 0);
        self.costs.fill(0);
        if let Some(aovs) = &mut self.aovs {
            *aovs = TileAovs::new(self.sums.len());
        }
    }

    /// Columns and rows of its pixels, row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let [x0, y0, x1, y1] = self.rect;
        (y0..y1).flat_map(move |y| (x0..x1).map(move |x| [x, y]))
    }

    /// Adds one sample to a pixel.
    pub(crate) fn add(&mut self, i: usize, radiance: Vec3, hit: bool) {
        let sum = &mut self.sums[i];
        for k in 0..3 {
            sum[k] += f64::from(radiance[k]);
        }
        sum[3] += f64::from(u8::from(hit));
        if let Some(squares) = self.squares.get_mut(i) {
            for k in 0..3 {
                squares[k] += f64::from(radiance[k]) * f64::from(radiance[k]);
            }
        }
    }

    /// Samples that it shall get, where the options say `spp`.
    pub(crate) fn wanted(&self, spp: u32) -> u32 {
        if self.target > 0 { self.target } else { spp }
    }

    /// Variance of the mean of a pixel, per channel, as if samples were independent: they are spread better than that,
    /// so the true one is smaller. 0 if it is not known.
    pub(crate) fn variance(&self, i: usize) -> [f32; 3] {
        let n = f64::from(self.samples);
        let Some(squares) = self.squares.get(i).filter(|_| self.samples > 1) else { return [0.0; 3] };
        [0, 1, 2].map(|k| {
            let mean = self.sums[i][k] / n;
            ((squares[k] / n - mean * mean).max(0.0) / (n - 1.0)) as f32
        })
    }

    /// The mean of a pixel; black and transparent without samples.
    pub(crate) fn mean(&self, i: usize) -> [f32; 4] {
        let scale = 1.0 / f64::from(self.samples.max(1));
        self.sums[i].map(|sum| (sum * scale) as f32)
    }
}

impl Words for TileFilm {
    fn words(&mut self, with: &mut dyn FnMut(&mut u64)) {
        word_u32(&mut self.samples, with);
        word_u32(&mut self.target, with);
        self.sums.as_flattened_mut().iter_mut().for_each(|x| word_f64(x, with));
        self.squares.as_flattened_mut().iter_mut().for_each(|x| word_f64(x, with));
        self.costs.iter_mut().for_each(&mut *with);
        if let Some(aovs) = &mut self.aovs {
            aovs.words(with);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_each_pixel_once() {
        for region in [[0, 0, 40, 33], [7, 9, 17, 16], [16, 16, 17, 48]] {
            let [x0, y0, x1, y1] = region;
            let mut pixels: Vec<_> = TileFilm::cover(region, &RenderOptions::default())
                .iter()
                .flat_map(TileFilm::pixels)
                .collect();
            pixels.sort_unstable();
            let wanted: Vec<_> = (x0..x1).flat_map(|x| (y0..y1).map(move |y| [x, y])).collect();
            assert_eq!(pixels, wanted, "region {region:?}");
        }
    }
}
