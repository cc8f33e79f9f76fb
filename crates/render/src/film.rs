// SPDX-License-Identifier: GPL-3.0-or-later
//! Sums per pixel of a tile, in double precision, in the order of the samples.
//! Memory does not depend on the number of samples.
//! Invariant: all pixels of a tile have the same number of samples; sums do not depend on how samples were cut in passes.
//! Tests: crates/render/tests/{determinism,accumulation}.rs.

use std::ops::Range;

use glam::Vec3;
use gnurt_accel::HitBatch;
use gnurt_shading::Vec3s;

use crate::aov::TileAovs;
use crate::behind::Behind;
use crate::expressions::LightSums;
use crate::held::Held;
use crate::mattes::TileMattes;
use crate::moments::variance_of_mean;
use crate::options::{Integrator, RenderOptions};
use crate::piece::Piece;
use crate::seen::TileSeen;
use crate::state::{SavedState, put_f64, put_u32};

/// A rectangle of pixels that one thread renders at a time.
#[derive(Clone, Debug)]
pub(crate) struct TileFilm {
    /// Left, upper, right and lower edge in pixels; the latter two exclusive.
    pub(crate) rect: [u32; 4],
    /// Red, green, blue and opacity of the first sample, in the order of [`pixels`](Self::pixels): most
    /// frames of a moving camera hold only this one.
    pub(crate) first: Vec<[f32; 4]>,
    /// The same summed over samples, from the second one on; empty before.
    pub(crate) sums: Vec<[f64; 4]>,
    /// Samples of each pixel so far.
    pub(crate) samples: u32,
    /// Other layers, if requested.
    pub(crate) aovs: Option<TileAovs>,
    /// Layers of light, if requested.
    pub(crate) light: LightSums,
    /// Mattes, if requested.
    pub(crate) mattes: TileMattes,
    /// Cost per pixel so far, if requested.
    pub(crate) costs: Vec<u64>,
    /// Squares of red, green and blue, summed over samples; empty if the variance is not requested.
    pub(crate) squares: Vec<[f64; 3]>,
    /// The number of its samples; 0 = undecided, as in the options.
    pub(crate) target: u32,
}

/// Tiles are square, of this width in pixels, on a grid from the picture's upper left corner. In patterns,
/// where pixels with the same virtual lights are not adjacent, each tile has a block of them; if blocks learn
/// from earlier ones, it has several.
pub(crate) fn tile_size(options: &RenderOptions) -> u32 {
    match options.pattern() {
        Some(n) => n * BLOCK,
        // A pilot may choose virtual lights.
        None if options.integrator.has_virtual_lights() || options.integrator == Integrator::Auto => 2 * TILE,
        None => TILE,
    }
}

const TILE: u32 = 16;
/// So are blocks within a tile: their 64 pixels follow each other, so that rays traced together are a narrow bundle.
pub(crate) const BLOCK: u32 = 8;

impl TileFilm {
    /// The parts of the tile grid in a region, and in the piece of the options.
    pub(crate) fn rects(region: [u32; 4], options: &RenderOptions) -> impl Iterator<Item = [u32; 4]> {
        let [x0, y0, x1, y1] = region;
        let (size, piece, rows) = (tile_size(options), options.piece, options.rows);
        let starts = move |low: u32, high: u32| (low / size * size..high).step_by(size as usize);
        starts(y0, y1)
            .flat_map(move |y| starts(x0, x1).map(move |x| [x, y]))
            .enumerate()
            .filter(move |(i, _)| {
                piece.is_none_or(|Piece { index, count }| i % count as usize == index as usize)
            })
            // Tiles lie within bands: their size divides `BAND_UNIT`.
            .filter(move |&(_, [_, y])| rows.is_none_or(|[top, end]| (top..end).contains(&y)))
            .map(move |(_, [x, y])| [x.max(x0), y.max(y0), (x + size).min(x1), (y + size).min(y1)])
    }

    /// Tiles for all of them.
    pub(crate) fn cover(region: [u32; 4], options: &RenderOptions) -> Vec<Self> {
        Self::rects(region, options)
            .map(|rect| {
                let mut tile = Self::new(rect, options.aovs, options.aovs);
                if let Some(aovs) = tile.aovs.as_mut().filter(|_| options.seen) {
                    aovs.seen = Some(TileSeen::new(tile.first.len()));
                }
                tile.light = LightSums::new(options.light_layers.len(), tile.first.len());
                tile.mattes = TileMattes::new(&options.mattes, tile.first.len());
                if options.heatmap {
                    tile.costs = vec![0; tile.first.len()];
                }
                tile
            })
            .collect()
    }

