// SPDX-License-Identifier: GPL-3.0-or-later
//! The built-in denoiser: around every pixel, colours are explained by what camera rays met, among pixels whose surroundings
//! look alike; each pixel becomes the mean of what all these explanations say of it.
//! Source: \[BRM*16\], with weights from sampled variances instead of two half pictures, and light without albedo instead of
//! colours, so that textures need no explanation.
//!
//! ```text
//! radiance / albedo --+--> weights of neighbours (patches) --+
//! variance / albedo^2-+                                      +--> a fit per pixel --> mean of fits per pixel --> * albedo
//! normal, albedo, position ----------------------------------+
//! ```
//! Invariants: finite and not negative, whatever comes in; tiles do not depend on threads, and their sums are added in order:
//! the same bits on any number of threads. Proof: `tests`.

use rayon::prelude::*;

use crate::noisy::{Noisy, Triple};
use crate::patches::{OFFSETS, REACH, Signal, Weights};
use crate::regression::{Features, Regression};

/// Columns and rows of a tile.
const TILE: usize = 32;
/// Light is divided by no smaller albedo than this.
const DARKEST: f32 = 0.02;
/// Normals and albedos are not known better than this.
const UNSURE: f32 = 0.03;
/// Neighbours that weigh less are left out.
const LEAST: f32 = 1e-3;

/// The colours of the region without noise, row by row; `None` if `stop` has said so.
pub(crate) fn filter(
    noisy: &Noisy,
    pool: &rayon::ThreadPool,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Triple>> {
    let (width, height) = (noisy.width, noisy.height);
    let albedo: Vec<Triple> = noisy.albedo.iter().map(divisor).collect();
    let divide = |values: &[Triple], by: &dyn Fn(f32) -> f32| -> Vec<Triple> {
        values.iter().zip(&albedo).map(|(x, a)| [0, 1, 2].map(|k| x[k] / by(a[k]))).collect()
    };
    let color = divide(&noisy.color, &|a| a);
    let variance = divide(&noisy.variance, &|a| a * a);
    let variance = if variance.iter().all(|v| *v == [0.0; 3]) {
        spatial_variance(&color, width, height)
    } else {
        variance
    };
    let floor = floor(&color, &variance, width, height);
    let variance = smooth(&variance, width, height);
    let signal = Signal { width, height, color: &color, variance: &variance };

    let tiles: Vec<[usize; 4]> = (0..height)
        .step_by(TILE)
        .flat_map(|y| (0..width).step_by(TILE).map(move |x| [x, y]))
        .map(|[x, y]| [x, y, (x + TILE).min(width), (y + TILE).min(height)])
        .collect();
    let explain = |weights: &mut Weights, &tile: &[usize; 4]| {
        (!stop()).then(|| Explained::of(noisy, &signal, weights, tile))
    };
    let explained: Option<Vec<Explained>> =
        pool.install(|| tiles.par_iter().map_init(Weights::new, explain).collect());
    let explained = explained?;
    let mut sums = vec![[0.0f32; 4]; width * height];
    for part in &explained {
        let [x0, y0, x1, _] = part.rect;
        for (row, from) in part.sums.chunks_exact(x1 - x0).enumerate() {
            let start = (y0 + row) * width + x0;
            for (sum, from) in sums[start..start + x1 - x0].iter_mut().zip(from) {
                (0..4).for_each(|k| sum[k] += from[k]);
            }
        }
    }
    let clean = |(i, sum): (usize, &[f32; 4])| {
        [0, 1, 2].map(|k| {
            let light = sum[k] / sum[3];
            let light = if light.is_finite() { light.max(floor[i][k]) } else { color[i][k] };
            (light * albedo[i][k]).clamp(0.0, f32::MAX)
        })
    };
    Some(sums.iter().enumerate().map(clean).collect())
}

/// What light is divided by: the albedo where there is one.
fn divisor(albedo: &Triple) -> Triple {
    if albedo.iter().all(|&a| a < 1e-3) { [1.0; 3] } else { albedo.map(|a| a.max(DARKEST)) }
}

/// What the fits of a tile's pixels say of these and their neighbours.
struct Explained {
    rect: [usize; 4],
    /// Weighted colours and weights.
    sums: Vec<[f32; 4]>,
}

impl Explained {
    fn of(noisy: &Noisy, signal: &Signal, weights: &mut Weights, tile: [usize; 4]) -> Self {
        weights.compute(signal, tile);
        let [x0, y0, x1, y1] = tile;
        let rect = [
            x0.saturating_sub(REACH),
            y0.saturating_sub(REACH),
            (x1 + REACH).min(noisy.width),
            (y1 + REACH).min(noisy.height),
        ];
        let wide = rect[2] - rect[0];
        let mut sums = vec![[0.0; 4]; wide * (rect[3] - rect[1])];
        let pixels = (x1 - x0) * (y1 - y0);
        let mut neighbours: Vec<(usize, f32, Features)> = Vec::with_capacity(OFFSETS);
        for (i, [x, y]) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| [x, y])).enumerate() {
            let p = y * noisy.width + x;
            neighbours.clear();
            let mut regression = Regression::new();
            let mut range = [[f32::MAX; 3], [f32::MIN; 3]];
            for o in 0..OFFSETS {
                let weight = weights.of[o * pixels + i];
                if weight > LEAST {
                    // Weights are 0 outside of the picture.
                    let qx = x + o % (2 * REACH + 1) - REACH;
                    let qy = y + o / (2 * REACH + 1) - REACH;
                    let q = qy * noisy.width + qx;
                    let features = features(noisy, p, q);
                    let color = &signal.color[q];
                    regression.add(weight, &features, color);
                    for k in 0..3 {
                        range[0][k] = range[0][k].min(color[k]);
                        range[1][k] = range[1][k].max(color[k]);
                    }
                    neighbours.push(((qy - rect[1]) * wide + qx - rect[0], weight, features));
                }
            }
            if let Some(fit) = regression.solve(UNSURE) {
                for (place, weight, features) in &neighbours {
                    let color = fit.at(features);
                    let sum = &mut sums[*place];
                    // A slope that noise made overshoots beside bright edges: nothing is darker or brighter than all it is made of.
                    (0..3).for_each(|k| sum[k] += weight * color[k].max(range[0][k]).min(range[1][k]));
                    sum[3] += weight;
                }
            }
        }
        Self { rect, sums }
    }
}

