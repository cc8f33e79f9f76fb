// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray through the triangles of a tree whose boxes move. Source: original; the arithmetic of `walk.rs` on mixed boxes.
//! Space: object. Proof: `tests/surfaces/motion.rs` of `gnurt-accel`.

use gnurt_accel_core::blocks::{BlockRay, TriangleBlock};
use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::{Counters, Moment, Ray};
use gnurt_simd::{Simd, f32x8, prelude::*};

use super::MotionIndex;
use crate::node::{Boxes, Child, Node8, WIDTH};
use crate::node_ray::NodeRay;
use crate::walk::{Nodes, walk, walk_any};

/// The nodes between two keys.
struct Between<'a> {
    from: &'a [Node8],
    to: &'a [Node8],
    weights: [f32; 2],
}

/// Eight boxes at two keys.
struct Pair<'a> {
    from: &'a Node8,
    to: &'a Node8,
    weights: [f32; 2],
}

/// Two rows mixed: two products and a sum, as `Moment::mix`.
#[inline(always)]
fn mixed<S: Simd>(simd: S, [a, b]: [f32; 2], from: &[f32], to: &[f32]) -> f32x8<S> {
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
        // The weights go into the slopes, which do not change on the ray's way: what is rounded otherwise than in a mixed box is
        // within the slack that slabs have for compact nodes.
        let at = at & (WIDTH * (WIDTH - 1));
        let [a, b] = self.weights;
        let from = f32x8::from_slice(simd, &self.from.rows.as_flattened()[at..at + WIDTH]);
        let to = f32x8::from_slice(simd, &self.to.rows.as_flattened()[at..at + WIDTH]);
        let rest = to.mul_sub(inv * f32x8::splat(simd, b), shift);
        from.mul_add(inv * f32x8::splat(simd, a), rest)
    }
}

impl Nodes for Between<'_> {
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

/// A block between two keys.
#[inline(always)]
fn mix_block<S: Simd>(
    simd: S,
    weights: [f32; 2],
    from: &TriangleBlock,
    to: &TriangleBlock,
    block: &mut TriangleBlock,
) {
    block.numbers = from.numbers;
    for corner in 0..3 {
        for axis in 0..3 {
            let row = mixed(simd, weights, &from.corners[corner][axis], &to.corners[corner][axis]);
            row.store_slice(&mut block.corners[corner][axis]);
        }
    }
}

impl MotionIndex {
    /// Offers what `ray` meets at its moment; it is sound and regular.
    #[inline(always)]
    pub(crate) fn search<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let moment = Moment::of(ray.time, self.keys.len());
        let (from, to, weights) = (&self.keys[moment.key], &self.keys[moment.next], moment.weights);
        let nodes = Between { from: &from.tree.nodes, to: &to.tree.nodes, weights };
        let (blocks, blocks_to) = (&from.leaves.blocks[..], &to.leaves.blocks[..]);
        let for_nodes = NodeRay::new(simd, ray, self.greatest);
        let for_blocks = BlockRay::new(simd, ray);
        let (start, reach) = (Child::node(0), collect.reach());
        let (mut tested, mut block) = (0, TriangleBlock::ZERO);
        let visited = if C::ANY {
            walk_any(
                &nodes,
                simd,
                start,
                &for_nodes,
                reach,
                #[inline(always)]
                |range| {
                    for index in range {
                        tested += 1;
                        mix_block(simd, weights, &blocks[index], &blocks_to[index], &mut block);
                        block.meet(simd, &for_blocks, slot, collect);
                        if collect.is_done() {
                            return false;
                        }
                    }
                    true
                },
            )
        } else {
            walk(
                &nodes,
                simd,
                start,
                &for_nodes,
                reach,
                #[inline(always)]
                |range| {
                    for index in range {
                        tested += 1;
                        mix_block(simd, weights, &blocks[index], &blocks_to[index], &mut block);
                        block.meet(simd, &for_blocks, slot, collect);
                    }
                    collect.reach()
                },
            )
        };
        counters.nodes += u64::from(visited);
        counters.triangles += tested * WIDTH as u64;
    }
}
