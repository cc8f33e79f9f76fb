// SPDX-License-Identifier: GPL-3.0-or-later
//! Around every other pixel of every other row, light is fitted to the features of camera rays' hits, among
//! neighbours with similar surroundings; each pixel becomes the mean of all fits that include it.
//! Source: \[BRM*16\], section 4 ("collaborative" regression), with fewer centres: each still meets dozens of fits.
//! Invariant: bands of rows are summed up in an order that does not depend on threads. Tests: `tests`,
//! crates/denoise/tests/filter.rs.

use std::iter::once;

use gnurt_simd::{Level, dispatch};
use rayon::prelude::*;

use crate::light::mean;
use crate::noisy::{Noisy, Triple};
use crate::patches::{Memory, Planes, Reach};
use crate::regression::{Regression, Row, TERMS};

/// Columns and rows from one centre to the next.
const STRIDE: usize = 2;
/// Neighbours that weigh less are left out.
const LEAST: f32 = 1e-3;
/// Normals and albedos are less than this where nothing was met.
const NOTHING: f32 = 1e-3;
/// Normals and albedos are not known better than this.
const UNSURE: f32 = 0.011;

/// A picture that is explained.
pub(crate) struct Layers<'a> {
    /// The features of hits.
    pub(crate) noisy: &'a Noisy,
    /// Light, both the fitted one and the one that determines similarity.
    pub(crate) color: &'a [Triple],
    /// Of that light.
    pub(crate) variance: &'a [Triple],
    /// Where fits have their centres; `None` = everywhere.
    pub(crate) only: Option<&'a [bool]>,
}

/// The sums over all fits.
pub(crate) struct Explained {
    pub(crate) color: Vec<Triple>,
    /// Approximate number of pixels behind each one; 0 where there was no fit and light is unchanged.
    pub(crate) support: Vec<f32>,
}

/// Of one pixel: weighted colours, weights, weighted support.
type Sum = [f32; 5];

impl Explained {
    /// Explains the picture; `None` if `stop` has returned true. Call within a pool of threads.
    pub(crate) fn of(
        level: Level,
        layers: &Layers,
        reach: Reach,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let (width, height) = (layers.noisy.width, layers.noisy.height);
        let planes = Planes::new(reach, width, layers.color, layers.variance);
        let rows: Vec<Row> = (0..layers.color.len()).map(|p| row(layers, p)).collect();
        let variance: Vec<f32> = layers.variance.iter().map(mean).collect();
        let is_empty: Vec<bool> =
            rows.iter().map(|row| row[1..7].iter().all(|x| x.abs() < NOTHING)).collect();
        let (planes, rows, variance, is_empty) = (&planes, &rows[..], &variance[..], &is_empty[..]);
        let around = Around {
            reach,
            planes,
            rows,
            variance,
            is_empty,
            only: layers.only,
            size: [width, height],
            stop,
        };
        let mut sums = vec![[0.0; 5]; width * height];
        // A band's fits reach half a band beyond it: those with even numbers do not meet, nor do those with odd ones.
        let band = (2 * reach.farthest()).next_multiple_of(16);
        for odd in [false, true] {
            let (first, others) =
                sums.split_at_mut(if odd { band / 2 } else { band + band / 2 }.min(height) * width);
            let begin = if odd { band / 2 } else { band + band / 2 };
            let others = others.chunks_mut(2 * band * width).enumerate();
            let others =
                others.map(|(i, part)| (begin + band / 2 + 2 * band * i, begin + 2 * band * i, part));
            let bands: Vec<(usize, usize, &mut [Sum])> =
                if odd { others.collect() } else { once((0, 0, first)).chain(others).collect() };
            let explain = |(centres, begin, sums): (usize, usize, &mut [Sum])| dispatch!(level, _simd => around.explain(centres..(centres + band).min(height), begin, sums));
            bands.into_par_iter().map(explain).collect::<Option<Vec<()>>>()?;
        }
        let support = |sum: &Sum| if sum[3] > LEAST { sum[3].min(sum[4] / sum[3]) } else { 0.0 };
        let color = |(sum, layers): (&Sum, &Triple)| {
            if sum[3] > LEAST { [0, 1, 2].map(|k| sum[k] / sum[3]) } else { *layers }
        };
        Some(Self {
            support: sums.iter().map(support).collect(),
            color: sums.iter().zip(layers.color).map(color).collect(),
        })
    }

