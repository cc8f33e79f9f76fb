// SPDX-License-Identifier: GPL-3.0-or-later
//! Averages light of neighbours on one surface until enough samples contribute: in steps of doubling
//! distance, so that few neighbours cover a wide circle.
//! Source: [DSHL10] (steps that double, edges kept). Differs: samples are counted, and the noise is known
//! only for the whole picture; pixels with enough samples stay unchanged, so that light becomes sharper over
//! time. Rows go through all steps in succession, in bands, so that the data of a step stays in a cache.
//! Invariant: no light comes from another surface; the mean over a surface stays; bands are invisible. Tests:
//! `tests`, and crates/render/tests/motion.rs (any number of threads).

use glam::Vec3;
use gnurt_accel::threads::{self, Pieces};
use gnurt_shading::real::{Real, Vector};
use gnurt_simd::{Level, dispatch_wide, f32x16, prelude::*};

use super::noise::Noise;
use super::surface_key::{Light, Same, SurfaceKey, Tint};

/// Sufficient samples of a pixel, at a mean square error of one.
const ENOUGH: f32 = 100.0;
/// Largest factor of the number of samples for greater errors.
const MOST_TIMES: f32 = 64.0;
/// Samples count at most this many times the known light if 100 samples are enough. If more are needed, the
/// limit rises by the same factor, up to this one: samples farther away than the steps reach never
/// contribute.
const SPARK: f32 = 16.0;
const MOST_SPARKS: f32 = 8.0;
/// A step in pixels, and the weights of the direct and of the diagonal neighbours.
type Step = (usize, [f32; 2]);
/// Steps of pictures by the factor of their number of samples: the greater it is, the farther they reach.
const STEPS: [(f32, &[usize]); 3] =
    [(1.5, &[1, 2, 4]), (2.5, &[1, 2, 4, 8]), (f32::INFINITY, &[1, 2, 4, 8, 16])];
/// Weights of a half and a quarter in all but the last step: so they fall evenly from pixel to pixel, and no pattern shows.
const EVEN: [f32; 2] = [0.5, 0.25];
const LAST: [f32; 2] = [0.75, 0.4];
/// Further steps for pixels without samples.
const FAR: [Step; 2] = [(8, LAST), (16, LAST)];
/// Mean squares of relative errors that count as little noise.
const LITTLE: f32 = 1.0;
/// Below this width of lobes, few samples suffice: the pixel is blurred first and becomes sharp over time.
const SHINY: f32 = 0.25;
const ENOUGH_OF_SHINY: f32 = 4.0;
/// Neighbours by row and column, of three each.
const AROUND: [[usize; 2]; 8] = [[0, 0], [0, 1], [0, 2], [1, 0], [1, 2], [2, 0], [2, 1], [2, 2]];

/// Columns on each side of a row that show nothing, so that all neighbours of a pixel are there.
const MARGIN: usize = 16;
/// Rows have this number of lanes, or a multiple.
const LANES: usize = 16;
/// Rows of a band, at least: those around it are averaged by its neighbours as well.
const LEAST_ROWS: usize = 32;

/// Numbers of adjacent pixels of a row, one after the other.
mod shape {
    pub(super) const P: usize = 0;
    pub(super) const NS: usize = 3;
    pub(super) const WIDTH: usize = 6;
    pub(super) const ID: usize = 7;
    /// Samples from which on a pixel stays as it is, after the first step.
    pub(super) const ENOUGH: usize = 8;
    pub(super) const COUNT: usize = 9;
}
mod light {
    pub(super) const MEAN: usize = 0;
    pub(super) const SAMPLES: usize = 3;
    pub(super) const COUNT: usize = 4;
}

/// Whether a pixel is blurred first and becomes sharp over time.
pub(super) fn is_shiny(tint: &Tint) -> bool {
    tint.roughness < SHINY
}

/// How much is averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Strength {
    /// Samples that are enough on shiny surfaces.
    enough_of_shiny: f32,
    sparks: f32,
    steps: &'static [usize],
}

