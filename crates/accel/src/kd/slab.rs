// SPDX-License-Identifier: GPL-3.0-or-later
//! A ray against planes and boxes, with intervals wide enough for every rounding on the way.
//! Source: the three cases of the paper's Figure 3; the error bound is original.
//!
//! A plane is met at `d = (plane - org) * inv`. All that is rounded - the plane's two lowest bits, clipped boxes, `d`
//! itself, corners relative to the origin and their shear in the triangle tests - moves points by less than
//! `slack = SLACK * (reach + distance)`: in units of 2^-24 at most 5 for the reach (greatest coordinate of the bounds)
//! and 17 for the distance (from the origin to the farthest face). So `d` is used as the interval
//! `[d - slack * |inv|, d + slack * |inv|]`, and what a test can hit is never skipped.
//!
//! A component of the direction that is tiny or zero is taken to be 2^-30 of the longest, with its sign: over the
//! whole scene that moves a point by far less than the slack, and no infinity and no `0 * inf` can arise. The sign bit
//! decides which child is nearer, for -0.0 too. Proof: `tests/axis_parallel.rs`, `tests/watertight.rs`.

use crate::{Aabb, Ray};

/// See the head of this file; 25 units of 2^-24.
pub(crate) const SLACK: f32 = 1.5e-6;
/// Components of a direction are at least this much of the longest.
pub(crate) const FLATTEST: f32 = 1.0 / (1 << 30) as f32;

/// The lesser of two numbers, neither of them NaN: one instruction, unlike `f32::min`.
#[inline(always)]
pub(crate) fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater of two numbers, neither of them NaN.
#[inline(always)]
pub(crate) fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// A ray prepared for planes. Arrays have four entries so that a node's two axis bits need no check.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RaySlabs {
    pub(super) org: [f32; 4],
    pub(super) inv: [f32; 4],
    /// Half width of a plane's interval.
    pub(super) slack: [f32; 4],
    /// 1 where the ray goes towards smaller coordinates and meets the right child first.
    pub(super) back: [u32; 4],
}

impl RaySlabs {
    /// For a structure inside `bounds`, not empty, whose greatest coordinate is `reach`.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, bounds: &Aabb, reach: f32) -> Self {
        let longest = ray.dir[0].abs().max(ray.dir[1].abs()).max(ray.dir[2].abs());
        let mut distance = 0.0f32;
        let mut slabs = Self { org: [0.0; 4], inv: [1.0; 4], slack: [0.0; 4], back: [0; 4] };
        for k in 0..3 {
            let away = ray.dir[k].abs().max(longest * FLATTEST).copysign(ray.dir[k]);
            slabs.org[k] = ray.org[k];
            slabs.inv[k] = 1.0 / away;
            slabs.back[k] = u32::from(ray.dir[k].is_sign_negative());
            distance =
                distance.max((bounds.min[k] - ray.org[k]).abs()).max((bounds.max[k] - ray.org[k]).abs());
        }
        let slack = SLACK * (reach + distance);
        for k in 0..3 {
            slabs.slack[k] = slack * slabs.inv[k].abs();
        }
        slabs
    }

    /// The part of `[t_min, t_max]` inside a box, or `None`.
    #[inline(always)]
    pub(crate) fn clip(&self, bounds: &Aabb, t_min: f32, t_max: f32) -> Option<[f32; 2]> {
        let (mut t_min, mut t_max) = (t_min, t_max);
        for k in 0..3 {
            let a = (bounds.min[k] - self.org[k]) * self.inv[k];
            let b = (bounds.max[k] - self.org[k]) * self.inv[k];
            t_min = most(t_min, least(a, b) - self.slack[k]);
            t_max = least(t_max, most(a, b) + self.slack[k]);
        }
        (t_min <= t_max).then_some([t_min, t_max])
    }
}
