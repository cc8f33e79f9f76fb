// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray against the eight boxes of a node.
//! Source: slabs, [KK86]; `slab.rs` of `gnurt-accel-core` prepares rays and bounds the rounding.
//! Invariant: a primitive that the triangle test hits is in no skipped box. Tests: `tests/watertight.rs` of
//! `gnurt-accel`.

use gnurt_accel_core::Ray;
use gnurt_accel_core::float::{FLATTEST, least, most};
use gnurt_accel_core::slab::{SLACK, Slabs};
use gnurt_simd::{Simd, f32x4, f32x8, i32x4, prelude::*};

use crate::node::{Boxes, WIDTH};

/// A ray prepared for nodes.
#[derive(Clone, Copy)]
pub(crate) struct NodeRay<S: Simd> {
    inv: [f32x8<S>; 3],
    /// `org * inv` plus and minus the slack: for nearer and for farther planes.
    near: [f32x8<S>; 3],
    far: [f32x8<S>; 3],
    /// The first floats of the rows of nearer and of farther planes.
    near_at: [usize; 3],
    far_at: [usize; 3],
    t_near: f32x8<S>,
}

/// A ray with its axes in lanes.
#[derive(Clone, Copy)]
pub(crate) struct RayLanes<S: Simd> {
    /// In the fourth lane `t_near`.
    org: f32x4<S>,
    /// In the fourth lane any number.
    dir: f32x4<S>,
    /// Both without their signs.
    away: f32x4<S>,
    size: f32x4<S>,
}

impl<S: Simd> RayLanes<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray) -> Self {
        // In the order of the fields in memory, and not from copies of arrays: one load each.
        let org = f32x4::load_array(simd, [ray.org[0], ray.org[1], ray.org[2], ray.t_near]);
        let dir = f32x4::load_array(simd, [ray.dir[0], ray.dir[1], ray.dir[2], ray.time]);
        Self { org, dir, away: org.abs(), size: dir.abs() }
    }

    /// Whether the ray is valid and of regular length.
    #[inline(always)]
    pub(crate) fn is_regular(&self, simd: S, ray: &Ray) -> bool {
        let near = self.away.simd_le(f32x4::splat(simd, Ray::FARTHEST_ORIGIN));
        let short = self.size.simd_le(f32x4::splat(simd, Ray::LONGEST));
        let long = self.size.simd_ge(f32x4::splat(simd, Ray::SHORTEST));
        // Not so of NaN.
        (near & short).to_bitmask() & 7 == 7 && long.to_bitmask() & 7 != 0 && self.org[3] <= ray.t_far
    }

    /// The axis along which it moves most. From the lanes: where floats of the ray are used one by one, too, they are not loaded
    /// together.
    #[inline(always)]
    pub(crate) fn longest_axis(&self) -> usize {
        Ray::longest_of([self.size[0], self.size[1], self.size[2]])
    }
}

/// The greatest of the first three lanes.
#[inline(always)]
fn longest<S: Simd>(lanes: f32x4<S>) -> f32 {
    most(most(lanes[0], lanes[1]), lanes[2])
}

/// The least of them.
#[inline(always)]
fn shortest<S: Simd>(lanes: f32x4<S>) -> f32 {
    least(least(lanes[0], lanes[1]), lanes[2])
}

impl<S: Simd> NodeRay<S> {
    /// For a tree, not empty, whose greatest coordinate is `greatest`; `ray` is valid and regular.
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray, greatest: f32) -> Self {
        Self::of_lanes(simd, &RayLanes::new(simd, ray), greatest)
    }

    /// The arithmetic of [`Slabs::new`] with the axes in lanes.
    #[inline(always)]
    pub(crate) fn of_lanes(simd: S, ray: &RayLanes<S>, greatest: f32) -> Self {
        let splat = |x: f32| f32x4::splat(simd, x);
        let RayLanes { org, dir, away, size } = *ray;
        // Almost no direction is flat, which the CPU foresees: so the division waits for no comparison.
        let mut inv = splat(1.0) / dir;
        let flattest = longest(size) * FLATTEST;
        if shortest(size) < flattest {
            inv = splat(1.0) / size.max(splat(flattest)).copysign(dir);
        }
        let slack = splat(SLACK * (2.0 * greatest + longest(away)));
        let (met, pad) = (org * inv, slack * inv.abs());
        // Negated in four lanes instead of twice eight: `mul_sub` negates them again.
        let (near, far) = (-(met + pad), pad - met);
        let all = |lanes: f32x4<S>| {
            let at = |k: usize| f32x8::splat(simd, lanes[k]);
            [at(0), at(1), at(2)]
        };
        let ([near_x, near_y, near_z], [far_x, far_y, far_z]) = (all(near), all(far));
        let backwards = dir.bitcast::<i32x4<S>>().simd_lt(i32x4::splat(simd, 0)).to_bitmask() as usize;
        let row = |k: usize| WIDTH * 2 * k + (backwards >> k & 1) * WIDTH;
        let near_at = [row(0), row(1), row(2)];
        Self {
            inv: all(inv),
            near: [-near_x, -near_y, -near_z],
            far: [-far_x, -far_y, -far_z],
            near_at,
            far_at: [near_at[0] ^ WIDTH, near_at[1] ^ WIDTH, near_at[2] ^ WIDTH],
            t_near: f32x8::splat(simd, org[3]),
        }
    }

    /// From slabs that are prepared, rows and near end.
    #[inline(always)]
    pub(crate) fn of_slabs(simd: S, slabs: &Slabs<f32>, rows: [usize; 3], t_near: f32) -> Self {
        let at = |[x, y, z]: [f32; 3]| [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)];
        let Slabs { inv, near, far } = *slabs;
        let [x, y, z] = rows;
        Self {
            inv: at(inv),
            near: at(near),
            far: at(far),
            near_at: [WIDTH * x, WIDTH * y, WIDTH * z],
            far_at: [WIDTH * (x ^ 1), WIDTH * (y ^ 1), WIDTH * (z ^ 1)],
            t_near: f32x8::splat(simd, t_near),
        }
    }

    /// The boxes that the ray meets before `t_far` as bits, and where it enters them.
    #[inline(always)]
    pub(crate) fn meet<B: Boxes>(&self, simd: S, node: &B, t_far: f32) -> (u32, f32x8<S>) {
        let ([x, y, z], [far_x, far_y, far_z]) = (self.near_at, self.far_at);
        let near_x = node.meet(simd, 0, x, self.inv[0], self.near[0]);
        let near_y = node.meet(simd, 1, y, self.inv[1], self.near[1]);
        let near_z = node.meet(simd, 2, z, self.inv[2], self.near[2]);
        let far_x = node.meet(simd, 0, far_x, self.inv[0], self.far[0]);
        let far_y = node.meet(simd, 1, far_y, self.inv[1], self.far[1]);
        let far_z = node.meet(simd, 2, far_z, self.inv[2], self.far[2]);
        let near = near_x.max(near_y).max(near_z.max(self.t_near));
        let far = far_x.min(far_y).min(far_z.min(f32x8::splat(simd, t_far)));
        (near.simd_le(far).to_bitmask() as u32, near)
    }
}