impl Strength {
    /// For samples with these errors, the greatest on rough surfaces and the mean on shiny ones: mean squares of relative errors.
    pub(super) fn of(noise: [f32; 2]) -> Self {
        let times = noise.map(|noise| (noise / LITTLE).clamp(1.0, MOST_TIMES));
        // Under large errors, the image in narrow lobes is hardly visible.
        let enough_of_shiny = (times[1] * times[1] * ENOUGH_OF_SHINY).min(MOST_TIMES * ENOUGH);
        let most_times = times[0].max(enough_of_shiny / ENOUGH);
        let (_, steps) = STEPS.into_iter().find(|&(most, _)| most_times <= most).unwrap_or(STEPS[0]);
        Self { enough_of_shiny, sparks: times[0].min(MOST_SPARKS), steps }
    }

    /// How many times as bright as the light that is known a sample may be: the more are averaged, the less one shows.
    pub(super) fn most_of_one(self) -> f32 {
        SPARK * self.sparks
    }

    /// Its steps with their weights.
    fn steps(self) -> impl Iterator<Item = Step> {
        let last = self.steps.len() - 1;
        self.steps.iter().enumerate().map(move |(k, &step)| (step, if k == last { LAST } else { EVEN }))
    }
}

/// The input of the filter, row by row.
#[derive(Clone, Copy)]
pub(super) struct Given<'a> {
    pub(super) width: usize,
    pub(super) surface_keys: &'a [SurfaceKey],
    pub(super) tints: &'a [Tint],
    pub(super) lights: &'a [Light],
    /// Errors of samples so far.
    pub(super) noise: &'a Noise,
}

/// Averaged light as rows of numbers of each kind, so that adjacent pixels are lanes.
#[derive(Default)]
pub(super) struct Smooth {
    /// Numbers of one kind in a row.
    stride: usize,
    light: Vec<f32>,
}

impl Smooth {
    /// Averages light over surfaces; pixels without any data keep no samples. Call within a pool of threads.
    pub(super) fn smooth(&mut self, given: &Given, strength: Strength, level: Level) {
        let stride = given.width.next_multiple_of(LANES) + 2 * MARGIN;
        let height = given.surface_keys.len() / given.width.max(1);
        self.stride = stride;
        self.light.resize(height * stride * light::COUNT, 0.0);
        let rows = height.div_ceil(2 * rayon::current_num_threads()).max(LEAST_ROWS);
        let bands = Pieces::new(&mut self.light, rows * stride * light::COUNT);
        let smooth = |near: &mut Near, n: usize| near.band(given, n * rows, &mut bands.lock(n), level);
        threads::map_with(true, bands.count(), || Near::new(stride, height, strength), smooth);
        FAR.into_iter().for_each(|step| self.average_far(given, step));
    }

    /// Light on a pixel, with its number of samples.
    #[inline(always)]
    pub(super) fn light(&self, x: usize, y: usize) -> Light {
        let at = |k: usize| self.light[(y * light::COUNT + k) * self.stride + MARGIN + x];
        let mean = Vec3::new(at(light::MEAN), at(light::MEAN + 1), at(light::MEAN + 2));
        Light { mean, count: at(light::SAMPLES) }
    }

    /// Averages neighbours at this distance, for pixels of surfaces that have no samples.
    fn average_far(&mut self, given: &Given, (step, [neighbours, corner]): Step) {
        let Given { width, surface_keys, .. } = *given;
        let of_row = |y: usize| -> Vec<(usize, Light)> {
            let keys_of_row = &surface_keys[y * width..][..width];
            let first = (y * light::COUNT + light::SAMPLES) * self.stride + MARGIN;
            let counts = &self.light[first..first + width];
            let unknown = |x: &usize| keys_of_row[*x].is_surface() && counts[*x] <= 0.0;
            let query = |x: usize| {
                let mut sum = Light::default();
                for [row, column] in AROUND {
                    // Beyond all where it would be left of or above all.
                    let (left, above) =
                        ((x + column * step).wrapping_sub(step), (y + row * step).wrapping_sub(step));
                    if left >= width || above >= surface_keys.len() / width {
                        continue;
                    }
                    if keys_of_row[x].agrees(&surface_keys[above * width + left], step as f32) {
                        let weight = if row == 1 || column == 1 { neighbours } else { corner };
                        sum.add(&self.light(left, above), weight);
                    }
                }
                sum.averaged()
            };
            (0..width).filter(unknown).map(|x| (x, query(x))).filter(|(_, light)| light.count > 0.0).collect()
        };
        let found: Vec<Vec<(usize, Light)>> = threads::map(true, surface_keys.len() / width.max(1), of_row);
        for (y, found) in found.iter().enumerate() {
            for (x, light) in found {
                for (k, number) in light.mean.to_array().into_iter().chain([light.count]).enumerate() {
                    self.light[(y * light::COUNT + k) * self.stride + MARGIN + x] = number;
                }
            }
        }
    }
}

