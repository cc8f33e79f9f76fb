// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray against the eight boxes of a node.
//! Source: slabs, [KK86]; the error bound is that of `kd/slab.rs`.
//!
//! A plane `b` is met at `t = b * inv - org * inv`, one fused operation where the CPU has it. What is rounded on the way,
//! here, in the boxes and in the triangle tests, moves points by less than `SLACK * (2 * reach + away)`, where `reach` is
//! the greatest coordinate of the tree and `away` that of the origin: 17 units of 2^-24 for the tests and 5 for boxes
//! (`kd/slab.rs`), 3 for the difference of products, and 5 more where nodes are compact (`compact.rs`). The slack is part
//! of the term that is subtracted: it costs nothing.
//! Invariant: what a triangle test hits is in no box that is skipped. Proof: `tests/watertight.rs`.

use gnurt_simd::{Simd, f32x8, prelude::*};

use super::Boxes;
use crate::Ray;
use crate::kd::{FLATTEST, most};

/// 33 units of 2^-24: see the head.
pub(super) const SLACK: f32 = 2e-6;

/// A ray prepared for nodes.
#[derive(Clone, Copy)]
pub(crate) struct NodeRay<S: Simd> {
    inv: [f32x8<S>; 3],
    /// `org * inv` plus and minus the slack: for nearer and for farther planes.
    near: [f32x8<S>; 3],
    far: [f32x8<S>; 3],
    /// Rows of the nearer planes; the farther ones are next to them.
    rows: [usize; 3],
    t_near: f32x8<S>,
}

impl<S: Simd> NodeRay<S> {
    /// For a tree, not empty, whose greatest coordinate is `reach`; `ray` is sound and regular.
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray, reach: f32) -> Self {
        let at = |value: f32| f32x8::splat(simd, value);
        let flattest = ray.longest() * FLATTEST;
        // No face is farther away than the origin's coordinates and the reach together.
        let away = most(most(ray.org[0].abs(), ray.org[1].abs()), ray.org[2].abs());
        let slack = SLACK * (2.0 * reach + away);
        let zero = at(0.0);
        let mut prepared =
            Self { inv: [zero; 3], near: [zero; 3], far: [zero; 3], rows: [0; 3], t_near: at(ray.t_near) };
        for k in 0..3 {
            let inv = 1.0 / most(ray.dir[k].abs(), flattest).copysign(ray.dir[k]);
            let pad = slack * inv.abs();
            prepared.inv[k] = at(inv);
            prepared.near[k] = at(ray.org[k] * inv + pad);
            prepared.far[k] = at(ray.org[k] * inv - pad);
            prepared.rows[k] = 2 * k + usize::from(ray.dir[k].is_sign_negative());
        }
        prepared
    }

    /// From what a tile has prepared: `inv`, `near` and `far`, rows, near end.
    #[inline(always)]
    pub(super) fn from_parts(
        [inv, near, far]: [[f32x8<S>; 3]; 3],
        rows: [usize; 3],
        t_near: f32x8<S>,
    ) -> Self {
        Self { inv, near, far, rows, t_near }
    }

    /// The boxes that the ray meets before `t_far` as bits, and where it enters them.
    #[inline(always)]
    pub(crate) fn meet<B: Boxes>(&self, simd: S, node: &B, t_far: f32) -> (u32, f32x8<S>) {
        let [x, y, z] = self.rows;
        let near_x = node.meet(simd, 0, x, self.inv[0], self.near[0]);
        let near_y = node.meet(simd, 1, y, self.inv[1], self.near[1]);
        let near_z = node.meet(simd, 2, z, self.inv[2], self.near[2]);
        let far_x = node.meet(simd, 0, x ^ 1, self.inv[0], self.far[0]);
        let far_y = node.meet(simd, 1, y ^ 1, self.inv[1], self.far[1]);
        let far_z = node.meet(simd, 2, z ^ 1, self.inv[2], self.far[2]);
        let near = near_x.max(near_y).max(near_z.max(self.t_near));
        let far = far_x.min(far_y).min(far_z.min(f32x8::splat(simd, t_far)));
        (near.simd_le(far).to_bitmask() as u32, near)
    }
}
