// SPDX-License-Identifier: GPL-3.0-or-later
//! Light of neighbours on one surface is averaged until enough samples have come together: in steps that double, so that few
//! neighbours are asked for a wide circle.
//! Source: [DSHL10] (steps that double, edges kept). Differs: samples are counted, in place of guesses at the noise; pixels that have
//! enough stay as they are, so that light gets sharper the longer it is seen.
//! Invariant: no light comes from another surface; the mean over a surface stays. Proof: `tests`.

use std::ops::Range;

use glam::Vec3;
use gnurt_simd::{Level, dispatch_two};
use rayon::prelude::*;

use super::sight::{Light, Spot, Tint, is_one_surface};

/// Samples that make a pixel good enough.
const ENOUGH: f32 = 160.0;
/// Steps in pixels, and those for pixels alone that know nothing then.
const STEPS: [i32; 3] = [1, 2, 4];
const FAR: [i32; 2] = [8, 16];
/// Lobes narrower than this are averaged over next neighbours only.
const SHINY: f32 = 0.25;
/// Neighbours and their weights.
const AROUND: [(i32, i32, f32); 8] = [
    (-1, -1, 0.5),
    (0, -1, 0.75),
    (1, -1, 0.5),
    (-1, 0, 0.75),
    (1, 0, 0.75),
    (-1, 1, 0.5),
    (0, 1, 0.75),
    (1, 1, 0.5),
];

/// Pixels of a row that are passed over together where all of them stay.
const TOGETHER: usize = 64;

/// A picture as planes of numbers, so that pixels beside each other are lanes.
#[derive(Default)]
pub(super) struct Planes {
    width: usize,
    /// Place, normal, width of a pixel.
    shape: [Vec<f32>; 7],
    id: Vec<u32>,
    /// Light and samples; the same after a step.
    light: [Vec<f32>; 4],
    next: [Vec<f32>; 4],
    /// Samples from which on a pixel stays as it is, after the first step.
    enough: Vec<f32>,
}

impl Planes {
    /// Averages light over surfaces; pixels have no samples where nobody knows anything.
    pub(super) fn smooth(
        &mut self,
        width: usize,
        spots: &[Spot],
        tints: &[Tint],
        lights: &[Light],
        level: Level,
    ) {
        self.fill(width, spots, tints, lights);
        for (k, step) in STEPS.into_iter().enumerate() {
            self.step(step, k == 0, level);
        }
        if self.light[3].iter().zip(&self.id).any(|(&count, &id)| count == 0.0 && id != 0) {
            self.enough.fill(f32::MIN_POSITIVE);
            FAR.into_iter().for_each(|step| self.step(step, false, level));
        }
    }

    /// Light on a pixel, of so many samples.
    pub(super) fn light(&self, i: usize) -> Light {
        let [r, g, b, count] = &self.light;
        Light { mean: Vec3::new(r[i], g[i], b[i]), count: count[i] }
    }

    fn fill(&mut self, width: usize, spots: &[Spot], tints: &[Tint], lights: &[Light]) {
        self.width = width;
        let Self { shape, id, light, next, enough, .. } = self;
        shape
            .iter_mut()
            .chain(light.iter_mut())
            .chain(next.iter_mut())
            .for_each(|plane| plane.resize(spots.len(), 0.0));
        shape.par_iter_mut().enumerate().for_each(|(k, plane)| {
            let number = |spot: &Spot| match k {
                0..3 => spot.p[k],
                3..6 => spot.ns[k - 3],
                _ => spot.width,
            };
            plane.iter_mut().zip(spots).for_each(|(out, spot)| *out = number(spot));
        });
        light.par_iter_mut().enumerate().for_each(|(k, plane)| {
            let number = |light: &Light| if k < 3 { light.mean[k] } else { light.count };
            plane.iter_mut().zip(lights).for_each(|(out, light)| *out = number(light));
        });
        id.clear();
        id.extend(spots.iter().map(|spot| spot.id));
        let stays = |tint: &Tint| if tint.grain < SHINY { f32::MIN_POSITIVE } else { ENOUGH };
        enough.clear();
        enough.extend(tints.iter().map(stays));
    }