    pub(crate) fn new(rect: [u32; 4], aovs: bool, squares: bool) -> Self {
        let pixels = ((rect[2] - rect[0]) * (rect[3] - rect[1])) as usize;
        let first = vec![[0.0; 4]; pixels];
        let squares = if squares { vec![[0.0; 3]; pixels] } else { Vec::new() };
        let aovs = aovs.then(|| TileAovs::new(pixels));
        let (sums, costs, light, mattes) = Default::default();
        Self { rect, first, sums, samples: 0, aovs, light, mattes, costs, squares, target: 0 }
    }

    /// Drops all samples; keeps the memory. The first sample will overwrite the old one.
    pub(crate) fn clear(&mut self) {
        self.sums.clear();
        (self.samples, self.target) = (0, 0);
        self.costs.fill(0);
        self.light.clear();
        self.mattes.clear();
        if let Some(aovs) = &mut self.aovs {
            let pixels = self.first.len();
            let seen = aovs.seen.is_some().then(|| TileSeen::new(pixels));
            *aovs = TileAovs::new(pixels);
            aovs.seen = seen;
        }
    }

    /// Columns and rows of its pixels, block by block, each row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let rows = |[x0, y0, x1, y1]: [u32; 4]| (y0..y1).flat_map(move |y| (x0..x1).map(move |x| [x, y]));
        blocks(self.rect).flat_map(rows)
    }

    /// Adds one sample, that of `lanes`, to each pixel; the background `behind` it and holes take their shares of its opacity; returns how many of them were no numbers, and count as black.
    pub(crate) fn add_sample(
        &mut self,
        radiance: &Vec3s,
        (hits, behind, held): (&HitBatch, &[Behind], &[Held]),
        lanes: Range<usize>,
    ) -> u64 {
        let mut bad = 0;
        let Vec3s { x, y, z } = radiance;
        let colors = x[lanes.clone()].iter().zip(&y[lanes.clone()]).zip(&z[lanes.clone()]);
        let samples = colors.zip(lanes).map(|(((&x, &y), &z), lane)| {
            let good = Vec3::new(x, y, z).is_finite();
            bad += u64::from(!good);
            let behind = Behind::of(behind, (hits, radiance), lane).share;
            let opacity = 1.0 - behind - Held::of(held, lane).share;
            // Negative zeros become positive, as in sums.
            if good { [x + 0.0, y + 0.0, z + 0.0, opacity] } else { [0.0, 0.0, 0.0, opacity] }
        });
        let is_first = self.samples == 0;
        if !is_first && self.sums.is_empty() {
            self.sums.extend(self.first.iter().map(|first| first.map(f64::from)));
        }
        self.samples += 1;
        if is_first && self.squares.is_empty() {
            self.first.iter_mut().zip(samples).for_each(|(first, sample)| *first = sample);
            return bad;
        }
        for (i, sample) in samples.enumerate() {
            if is_first {
                self.first[i] = sample;
            } else {
                let sum = &mut self.sums[i];
                (0..4).for_each(|k| sum[k] += f64::from(sample[k]));
            }
            if let Some(squares) = self.squares.get_mut(i) {
                let before = if is_first { [0.0; 3] } else { *squares };
                *squares = [0, 1, 2].map(|k| before[k] + f64::from(sample[k]) * f64::from(sample[k]));
            }
        }
        bad
    }

    /// Sets its only sample to `color` of each pixel.
    pub(crate) fn show(&mut self, color: impl Fn([u32; 2]) -> [f32; 4]) {
        self.clear();
        let mut first = std::mem::take(&mut self.first);
        let mut pixels = first.iter_mut();
        self.pixels().for_each(|pixel| {
            if let Some(first) = pixels.next() {
                *first = color(pixel);
            }
        });
        (self.first, self.samples) = (first, 1);
    }

    /// Memory for its only sample, for every `BLOCK` rows.
    fn strips(&mut self) -> impl Iterator<Item = (u32, Strip<'_>)> {
        self.clear();
        self.samples = 1;
        let [left, top, right, _] = self.rect;
        let pixels = (right - left) * BLOCK;
        let strips = self.first.chunks_mut(pixels as usize);
        (top..).step_by(BLOCK as usize).zip(strips).map(move |(y, colors)| (y, Strip { left, right, colors }))
    }

    /// The number of its samples, if the options request `spp`.
    pub(crate) fn requested(&self, spp: u32) -> u32 {
        if self.target > 0 { self.target.min(spp) } else { spp }
    }

    /// Variance of the mean of a pixel: [`variance_of_mean`]; 0 if it is not known.
    pub(crate) fn variance(&self, i: usize) -> [f32; 3] {
        // There are no sums of a single sample.
        self.squares.get(i).filter(|_| self.samples > 1).map_or([0.0; 3], |squares| {
            let [r, g, b, ..] = self.sums[i];
            variance_of_mean(&[r, g, b], squares, self.samples)
        })
    }

    /// The mean of a pixel; black and transparent without samples.
    pub(crate) fn mean(&self, i: usize) -> [f32; 4] {
        let mut mean = [[0.0; 4]];
        self.write_means(i, &mut mean);
        mean[0]
    }

    /// The means of as many pixels as `memory` holds, from `begin` on; there or where they are anyway.
    pub(crate) fn means<'a>(&'a self, begin: usize, memory: &'a mut [[f32; 4]]) -> &'a [[f32; 4]] {
        if self.samples == 1 {
            return &self.first[begin..begin + memory.len()];
        }
        self.write_means(begin, memory);
        memory
    }

    /// The means of pixels from `begin` on.
    pub(crate) fn write_means(&self, begin: usize, out: &mut [[f32; 4]]) {
        match self.samples {
            0 => out.fill([0.0; 4]),
            1 => out.iter_mut().zip(&self.first[begin..]).for_each(|(out, first)| *out = *first),
            samples => {
                let scale = 1.0 / f64::from(samples);
                for (out, sum) in out.iter_mut().zip(&self.sums[begin..]) {
                    *out = sum.map(|sum| (sum * scale) as f32);
                }
            }
        }
    }
}

