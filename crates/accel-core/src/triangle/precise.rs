// SPDX-License-Identifier: GPL-3.0-or-later
//! The exact intersection of a ray with a triangle that it passes inside of, from unrounded input: in double
//! precision, or in exact arithmetic where that is insufficient. An example is a sliver a ten-millionth as
//! wide as it is long, seen edge on from close by.
//! Source: [WBW13] without the division: sheared positions times the ray's longest component; [She97] for the plan.
//! Space: along the axes of the sheared space. Invariant: the relative error of `t` is at most 2^-21. A ray
//! that passes the float test although it misses the triangle hits it at its edge: weights of the wrong sign
//! become zero. Sixteen lanes give the same bits. Tests: `tests`, `tests/parameters.rs` of `gnurt-accel`.

use gnurt_simd::{Simd, f32x16, f64x8, prelude::*};

use crate::exact::ExactHit;

/// A triangle and a ray before anything is rounded, along the axes of the sheared space.
pub(super) struct Corners {
    pub(super) corners: [[f32; 3]; 3],
    pub(super) org: [f32; 3],
    pub(super) dir: [f32; 3],
}

/// Ray parameter, and weights of the second and the third corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Weighed {
    pub(super) t: f64,
    pub(super) u: f64,
    pub(super) v: f64,
}

/// As `DOUBTFUL` of `watertight.rs`, for doubles and 2^-21, with twice the margin.
const DOUBTFUL: f64 = (1u64 << 29) as f64;

/// `None` where the ray is in the triangle's plane.
pub(super) fn meet(triangle: &Corners) -> Option<Weighed> {
    in_doubles(triangle).or_else(|| {
        let Corners { corners, org, dir } = triangle;
        let ExactHit { t, u, v } = ExactHit::of(corners, org, dir)?;
        Some(Weighed { t, u, v })
    })
}

/// `None` where doubles are not sure.
fn in_doubles(Corners { corners, org, dir }: &Corners) -> Option<Weighed> {
    let [dx, dy, dz] = dir.map(f64::from);
    let from = corners.map(|corner| [0, 1, 2].map(|k| f64::from(corner[k]) - f64::from(org[k])));
    let px = from.map(|p| p[0] * dz - p[2] * dx);
    let py = from.map(|p| p[1] * dz - p[2] * dy);
    let weight = |b: usize, c: usize| px[c] * py[b] - py[c] * px[b];
    let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
    let sum: f64 = weights.iter().sum();
    let side = if sum < 0.0 { -1.0 } else { 1.0 };
    let weights = weights.map(|w| (side * w).max(0.0));
    let whole: f64 = weights.iter().sum();
    let depth = [from[0][2], from[1][2], from[2][2]];
    let t = weights.iter().zip(&depth).map(|(w, z)| w * z).sum::<f64>() / (whole * dz);

    let wide = px.iter().chain(&py).fold(0.0f64, |most, x| most.max(x.abs()));
    let (near, far) = (
        depth.iter().copied().fold(f64::INFINITY, f64::min),
        depth.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    );
    let doubt = (far - near) * wide * (wide + near.abs().max(far.abs()) * dz.abs());
    // Not so of NaN.
    let sure = doubt < DOUBTFUL * (t * dz * sum).abs();
    sure.then(|| Weighed { t, u: weights[1] / whole, v: weights[2] / whole })
}

/// [`in_doubles`] of sixteen rays and one triangle: `t` and the weights, and by bits the lanes that are sure.
#[inline(always)]
pub(super) fn in_double_lanes<S: Simd>(
    simd: S,
    corners: &[[f32; 3]; 3],
    org: &[f32x16<S>; 3],
    dir: &[f32x16<S>; 3],
) -> ([f32x16<S>; 3], u64) {
    let [ox, oy, oz] = [simd.widen_f32x16(org[0]), simd.widen_f32x16(org[1]), simd.widen_f32x16(org[2])];
    let [dx, dy, dz] = [simd.widen_f32x16(dir[0]), simd.widen_f32x16(dir[1]), simd.widen_f32x16(dir[2])];
    let (low, sure_low) = eight(simd, corners, [ox.0, oy.0, oz.0], [dx.0, dy.0, dz.0]);
    let (high, sure_high) = eight(simd, corners, [ox.1, oy.1, oz.1], [dx.1, dy.1, dz.1]);
    let met = [
        simd.narrow_f64x8(low[0], high[0]),
        simd.narrow_f64x8(low[1], high[1]),
        simd.narrow_f64x8(low[2], high[2]),
    ];
    (met, sure_low | sure_high << 8)
}