/// What differs between a pixel and its neighbour.
fn features(noisy: &Noisy, p: usize, q: usize) -> Features {
    let mut features = [1.0; 10];
    for k in 0..3 {
        features[1 + k] = noisy.normal[q][k] - noisy.normal[p][k];
        features[4 + k] = noisy.albedo[q][k] - noisy.albedo[p][k];
        features[7 + k] = noisy.position[q][k] - noisy.position[p][k];
    }
    features
}

/// What a pixel and those around it are at least, by all likelihood: slopes overshoot beside bright edges, and would draw dark
/// rims there. There is no such ceiling: what rare bright samples bring must stay.
fn floor(color: &[Triple], variance: &[Triple], width: usize, height: usize) -> Vec<Triple> {
    let least = |i: usize, k: usize| color[i][k] - 2.0 * variance[i][k].max(0.0).sqrt();
    let around = |at: usize, length: usize| at.saturating_sub(1)..(at + 2).min(length);
    let at = |i: usize| {
        let mut floor = [f32::MAX; 3];
        for y in around(i / width, height) {
            for x in around(i % width, width) {
                (0..3).for_each(|k| floor[k] = floor[k].min(least(y * width + x, k)));
            }
        }
        floor
    };
    (0..color.len()).map(at).collect()
}

/// Variances that were found with few samples are noisy themselves: means over 5 x 5 pixels.
fn smooth(variance: &[Triple], width: usize, height: usize) -> Vec<Triple> {
    let mean_along =
        |from: &[Triple], step: usize, length: usize, place: &dyn Fn(usize) -> usize| -> Vec<Triple> {
            let at = |i: usize| {
                let (low, high) = (place(i).min(2), (length - 1 - place(i)).min(2));
                let mut sum = [0.0; 3];
                for j in 0..=low + high {
                    let value = from[i - low * step + j * step];
                    (0..3).for_each(|k| sum[k] += value[k]);
                }
                sum.map(|x| x / (low + high + 1) as f32)
            };
            (0..from.len()).map(at).collect()
        };
    let rows = mean_along(variance, 1, width, &|i| i % width);
    mean_along(&rows, width, height, &|i| i / width)
}

/// Half the mean square difference to the neighbours below and to the right, where samples tell no variance.
fn spatial_variance(color: &[Triple], width: usize, height: usize) -> Vec<Triple> {
    let at = |i: usize| {
        let (x, y) = (i % width, i / width);
        let right = if x + 1 < width { i + 1 } else { i };
        let below = if y + 1 < height { i + width } else { i };
        [0, 1, 2].map(|k| {
            let (a, b) = (color[i][k] - color[right][k], color[i][k] - color[below][k]);
            0.5 * (a * a).min(b * b)
        })
    };
    (0..color.len()).map(at).collect()
}