    /// Takes the mean of both.
    pub(crate) fn average(&mut self, other: &Self) {
        let mean = |a: &mut f32, b: f32| *a = 0.5 * (*a + b);
        self.color
            .as_flattened_mut()
            .iter_mut()
            .zip(other.color.as_flattened())
            .for_each(|(a, b)| mean(a, *b));
        self.support.iter_mut().zip(&other.support).for_each(|(a, b)| mean(a, *b));
    }
}

/// The features of a pixel.
fn row(layers: &Layers, p: usize) -> Row {
    let (n, a, c) = (layers.noisy.normal[p], layers.noisy.albedo[p], layers.color[p]);
    let (column, row) = (p % layers.noisy.width, p / layers.noisy.width);
    [1.0, n[0], n[1], n[2], a[0], a[1], a[2], column as f32, row as f32, c[0], c[1], c[2]]
}

/// The shared input of all bands.
struct Around<'a> {
    reach: Reach,
    planes: &'a Planes,
    rows: &'a [Row],
    /// Of light, by pixel.
    variance: &'a [f32],
    /// Whether nothing was met in a pixel: light of surfaces does not reach into it.
    is_empty: &'a [bool],
    only: Option<&'a [bool]>,
    size: [usize; 2],
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl Around<'_> {
    /// Adds the fits around the centres of these rows to `sums`, which begin at row `begin`.
    #[inline(always)]
    fn explain(&self, centres: std::ops::Range<usize>, begin: usize, sums: &mut [Sum]) -> Option<()> {
        let count = self.reach.count();
        let (mut memory, mut near) = (Memory::default(), Vec::with_capacity(count));
        let mut weights =
            vec![0.0; (self.size[0] - self.reach.first.min(self.size[0])).div_ceil(STRIDE) * count];
        for y in centres.skip(self.reach.first).step_by(STRIDE) {
            if (self.stop)() {
                return None;
            }
            let only = self.only.map(|only| &only[y * self.size[0]..][..self.size[0]]);
            if only.is_some_and(|row| !row.contains(&true)) {
                continue;
            }
            self.planes.weights(y, STRIDE, &mut memory, &mut weights);
            for (i, weights) in weights.chunks_exact(count).enumerate() {
                let x = i * STRIDE + self.reach.first;
                if only.is_none_or(|row| row[x]) {
                    self.fit([x, y], weights, &mut near, begin, sums);
                }
            }
        }
        Some(())
    }

    /// Fits around one centre, and adds the predictions for its neighbours; `near` is memory.
    #[inline(always)]
    fn fit(
        &self,
        [x, y]: [usize; 2],
        weights: &[f32],
        near: &mut Vec<(usize, f32)>,
        begin: usize,
        sums: &mut [Sum],
    ) {
        let [width, height] = self.size;
        let centre = y * width + x;
        let mut regression = Regression::around(&self.rows[centre]);
        near.clear();
        let (side, step) = (self.reach.side, self.reach.step);
        for (row, weights) in weights.chunks_exact(2 * side + 1).enumerate() {
            let qy = (y + row * step).wrapping_sub(side * step);
            for (column, &weight) in weights.iter().enumerate() {
                let qx = (x + column * step).wrapping_sub(side * step);
                if weight > LEAST && qx < width && qy < height {
                    let q = qy * width + qx;
                    if self.is_empty[q] == self.is_empty[centre] {
                        near.push((q, weight));
                    }
                }
            }
        }
        for &(q, weight) in near.iter() {
            regression.add(weight, &self.rows[q]);
        }
        let Some(fit) = regression.solve(UNSURE, self.variance[centre]) else { return };
        let support = regression.weight();
        for &(q, weight) in near.iter() {
            let color = fit.at(&self.rows[q]);
            let sum = &mut sums[q - begin * width];
            (0..3).for_each(|k| sum[k] += weight * color[k]);
            sum[3] += weight;
            sum[4] += weight * support;
        }
    }
}