/// [`in_double_lanes`] of eight rays: the roundings of [`in_doubles`] in its order.
#[inline(always)]
fn eight<S: Simd>(
    simd: S,
    corners: &[[f32; 3]; 3],
    org: [f64x8<S>; 3],
    dir: [f64x8<S>; 3],
) -> ([f64x8<S>; 3], u64) {
    let zero = f64x8::splat(simd, 0.0);
    let ([mut px, mut py, mut depth], [dx, dy, dz]) = ([[zero; 3]; 3], dir);
    for (k, corner) in corners.iter().enumerate() {
        let x = f64x8::splat(simd, f64::from(corner[0])) - org[0];
        let y = f64x8::splat(simd, f64::from(corner[1])) - org[1];
        depth[k] = f64x8::splat(simd, f64::from(corner[2])) - org[2];
        px[k] = x * dz - depth[k] * dx;
        py[k] = y * dz - depth[k] * dy;
    }
    let w = [px[2] * py[1] - py[2] * px[1], px[0] * py[2] - py[0] * px[2], px[1] * py[0] - py[1] * px[0]];
    let sum = w[0] + w[1] + w[2];
    let side = sum.simd_lt(zero).select(f64x8::splat(simd, -1.0), f64x8::splat(simd, 1.0));
    let w = [(side * w[0]).max(zero), (side * w[1]).max(zero), (side * w[2]).max(zero)];
    let whole = w[0] + w[1] + w[2];
    let t = (w[0] * depth[0] + w[1] * depth[1] + w[2] * depth[2]) / (whole * dz);

    let wide_x = px[0].abs().max(px[1].abs()).max(px[2].abs());
    let wide_y = py[0].abs().max(py[1].abs()).max(py[2].abs());
    let wide = wide_x.max(wide_y);
    let near = depth[0].min(depth[1]).min(depth[2]);
    let far = depth[0].max(depth[1]).max(depth[2]);
    let doubt = (far - near) * wide * (wide + near.abs().max(far.abs()) * dz.abs());
    let sure = doubt.simd_lt(f64x8::splat(simd, DOUBTFUL) * (t * dz * sum).abs());
    ([t, w[1] / whole, w[2] / whole], sure.to_bitmask())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slivers from 1 down to 2^-40 as wide as they are long, seen from as near.
    fn sliver(random: &mut gnurt_testkit::Random, round: i32) -> Corners {
        let (thin, near) = (0.5f32.powi(round % 41), 0.5f32.powi(round / 41 % 21));
        let p = random.point();
        let mut beside = |by: f32| {
            let q = random.point();
            [0, 1, 2].map(|k| p[k] + by * q[k])
        };
        let (a, b) = (beside(1.0), beside(thin));
        let corners = [p, a, b];
        let org = beside(near);
        let dir = [0, 1, 2].map(|k| (p[k] + a[k] + b[k]) / 3.0 - org[k]);
        let z = (0..3).max_by(|&i, &j| dir[i].abs().total_cmp(&dir[j].abs())).expect("three");
        let along = |p: [f32; 3]| [p[(z + 1) % 3], p[(z + 2) % 3], p[z]];
        Corners { corners: corners.map(along), org: along(org), dir: along(dir) }
    }

    #[inline(always)]
    fn ask<S: Simd>(simd: S, triangle: &Corners, rays: &[[[f32; 16]; 3]; 2]) -> ([[f32; 16]; 3], u64) {
        let [org, dir] = rays;
        let row = |x: &[f32; 16]| f32x16::from_slice(simd, x);
        let (org, dir) =
            ([row(&org[0]), row(&org[1]), row(&org[2])], [row(&dir[0]), row(&dir[1]), row(&dir[2])]);
        let ([t, u, v], sure) = in_double_lanes(simd, &triangle.corners, &org, &dir);
        let mut met = [[0.0; 16]; 3];
        t.store_slice(&mut met[0]);
        u.store_slice(&mut met[1]);
        v.store_slice(&mut met[2]);
        (met, sure)
    }

    #[test]
    fn lanes_do_the_same() {
        let mut random = gnurt_testkit::Random::new(4);
        let (mut sure_ones, mut unsure) = (0, 0);
        for round in 0..900 {
            let triangle = sliver(&mut random, round);
            // The same triangle from sixteen origins along the ray.
            let org: [[f32; 16]; 3] = std::array::from_fn(|k| {
                std::array::from_fn(|i| triangle.org[k] + triangle.dir[k] * i as f32 / 17.0)
            });
            let rays = [org, triangle.dir.map(|x| [x; 16])];
            for level in gnurt_simd::Level::available() {
                let asked =
                    gnurt_simd::dispatch_wide!(level, simd => Some(ask(simd, &triangle, &rays)), else None);
                let Some((met, sure)) = asked else { continue };
                for (i, alone) in (0..16).map(|i| {
                    let org = org.map(|row| row[i]);
                    (i, in_doubles(&Corners { org, ..triangle }))
                }) {
                    assert_eq!(alone.is_some(), sure >> i & 1 == 1, "whether it is sure, at {level}");
                    if let Some(Weighed { t, u, v }) = alone {
                        let lane = [met[0][i], met[1][i], met[2][i]];
                        assert_eq!([t as f32, u as f32, v as f32], lane, "at {level}");
                    }
                    sure_ones += usize::from(alone.is_some());
                    unsure += usize::from(alone.is_none());
                }
            }
        }
        assert!(sure_ones == 0 || sure_ones > 5_000 && unsure > 100, "{sure_ones} sure, {unsure} not");
    }

    #[test]
    fn doubles_are_exact_or_say_that_they_are_not() {
        let mut random = gnurt_testkit::Random::new(3);
        let (mut sure, mut unsure) = (0, 0);
        for round in 0..20_000 {
            let triangle = sliver(&mut random, round);
            let exact = ExactHit::of(&triangle.corners, &triangle.org, &triangle.dir);
            let (Some(found), Some(exact)) = (in_doubles(&triangle), exact) else {
                unsure += 1;
                continue;
            };
            sure += 1;
            let off = (found.t - exact.t).abs();
            assert!(off <= 5e-7 * exact.t.abs(), "{} is {} in truth", found.t, exact.t);
        }
        assert!(sure > 10_000 && unsure > 100, "{sure} sure and {unsure} unsure cases are enough to tell");
    }
}