/// Rows that steps read from each other, so few that they stay in a cache: each new row replaces one that is
/// no longer needed.
struct Near {
    strength: Strength,
    stride: usize,
    height: usize,
    /// Rows before and behind a band that its steps read.
    ahead: usize,
    /// From the first row in use to the last finished one.
    shape: Vec<f32>,
    /// Light before each step.
    light: Vec<Vec<f32>>,
}

impl Near {
    fn new(stride: usize, height: usize, strength: Strength) -> Self {
        let rows = |count: usize, numbers: usize| vec![0.0; count * numbers * stride];
        let (ahead, last) = (strength.steps.iter().sum(), strength.steps[strength.steps.len() - 1]);
        Self {
            strength,
            stride,
            height,
            ahead,
            shape: rows(ahead + last + 1, shape::COUNT),
            light: strength.steps.iter().map(|step| rows(2 * step + 1, light::COUNT)).collect(),
        }
    }

    /// Averages the rows of `out`, the first of which is row `top` of all: one row after the other goes
    /// through all steps, each as soon as its input rows exist.
    fn band(&mut self, given: &Given, top: usize, out: &mut [f32], level: Level) {
        let bottom = top + out.len() / (self.stride * light::COUNT);
        let all = self.ahead;
        for last in top.saturating_sub(all)..bottom + all {
            if last < self.height {
                self.fill(given, last);
            }
            let mut ahead = 0;
            for (k, step) in self.strength.steps().enumerate() {
                ahead += step.0;
                // Rows around the band that later steps read.
                let around = all - ahead;
                let Some(y) = last.checked_sub(ahead) else { break };
                if y + around >= top && y < (bottom + around).min(self.height) {
                    self.step((k, step), y, (top, &mut *out), level);
                }
            }
        }
    }

    /// Takes over a row.
    fn fill(&mut self, given: &Given, y: usize) {
        let Self { strength, stride, shape, light, .. } = self;
        let (stride, width) = (*stride, given.width);
        let row = y * width..(y + 1) * width;
        let [x, y_, z, u, v, w, wide, id, enough] =
            planes_of(row_mut(shape, y, stride * shape::COUNT), stride, width);
        given.noise.on_row(y, enough);
        for (i, (surface_key, tint)) in
            given.surface_keys[row.clone()].iter().zip(&given.tints[row.clone()]).enumerate()
        {
            [x[i], y_[i], z[i]] = surface_key.p.to_array();
            [u[i], v[i], w[i]] = surface_key.ns.to_array();
            (wide[i], id[i]) = (surface_key.width, surface_key.number());
            enough[i] = match is_shiny(tint) {
                true => strength.enough_of_shiny,
                false => (enough[i] / LITTLE).clamp(1.0, MOST_TIMES) * ENOUGH,
            };
        }
        let [r, g, b, n] = planes_of(row_mut(&mut light[0], y, stride * light::COUNT), stride, width);
        for (i, light) in given.lights[row].iter().enumerate() {
            [r[i], g[i], b[i]] = light.mean.to_array();
            n[i] = light.count;
        }
    }

    /// A row after a step, and the number of that.
    fn step(&mut self, (k, step): (usize, Step), y: usize, (top, out): (usize, &mut [f32]), level: Level) {
        let Self { stride, height, shape, light, .. } = self;
        let (before, after) = light.split_at_mut(k + 1);
        let numbers = *stride * light::COUNT;
        let out = match after.first_mut() {
            Some(next) => row_mut(next, y, numbers),
            None => &mut out[(y - top) * numbers..][..numbers],
        };
        let from = From { stride: *stride, height: *height, shape, light: &before[k] };
        let step = (step, k == 0);
        dispatch_wide!(
            level,
            simd => from.row(f32x16::splat(simd, 0.0), y, step, out),
            else from.row(0.0_f32, y, step, out)
        );
    }
}