/// At most [`BLOCK`] rows of a tile.
struct Strip<'a> {
    left: u32,
    right: u32,
    colors: &'a mut [[f32; 4]],
}

/// At most [`BLOCK`] rows of a picture.
#[derive(Default)]
pub(crate) struct Strips<'a>(Vec<Strip<'a>>);

/// All rows of a picture, [`BLOCK`] of them at a time. Each tile has one sample: the one that will be written.
pub(crate) fn strips(tiles: &mut [TileFilm]) -> Vec<Strips<'_>> {
    let mut all = Vec::new();
    for (y, strip) in tiles.iter_mut().flat_map(TileFilm::strips) {
        let at = (y / BLOCK) as usize;
        if all.len() <= at {
            all.resize_with(at + 1, Strips::default);
        }
        all[at].0.push(strip);
    }
    all
}

impl Strips<'_> {
    /// Sets the colours of these rows, which have `width` pixels each.
    pub(crate) fn show(&mut self, colors: &[[f32; 4]], width: usize) {
        for Strip { left, right, colors: to } in &mut self.0 {
            let mut to = &mut to[..];
            for left in (*left..*right).step_by(BLOCK as usize) {
                let columns = left as usize..(left + BLOCK).min(*right) as usize;
                for row in colors.chunks(width) {
                    let (first, rest) = std::mem::take(&mut to).split_at_mut(columns.len());
                    first.copy_from_slice(&row[columns.clone()]);
                    to = rest;
                }
            }
        }
    }
}

/// The parts of a tile whose pixels follow each other.
pub(crate) fn blocks([x0, y0, x1, y1]: [u32; 4]) -> impl Iterator<Item = [u32; 4]> {
    let starts = |low: u32, high: u32| (low..high).step_by(BLOCK as usize);
    starts(y0, y1)
        .flat_map(move |y| starts(x0, x1).map(move |x| [x, y, (x + BLOCK).min(x1), (y + BLOCK).min(y1)]))
}

impl SavedState for TileFilm {
    fn state(&mut self, with: &mut dyn FnMut(&mut u64)) {
        put_u32(&mut self.samples, with);
        put_u32(&mut self.target, with);
        let mut sums = if self.samples > 1 && !self.sums.is_empty() {
            std::mem::take(&mut self.sums)
        } else {
            self.first.iter().map(|first| first.map(f64::from)).collect()
        };
        sums.as_flattened_mut().iter_mut().for_each(|x| put_f64(x, with));
        // The values of one sample are floats in every format.
        self.first = sums.iter().map(|sum| sum.map(|x| x as f32)).collect();
        self.sums = if self.samples > 1 { sums } else { Vec::new() };
        self.squares.as_flattened_mut().iter_mut().for_each(|x| put_f64(x, with));
        self.costs.iter_mut().for_each(&mut *with);
        if let Some(aovs) = &mut self.aovs {
            aovs.state(with);
        }
        self.light.state(with);
        self.mattes.state(with);
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
            let requested: Vec<_> = (x0..x1).flat_map(|x| (y0..y1).map(move |y| [x, y])).collect();
            assert_eq!(pixels, requested, "region {region:?}");
        }
    }
}
