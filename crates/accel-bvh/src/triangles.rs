// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray through the triangles of a wide BVH. Traversals of fast trees, whose nodes and blocks are stored
//! in the form of the tests, are compiled for each kind of query; those of compact ones once.
//! Space: object. Tests: `tests/brute_force.rs` of `gnurt-accel`.

use gnurt_accel_core::blocks::{BlockRay, TriangleBlock};
use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::{Counters, Ray};
use gnurt_simd::Simd;

use crate::index::BvhIndex;
use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::walk::{walk, walk_any};

/// A ray prepared for nodes and for blocks.
pub(crate) struct Prepared<S: Simd> {
    pub(crate) for_nodes: NodeRay<S>,
    pub(crate) for_blocks: BlockRay<S>,
}

impl<S: Simd> Prepared<S> {
    /// `ray` is valid and regular.
    #[inline(always)]
    fn new(simd: S, ray: &Ray, greatest: f32) -> Self {
        Self { for_nodes: NodeRay::new(simd, ray, greatest), for_blocks: BlockRay::new(simd, ray) }
    }
}

impl BvhIndex {
    /// Offers the hits of `ray`; it is valid and regular, the tree fast and not empty.
    #[inline(always)]
    pub(crate) fn search<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let ray = Prepared::new(simd, ray, self.greatest);
        self.walk(simd, Child::node(0), &ray, slot, collect, counters);
    }

    /// The same in a compact tree.
    #[inline(always)]
    pub(crate) fn search_compact<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        let ray = Prepared::new(simd, traversal.ray, self.greatest);
        self.walk_compact(simd, Child::node(0), &ray, traversal);
    }

    /// From `start` on, in a fast tree.
    #[inline(always)]
    pub(crate) fn walk<S: Simd, C: Collect>(
        &self,
        simd: S,
        start: Child,
        Prepared { for_nodes, for_blocks }: &Prepared<S>,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let (nodes, blocks) = (&self.tree.nodes[..], &self.leaves.blocks[..]);
        let mut tested = 0;
        let visited = if C::ANY {
            walk_any(
                nodes,
                simd,
                start,
                for_nodes,
                collect.reach(),
                #[inline(always)]
                |range| {
                    for index in range {
                        tested += 1;
                        blocks[index].meet(simd, for_blocks, slot, collect);
                        if collect.is_done() {
                            return false;
                        }
                    }
                    true
                },
            )
        } else {
            walk(
                nodes,
                simd,
                start,
                for_nodes,
                collect.reach(),
                #[inline(always)]
                |range| {
                    for index in range {
                        tested += 1;
                        blocks[index].meet(simd, for_blocks, slot, collect);
                    }
                    collect.reach()
                },
            )
        };
        counters.nodes += u64::from(visited);
        counters.triangles += tested * WIDTH as u64;
    }

    /// The same in a compact tree, whose blocks are expanded one by one.
    #[inline(never)]
    pub(crate) fn walk_compact<S: Simd>(
        &self,
        simd: S,
        start: Child,
        Prepared { for_nodes, for_blocks }: &Prepared<S>,
        traversal: &mut RayTraversal,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let (slot, mut tested, mut block) = (traversal.slot, 0, TriangleBlock::ZERO);
                let visited = walk(
                    &self.tree.compact_nodes(),
                    simd,
                    start,
                    for_nodes,
                    traversal.reach(),
                    #[inline(always)]
                    |range| {
                        for index in range {
                            tested += 1;
                            self.leaves.expand(simd, index, &mut block);
                            block.meet(simd, for_blocks, slot, traversal);
                            if traversal.is_done() {
                                break;
                            }
                        }
                        traversal.reach()
                    },
                );
                traversal.counters.nodes += u64::from(visited);
                traversal.counters.triangles += tested * WIDTH as u64;
            },
        );
    }
}
