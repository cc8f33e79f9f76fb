// SPDX-License-Identifier: GPL-3.0-or-later
//! The watertight ray-triangle test: no ray passes between triangles that share an edge or a corner.
//! Source: [WBW13]: translate to the ray's origin, shear so that the ray is the z axis, decide by the signs of three
//! 2D edge functions. Differs: the fallback to double precision is taken for any edge function that is too small or
//! too large for a float, not only for zeros, and ends in double precision; `t` is clamped to the corners' depths.
//!
//! Why it holds: a corner's sheared position depends on ray and corner alone, so both triangles at an edge see the
//! same two points. Rounding is monotonic, so `fl(a*b) - fl(c*d)` never has the wrong sign, it can only be zero; then
//! products in double precision are exact and their difference has the right sign.
//! Proof: `tests::agrees_with_double_precision`, `tests/watertight.rs`.

use super::Meeting;
use crate::Ray;

/// Edge functions of a smaller magnitude are computed again in double precision.
pub(super) const TINY: f32 = 1e-30;
/// Sums of edge functions of a greater magnitude likewise.
pub(super) const HUGE: f32 = 1e30;

/// Three corners per triangle, by number; those of dropped triangles are never looked at.
#[derive(Debug)]
pub(crate) struct WatertightTriangles {
    pub(crate) corners: Vec<[[f32; 3]; 3]>,
}

/// A ray with its shear: `z` is the axis along which it moves most, `x` and `y` follow it in cyclic order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WatertightRay {
    pub(super) org: [f32; 3],
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) z: usize,
    pub(super) shear: [f32; 3],
}

/// The axis along which a direction is longest; the first of equals.
#[inline(always)]
pub(crate) fn longest_axis(dir: [f32; 3]) -> usize {
    let [x, y, z] = dir.map(f32::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

impl WatertightRay {
    /// `dir` must not be zero.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Self {
        let z = longest_axis(ray.dir);
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let along = ray.dir[z];
        Self { org: ray.org, x, y, z, shear: [ray.dir[x] / along, ray.dir[y] / along, 1.0 / along] }
    }
}

impl WatertightTriangles {
    /// Where `ray` meets triangle `number` in `[t_near, t_far]`.
    #[inline(always)]
    pub(crate) fn meet(&self, number: u32, ray: &WatertightRay, t_near: f32, t_far: f32) -> Option<Meeting> {
        let WatertightRay { org, x, y, z, shear } = *ray;
        let corners = &self.corners[number as usize];
        let relative = |c: usize, k: usize| corners[c][k] - org[k];
        let depth = [relative(0, z), relative(1, z), relative(2, z)];
        let px = [0, 1, 2].map(|c| relative(c, x) - shear[0] * depth[c]);
        let py = [0, 1, 2].map(|c| relative(c, y) - shear[1] * depth[c]);

        let weight = |b: usize, c: usize| px[c] * py[b] - py[c] * px[b];
        let (w0, w1, w2) = (weight(1, 2), weight(2, 0), weight(0, 1));
        if w0.min(w1).min(w2) < 0.0 && w0.max(w1).max(w2) > 0.0 {
            return None;
        }
        let least = w0.abs().min(w1.abs()).min(w2.abs());
        let sum = w0 + w1 + w2;
        if !(least >= TINY && sum.abs() <= HUGE) {
            return meet_exactly(px, py, depth.map(|d| shear[2] * d), t_near, t_far);
        }

        let over = 1.0 / sum;
        let (u, v) = (w1 * over, w2 * over);
        let ts = depth.map(|d| shear[2] * d);
        let t = (w0 * over) * ts[0] + u * ts[1] + v * ts[2];
        let t = t.max(ts[0].min(ts[1]).min(ts[2])).min(ts[0].max(ts[1]).max(ts[2]));
        (t >= t_near && t <= t_far).then_some(Meeting { t, u, v })
    }
}

/// The same decision in double precision, from the sheared corners and their ray parameters. NaN misses.
#[cold]
#[inline(never)]
pub(super) fn meet_exactly(
    px: [f32; 3],
    py: [f32; 3],
    ts: [f32; 3],
    t_near: f32,
    t_far: f32,
) -> Option<Meeting> {
    let (px, py, ts) = (px.map(f64::from), py.map(f64::from), ts.map(f64::from));
    let weight = |b: usize, c: usize| px[c] * py[b] - py[c] * px[b];
    let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
    let one_sided = weights.iter().all(|&w| w >= 0.0) || weights.iter().all(|&w| w <= 0.0);
    let sum: f64 = weights.iter().sum();
    if !one_sided || sum == 0.0 {
        return None;
    }
    let [a, u, v] = weights.map(|w| w / sum);
    let t = a * ts[0] + u * ts[1] + v * ts[2];
    let t = t.max(ts[0].min(ts[1]).min(ts[2])).min(ts[0].max(ts[1]).max(ts[2])) as f32;
    (t >= t_near && t <= t_far).then_some(Meeting { t, u: u as f32, v: v as f32 })
}