/// Row `y` of all, in a ring buffer of rows of this many numbers.
fn row_of(some: &[f32], y: usize, numbers: usize) -> &[f32] {
    &some[y % (some.len() / numbers) * numbers..][..numbers]
}

fn row_mut(some: &mut [f32], y: usize, numbers: usize) -> &mut [f32] {
    let first = y % (some.len() / numbers) * numbers;
    &mut some[first..][..numbers]
}

/// The numbers of each kind in a row, without margins.
fn planes_of<const N: usize>(row: &mut [f32], stride: usize, width: usize) -> [&mut [f32]; N] {
    let mut planes = row.chunks_exact_mut(stride);
    std::array::from_fn(|_| &mut planes.next().expect("as many as there are")[MARGIN..MARGIN + width])
}

/// Rows that a step reads.
struct From<'a> {
    stride: usize,
    /// Of all rows.
    height: usize,
    shape: &'a [f32],
    light: &'a [f32],
}

impl From<'_> {
    /// A row after a step; after the first one pixels stay as they are that have enough. `like` only selects
    /// the number of lanes.
    #[inline(always)]
    fn row<R: Real>(
        &self,
        like: R,
        y: usize,
        ((step, [neighbours, corner]), is_first): (Step, bool),
        out: &mut [f32],
    ) {
        let stride = self.stride;
        let zero = like.all(0.0);
        let shape_of = |y: usize| row_of(self.shape, y, stride * shape::COUNT);
        let light_of = |y: usize| row_of(self.light, y, stride * light::COUNT);
        let (own_shape, own_light) = (shape_of(y), light_of(y));
        let above = y.checked_sub(step);
        let below = Some(y + step).filter(|&y| y < self.height);
        let near = [above, Some(y), below].map(|y| y.map(|y| (shape_of(y), light_of(y))));
        for first in (MARGIN..stride - MARGIN).step_by(R::LANES) {
            let (mean, own) = light_at(zero, own_light, stride, first);
            let enough = zero.load(own_shape, shape::ENOUGH * stride + first);
            let has_enough = if is_first { zero.above(zero) } else { !enough.above(own) };
            let mut keep = |mean: Vector<R>, n: R| {
                for (k, plane) in [mean.x, mean.y, mean.z, n].into_iter().enumerate() {
                    plane.store(out, k * stride + first);
                }
            };
            if !R::any(!has_enough) {
                keep(mean, own);
                continue;
            }
            let (p, ns) = (
                vector_at(zero, own_shape, shape::P, stride, first),
                vector_at(zero, own_shape, shape::NS, stride, first),
            );
            let wide = zero.load(own_shape, shape::WIDTH * stride + first);
            let id = zero.load(own_shape, shape::ID * stride + first);
            let same = Same::new(wide, step as f32);
            let (mut sum, mut n) = (mean * own, own);
            for [row, column] in AROUND {
                let weight = if row == 1 || column == 1 { neighbours } else { corner };
                let Some((shape, light)) = near[row] else { continue };
                let other = first + column * step - step;
                let offset = vector_at(zero, shape, shape::P, stride, other) - p;
                let cos = vector_at(zero, shape, shape::NS, stride, other).dot(ns);
                let is_same = same.holds(offset.length_squared(), offset.dot(ns), cos)
                    & id.is(zero.load(shape, shape::ID * stride + other));
                let (mean, count) = light_at(zero, light, stride, other);
                let count = R::pick(is_same, count * weight, zero);
                (sum, n) = (sum + mean * count, n + count);
            }
            let stays = has_enough | !n.above(zero);
            let scale = zero.all(1.0) / n;
            keep(Vector::pick(stays, mean, sum * scale), R::pick(stays, own, n));
        }
    }
}

/// Three kinds of numbers.
#[inline(always)]
fn vector_at<R: Real>(like: R, row: &[f32], kind: usize, stride: usize, at: usize) -> Vector<R> {
    let number = |k: usize| like.load(row, (kind + k) * stride + at);
    Vector { x: number(0), y: number(1), z: number(2) }
}