const _: () = assert!(TERMS == 9, "a row has so many features");

#[cfg(test)]
mod tests {
    use gnurt_testkit::Random;

    use super::*;

    /// Noise of this variance around 1 + a slope.
    fn noisy(width: usize, height: usize, variance: f32) -> Noisy {
        let mut random = Random::new(3);
        let mut pixels = |value: &mut dyn FnMut(&mut Random, usize) -> Triple| -> Vec<Triple> {
            (0..width * height).map(|p| value(&mut random, p)).collect()
        };
        let spread = (3.0 * variance).sqrt();
        Noisy {
            width,
            height,
            color: pixels(&mut |random, p| {
                [0; 3].map(|_| 1.0 + 0.01 * (p % width) as f32 + random.between(-spread, spread))
            }),
            variance: vec![[variance; 3]; width * height],
            albedo: pixels(&mut |random, _| [0; 3].map(|_| random.between(0.4, 0.41))),
            normal: pixels(&mut |_, _| [0.0, 0.0, 1.0]),
            emission: vec![[0.0; 3]; width * height],
            seen: None,
        }
    }

    #[test]
    fn all_levels_and_numbers_of_threads_give_the_same_bits() {
        let noisy = noisy(61, 47, 0.1);
        let layers = Layers { noisy: &noisy, color: &noisy.color, variance: &noisy.variance, only: None };
        let reach = Reach { side: 3, step: 3, patch: 1, first: 0, sharpness: 0.6 };
        let explain = |level: Level, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| Explained::of(level, &layers, reach, &|| false)).expect("nobody says stop")
        };
        let expected = explain(Level::Scalar, 1);
        for level in Level::available() {
            for threads in [1, 3] {
                let found = explain(level, threads);
                assert!(found.color == expected.color, "{} on {threads} threads", level.name());
                assert!(found.support == expected.support, "{} on {threads} threads", level.name());
            }
        }
    }

    #[test]
    fn the_variance_of_a_slope_falls_by_the_pixels_that_look_alike() {
        let variance = 0.01;
        let noisy = noisy(64, 64, variance);
        let layers = Layers { noisy: &noisy, color: &noisy.color, variance: &noisy.variance, only: None };
        let reach = Reach { side: 5, step: 1, patch: 2, first: 0, sharpness: 0.6 };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
        let found = pool.install(|| Explained::of(Level::default(), &layers, reach, &|| false));
        let found = found.expect("nobody says stop");
        let truth = |p: usize| 1.0 + 0.01 * (p % 64) as f32;
        let squares: f32 = (0..64 * 64).map(|p| (found.color[p][0] - truth(p)).powi(2)).sum();
        let factor = variance * 64.0 * 64.0 / squares;
        // Only a fit of 121 pixels by nine terms would give 13, and each pixel has about thirty fits.
        assert!(factor > 20.0, "the variance falls by {factor}");
        let support: f32 = found.support.iter().sum::<f32>() / (64.0 * 64.0);
        assert!(
            support > 12.0 && support < 121.0,
            "noise makes most of 121 pixels weigh less than one: {support}"
        );
    }

    #[test]
    fn who_says_stop_gets_nothing() {
        let noisy = noisy(20, 20, 0.1);
        let layers = Layers { noisy: &noisy, color: &noisy.color, variance: &noisy.variance, only: None };
        let reach = Reach { side: 3, step: 1, patch: 1, first: 0, sharpness: 0.6 };
        assert!(Explained::of(Level::default(), &layers, reach, &|| true).is_none(), "at once");
    }
}
