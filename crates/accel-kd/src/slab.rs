// SPDX-License-Identifier: GPL-3.0-or-later
//! A ray against planes and boxes, with intervals wide enough for every rounding on the way.
//! Source: the three cases of [SIP06], Figure 3; the error bound is original.
//!
//! A plane is met at `d = (plane - org) * inv`. All rounding errors move points by less than `slack = SLACK *
//! (greatest + distance)`: the plane's two lowest bits, clipped boxes, `d` itself, corners relative to the
//! origin and their shear in the triangle tests. In units of 2^-24 that is at most 5 for the greatest
//! coordinate of the bounds and 17 for the distance (from the origin to the farthest face). So `d` is used as
//! the interval `[d - slack
//! * |inv|, d + slack * |inv|]`, and no triangle that the test can hit is skipped.
//!
//! A component of the direction that is tiny or zero is replaced by 2^-30 of the longest, with its sign. Over
//! the whole scene that moves a point by far less than the slack, and neither infinity nor `0 * inf` can
//! arise. The sign bit decides which child is nearer, for -0.0 too. Tests: `tests/axis_parallel.rs`,
//! `tests/watertight.rs`.

use gnurt_accel_core::float::{Number, least, most};
use gnurt_accel_core::slab::inverse;
use gnurt_accel_core::{Aabb, Ray};

/// See the head of this file; 25 units of 2^-24.
const SLACK: f32 = 1.5e-6;
/// Half widths of planes' intervals for rays with these inverse directions: see the head of this file.
#[inline(always)]
pub(crate) fn pads<V: Number>(
    org: [V; 3],
    inv: [V; 3],
    bounds: &Aabb,
    greatest: f32,
    at: impl Fn(f32) -> V,
) -> [V; 3] {
    let to = |k: usize| (at(bounds.min[k]) - org[k]).size().or_more((at(bounds.max[k]) - org[k]).size());
    let distance = to(0).or_more(to(1)).or_more(to(2));
    let slack = at(SLACK) * (at(greatest) + distance);
    [slack * inv[0].size(), slack * inv[1].size(), slack * inv[2].size()]
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
    /// For a structure inside `bounds`, not empty, whose greatest coordinate is `greatest`.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, bounds: &Aabb, greatest: f32) -> Self {
        let inv = inverse(ray.dir, |x| x);
        let pads = pads(ray.org, inv, bounds, greatest, |x| x);
        let back = |k: usize| u32::from(ray.dir[k].is_sign_negative());
        let ([ox, oy, oz], [ix, iy, iz], [px, py, pz]) = (ray.org, inv, pads);
        Self {
            org: [ox, oy, oz, 0.0],
            inv: [ix, iy, iz, 1.0],
            slack: [px, py, pz, 0.0],
            back: [back(0), back(1), back(2), 0],
        }
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