#[inline(always)]
fn light_at<R: Real>(like: R, row: &[f32], stride: usize, at: usize) -> (Vector<R>, R) {
    (vector_at(like, row, light::MEAN, stride, at), like.load(row, light::SAMPLES * stride + at))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor, and from column 20 on another object; each sixteenth pixel has a sample.
    fn smoothed(strength: f32, light_at: impl Fn(usize) -> f32) -> Vec<Light> {
        let width = 40;
        let noise = Noise::of(strength);
        let strength = Strength::of([strength; 2]);
        let at = |i: usize| ((i % width) as f32, (i / width) as f32);
        let surface_key = |i: usize| {
            let (x, y) = at(i);
            SurfaceKey { p: Vec3::new(x, y, 0.0), ns: Vec3::Z, id: if x < 20.0 { 1 } else { 3 }, width: 1.0 }
        };
        let surface_keys: Vec<SurfaceKey> = (0..40 * 32).map(surface_key).collect();
        let tints = vec![Tint { roughness: 1.0, ..Tint::default() }; surface_keys.len()];
        let light = |i: usize| {
            let (x, y) = at(i);
            let count = if (x as u32 + 4 * (y as u32 % 4)).is_multiple_of(16) { 1.0 } else { 0.0 };
            let mean = if x < 20.0 { light_at(i) } else { 100.0 };
            Light { mean: Vec3::splat(if count > 0.0 { mean } else { 0.0 }), count }
        };
        let lights: Vec<Light> = (0..surface_keys.len()).map(light).collect();
        let all = Level::available().into_iter().map(|level| {
            let mut smooth = Smooth::default();
            let given =
                Given { width, surface_keys: &surface_keys, tints: &tints, lights: &lights, noise: &noise };
            smooth.smooth(&given, strength, level);
            (0..surface_keys.len()).map(|i| smooth.light(i % width, i / width)).collect::<Vec<Light>>()
        });
        let all: Vec<Vec<Light>> = all.collect();
        let bits = |lights: &[Light]| -> Vec<[u32; 3]> {
            lights.iter().map(|light| light.mean.to_array().map(f32::to_bits)).collect()
        };
        assert!(all.iter().all(|lights| bits(lights) == bits(&all[0])), "the same at each level");
        all[0].clone()
    }

    #[test]
    fn few_samples_light_whole_surfaces() {
        for (i, light) in smoothed(0.0, |_| 2.0).into_iter().enumerate() {
            let requested = if i % 40 < 20 { 2.0 } else { 100.0 };
            assert!(light.count > 0.0 && (light.mean.x - requested).abs() < 1e-3, "pixel {i}: {light:?}");
        }
    }

    #[test]
    fn noise_becomes_less_and_means_stay() {
        // One of three samples is bright.
        let noise = |i: usize| if (i / 160 + i % 40 / 4).is_multiple_of(3) { 6.0 } else { 0.0 };
        let [little, much] = [0.0, 1000.0].map(|noise_known| {
            let lights = smoothed(noise_known, noise);
            let near: Vec<f32> =
                (0..lights.len()).filter(|i| i % 40 < 20).map(|i| lights[i].mean.x).collect();
            let mean = near.iter().sum::<f32>() / near.len() as f32;
            let spread = near.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / near.len() as f32;
            assert!((mean - 2.0).abs() < 0.5, "mean {mean}");
            spread
        });
        assert!(little < 2.0 && much < 0.1 * little, "variances {little} and {much} instead of 8");
    }

    #[test]
    fn more_noise_is_averaged_more() {
        let of = |wide: f32, shiny: f32| {
            let strength = Strength::of([wide * LITTLE, shiny * LITTLE]);
            (strength.most_of_one(), strength.enough_of_shiny, strength.steps.len())
        };
        let most = MOST_TIMES * ENOUGH;
        assert_eq!(of(0.0, 1.0), (SPARK, ENOUGH_OF_SHINY, 3), "no less");
        assert_eq!(of(2.0, 5.0), (2.0 * SPARK, 25.0 * ENOUGH_OF_SHINY, 4));
        assert_eq!(of(0.5, 1e9), (SPARK, most, 5), "as far as shiny ones want");
        assert_eq!(of(1e9, 0.0), (MOST_SPARKS * SPARK, ENOUGH_OF_SHINY, 5), "no more");
    }
}
