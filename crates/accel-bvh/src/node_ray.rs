// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray against the eight boxes of a node.
//! Source: slabs, [KK86]; `slab.rs` of `gnurt-accel-core` prepares rays and bounds the rounding.
//! Invariant: a primitive that the triangle test hits is in no skipped box. Tests: `tests/watertight.rs` of
//! `gnurt-accel`.

use gnurt_accel_core::Ray;
use gnurt_accel_core::slab::Slabs;
use gnurt_simd::{Simd, f32x8, prelude::*};

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

impl<S: Simd> NodeRay<S> {
    /// For a tree, not empty, whose greatest coordinate is `greatest`; `ray` is valid and regular.
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray, greatest: f32) -> Self {
        let slabs = Slabs::new(ray.org, ray.dir, greatest, |x| x);
        let row = |k: usize| 2 * k + usize::from(ray.dir[k].is_sign_negative());
        Self::of_slabs(simd, &slabs, [row(0), row(1), row(2)], ray.t_near)
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
