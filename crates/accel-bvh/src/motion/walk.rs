// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray through the triangles of a tree whose boxes move. The arithmetic of `walk.rs` on mixed boxes.
//! Space: object. Tests: `tests/surfaces/motion.rs` of `gnurt-accel`.

use gnurt_accel_core::blocks::{BlockRay, TriangleBlock};
use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::{Counters, KeyInterval, Ray};
use gnurt_simd::{Simd, prelude::*};

use super::MotionIndex;
use crate::interpolated::{InterpolatedNodes, mixed};
use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::walk::{walk, walk_any};

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
    /// Offers the hits of `ray` at its time; it is valid and regular.
    #[inline(always)]
    pub(crate) fn search<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let interval = KeyInterval::of(ray.time, self.keys.len());
        let (from, to, weights) = (&self.keys[interval.key], &self.keys[interval.next], interval.weights);
        let nodes = InterpolatedNodes { from: &from.tree.nodes, to: &to.tree.nodes, weights };
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