    /// Averages each pixel with neighbours so many pixels away.
    fn step(&mut self, step: i32, is_first: bool, level: Level) {
        let Self { width, shape, id, light, next, enough } = self;
        let width = *width;
        let from = From { width, height: id.len() / width.max(1), shape, id, light };
        let [r, g, b, n] = next;
        let rows = r.par_chunks_mut(width).zip(g.par_chunks_mut(width));
        let rows = rows.zip(b.par_chunks_mut(width).zip(n.par_chunks_mut(width))).enumerate();
        rows.for_each(|(y, ((r, g), (b, n)))| {
            let enough = if is_first { None } else { Some(&enough[y * width..(y + 1) * width]) };
            let out = [r, g, b, n];
            dispatch_two!(level, _simd => from.row(y, step, enough, out));
        });
        std::mem::swap(light, next);
    }
}

/// What is averaged.
struct From<'a> {
    width: usize,
    height: usize,
    shape: &'a [Vec<f32>; 7],
    id: &'a [u32],
    light: &'a [Vec<f32>; 4],
}

impl From<'_> {
    /// A row after a step; pixels stay as they are that have `enough`.
    #[inline(always)]
    fn row(&self, y: usize, step: i32, enough: Option<&[f32]>, out: [&mut [f32]; 4]) {
        let width = self.width;
        let [r, g, b, n] = out;
        for first in (0..width).step_by(TOGETHER) {
            let part = first..width.min(first + TOGETHER);
            let out =
                [&mut r[part.clone()], &mut g[part.clone()], &mut b[part.clone()], &mut n[part.clone()]];
            self.part(y, part.clone(), step, enough.map(|enough| &enough[part]), out);
        }
    }

    /// Some of its columns.
    #[inline(always)]
    fn part(&self, y: usize, columns: Range<usize>, step: i32, enough: Option<&[f32]>, out: [&mut [f32]; 4]) {
        let (width, begin) = (self.width, y * self.width + columns.start);
        let [r, g, b, n] = out;
        let count = columns.len();
        let [own_r, own_g, own_b, own_n] = self.light.each_ref().map(|plane| &plane[begin..begin + count]);
        if enough.is_some_and(|enough| own_n.iter().zip(enough).all(|(n, enough)| n >= enough)) {
            r.copy_from_slice(own_r);
            g.copy_from_slice(own_g);
            b.copy_from_slice(own_b);
            return n.copy_from_slice(own_n);
        }
        for i in 0..count {
            (r[i], g[i], b[i], n[i]) =
                (own_r[i] * own_n[i], own_g[i] * own_n[i], own_b[i] * own_n[i], own_n[i]);
        }
        for (dx, dy, weight) in AROUND {
            let (dx, row) = (dx * step, y as i32 + dy * step);
            let low = (-dx).max(columns.start as i32);
            let high = (width as i32 - dx.max(0)).min(columns.end as i32);
            if row >= 0 && row < self.height as i32 && low < high {
                let other = (row * width as i32 + low + dx) as usize;
                let (low, high) = (low as usize - columns.start, high as usize - columns.start);
                let out = [&mut r[low..high], &mut g[low..high], &mut b[low..high], &mut n[low..high]];
                self.tap(begin + low, other, high - low, (step as f32, weight), out);
            }
        }
        for i in 0..count {
            let stays = enough.is_some_and(|enough| own_n[i] >= enough[i]) | (n[i] <= 0.0);
            let scale = 1.0 / n[i];
            let mean = |own: f32, sum: f32| if stays { own } else { sum * scale };
            (r[i], g[i], b[i]) = (mean(own_r[i], r[i]), mean(own_g[i], g[i]), mean(own_b[i], b[i]));
            n[i] = if stays { own_n[i] } else { n[i] };
        }
    }

    /// Adds `count` neighbours from place `other` on to the pixels from `own` on, as far as they show one surface.
    #[inline(always)]
    fn tap(
        &self,
        own: usize,
        other: usize,
        count: usize,
        (pixels, weight): (f32, f32),
        out: [&mut [f32]; 4],
    ) {
        let [x, y, z, u, v, w, width] = self.shape.each_ref().map(|plane| &plane[own..own + count]);
        let [ox, oy, oz, ou, ov, ow, _] = self.shape.each_ref().map(|plane| &plane[other..other + count]);
        let (id, other_id) = (&self.id[own..own + count], &self.id[other..other + count]);
        let [or, og, ob, on] = self.light.each_ref().map(|plane| &plane[other..other + count]);
        let [r, g, b, n] = out.map(|plane| &mut plane[..count]);
        for i in 0..count {
            let (dx, dy, dz) = (ox[i] - x[i], oy[i] - y[i], oz[i] - z[i]);
            let off = dx * u[i] + dy * v[i] + dz * w[i];
            let cos = ou[i] * u[i] + ov[i] * v[i] + ow[i] * w[i];
            let is_same = is_one_surface(dx * dx + dy * dy + dz * dz, off, cos, width[i], pixels)
                & (id[i] == other_id[i]);
            let samples = if is_same { weight * on[i] } else { 0.0 };
            r[i] += or[i] * samples;
            g[i] += og[i] * samples;
            b[i] += ob[i] * samples;
            n[i] += samples;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor, and from column 20 on another thing; each sixteenth pixel has a sample.
    fn smoothed(noise: impl Fn(usize) -> f32) -> Vec<Light> {
        let width = 40;
        let at = |i: usize| ((i % width) as f32, (i / width) as f32);
        let spot = |i: usize| {
            let (x, y) = at(i);
            Spot { p: Vec3::new(x, y, 0.0), ns: Vec3::Z, id: if x < 20.0 { 1 } else { 3 }, width: 1.0 }
        };
        let spots: Vec<Spot> = (0..40 * 32).map(spot).collect();
        let tints = vec![Tint { grain: 1.0, ..Tint::default() }; spots.len()];
        let light = |i: usize| {
            let (x, y) = at(i);
            let count = if (x as u32 + 4 * (y as u32 % 4)).is_multiple_of(16) { 1.0 } else { 0.0 };
            let mean = if x < 20.0 { noise(i) } else { 100.0 };
            Light { mean: Vec3::splat(if count > 0.0 { mean } else { 0.0 }), count }
        };
        let lights: Vec<Light> = (0..spots.len()).map(light).collect();
        let all = Level::available().into_iter().map(|level| {
            let mut planes = Planes::default();
            planes.smooth(width, &spots, &tints, &lights, level);
            (0..spots.len()).map(|i| planes.light(i)).collect::<Vec<Light>>()
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
        for (i, light) in smoothed(|_| 2.0).into_iter().enumerate() {
            let wanted = if i % 40 < 20 { 2.0 } else { 100.0 };
            assert!(light.count > 0.0 && (light.mean.x - wanted).abs() < 1e-3, "pixel {i}: {light:?}");
        }
    }

    #[test]
    fn noise_becomes_less_and_means_stay() {
        let noise = |i: usize| if (i / 40 + i % 40).is_multiple_of(2) { 0.0 } else { 4.0 };
        let lights = smoothed(noise);
        let near: Vec<f32> = (0..lights.len()).filter(|i| i % 40 < 20).map(|i| lights[i].mean.x).collect();
        let mean = near.iter().sum::<f32>() / near.len() as f32;
        let spread = near.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / near.len() as f32;
        assert!((mean - 2.0).abs() < 0.4 && spread < 1.0, "mean {mean}, variance {spread} instead of 4");
    }
}
