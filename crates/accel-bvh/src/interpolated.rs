// SPDX-License-Identifier: GPL-3.0-or-later
//! Nodes between two keys, whose boxes are mixed as a ray comes to them: of triangles that move, and of instances that do.
//! Boxes that are mixed, not unions, are those of Embree's `AABBNodeMB`.
//! Invariant: a mixed box is met where the box with mixed planes is, up to the slack of slabs.
//! Tests: `tests/surfaces/motion.rs` of `gnurt-accel`.

use gnurt_accel_core::Aabb;
use gnurt_simd::{Simd, f32x8, prelude::*};

use crate::node::{Boxes, Child, Node8, WIDTH};
use crate::node_ray::NodeRay;
use crate::walk::Nodes;

/// A box that no ray meets, mixed with itself or not.
const NOWHERE: Aabb = Aabb { min: [f32::MAX; 3], max: [-f32::MAX; 3] };

/// Gives children that do not exist a box that can be mixed.
pub(crate) fn hide_nothing(nodes: &mut [Node8]) {
    put_nothing(nodes, &NOWHERE);
}

/// Restores the box of absent children of a static tree.
pub(crate) fn empty_nothing(nodes: &mut [Node8]) {
    put_nothing(nodes, &Aabb::EMPTY);
}

fn put_nothing(nodes: &mut [Node8], bounds: &Aabb) {
    for node in nodes {
        for lane in 0..WIDTH {
            if node.child(lane) == Child::NONE {
                node.set(lane, bounds, Child::NONE);
            }
        }
    }
}

/// The nodes between two keys.
pub(crate) struct InterpolatedNodes<'a> {
    pub(crate) from: &'a [Node8],
    pub(crate) to: &'a [Node8],
    /// As of [`KeyInterval`](gnurt_accel_core::KeyInterval).
    pub(crate) weights: [f32; 2],
}

/// Eight boxes at two keys.
struct Pair<'a> {
    from: &'a Node8,
    to: &'a Node8,
    weights: [f32; 2],
}

/// Two rows mixed: two products and a sum, as `KeyInterval::mix`.
#[inline(always)]
pub(crate) fn mixed<S: Simd>(simd: S, [a, b]: [f32; 2], from: &[f32], to: &[f32]) -> f32x8<S> {
    let (from, to) = (f32x8::from_slice(simd, from), f32x8::from_slice(simd, to));
    f32x8::splat(simd, a) * from + f32x8::splat(simd, b) * to
}

impl Boxes for Pair<'_> {
    #[inline(always)]
    fn row<S: Simd>(&self, simd: S, _: usize, row: usize) -> f32x8<S> {
        let row = row & (WIDTH - 1);
        mixed(simd, self.weights, &self.from.rows[row], &self.to.rows[row])
    }

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, _: usize, at: usize, inv: f32x8<S>, shift: f32x8<S>) -> f32x8<S> {
        // The weights go into the slopes, which are constant for the ray: the different rounding from that of
        // an interpolated box is within the slack of slabs for compact nodes.
        let at = at & (WIDTH * (WIDTH - 1));
        let [a, b] = self.weights;
        let from = f32x8::from_slice(simd, &self.from.rows.as_flattened()[at..at + WIDTH]);
        let to = f32x8::from_slice(simd, &self.to.rows.as_flattened()[at..at + WIDTH]);
        let rest = to.mul_sub(inv * f32x8::splat(simd, b), shift);
        from.mul_add(inv * f32x8::splat(simd, a), rest)
    }
}

impl Nodes for InterpolatedNodes<'_> {
    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        index: usize,
        ray: &NodeRay<S>,
        reach: f32,
    ) -> (u32, f32x8<S>, &[f32; WIDTH]) {
        let (from, to) = (&self.from[index], &self.to[index]);
        let (bits, near) = ray.meet(simd, &Pair { from, to, weights: self.weights }, reach);
        (bits, near, from.children())
    }
}
