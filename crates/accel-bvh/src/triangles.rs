// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray through the triangles of a wide BVH. Traversals of fast trees, whose nodes and blocks are stored
//! in the form of the tests, are compiled for each kind of query; those of compact ones once.
//! Space: object. Tests: `tests/brute_force.rs` of `gnurt-accel`.

use std::ops::Range;

use gnurt_accel_core::blocks::{BlockRay, TriangleBlock};
use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::{Counters, Ray};
use gnurt_simd::{Simd, StackBuffer};

use crate::index::BvhIndex;
use crate::node::{Child, WIDTH};
use crate::node_ray::{NodeRay, RayLanes};
use crate::walk::{MOST_WAIT, NodeStack, enter, enter_any, walk, walk_any, walk_any_on, walk_on};

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

    /// The same of any ray; whether it is valid and regular. If not, nothing is done.
    #[inline(always)]
    pub(crate) fn search_regular<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) -> bool {
        let lanes = RayLanes::new(simd, ray);
        let is_regular = lanes.is_regular(simd, ray);
        if is_regular {
            self.search_late(simd, ray, &lanes, slot, collect, counters);
        }
        is_regular
    }

    /// The same in a compact tree.
    #[inline(always)]
    pub(crate) fn search_compact<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        let ray = Prepared::new(simd, traversal.ray, self.greatest);
        self.walk_compact(simd, Child::node(0), &ray, traversal);
    }

    /// From the root of a fast tree on; the ray is made ready for triangles once it has met the root.
    #[inline(always)]
    fn search_late<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        lanes: &RayLanes<S>,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let (nodes, reach) = (&self.tree.nodes[..], collect.reach());
        let for_nodes = &NodeRay::of_lanes(simd, lanes, self.greatest);
        counters.nodes += 1;
        let mut tested = 0;
        let visited = if C::ANY {
            let mut buffer = StackBuffer::<u32, MOST_WAIT>::new();
            let waiting = &mut buffer.stack();
            let Some(first) = enter_any(waiting, nodes, simd, for_nodes, reach) else { return };
            let for_blocks = BlockRay::along(simd, ray, lanes.longest_axis());
            walk_any_on(
                waiting,
                nodes,
                simd,
                first,
                for_nodes,
                reach,
                #[inline(always)]
                |range| self.leaf_any(simd, range, &for_blocks, slot, collect, &mut tested),
            )
        } else {
            let mut buffer = NodeStack::new();
            let waiting = &mut buffer.stack();
            let Some(first) = enter(waiting, nodes, simd, for_nodes, reach) else { return };
            let for_blocks = BlockRay::along(simd, ray, lanes.longest_axis());
            walk_on(
                waiting,
                nodes,
                simd,
                first,
                for_nodes,
                reach,
                #[inline(always)]
                |range| self.leaf(simd, range, &for_blocks, slot, collect, &mut tested),
            )
        };
        counters.nodes += u64::from(visited);
        counters.triangles += tested * WIDTH as u64;
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
        let (nodes, reach) = (&self.tree.nodes[..], collect.reach());
        let mut tested = 0;
        let visited = if C::ANY {
            walk_any(
                nodes,
                simd,
                start,
                for_nodes,
                reach,
                #[inline(always)]
                |range| self.leaf_any(simd, range, for_blocks, slot, collect, &mut tested),
            )
        } else {
            walk(
                nodes,
                simd,
                start,
                for_nodes,
                reach,
                #[inline(always)]
                |range| self.leaf(simd, range, for_blocks, slot, collect, &mut tested),
            )
        };
        counters.nodes += u64::from(visited);
        counters.triangles += tested * WIDTH as u64;
    }

    /// Offers the hits in a leaf; how far the ray is still of interest.
    #[inline(always)]
    fn leaf<S: Simd, C: Collect>(
        &self,
        simd: S,
        range: Range<usize>,
        for_blocks: &BlockRay<S>,
        slot: u32,
        collect: &mut C,
        tested: &mut u64,
    ) -> f32 {
        // A leaf has a block: no test before the first.
        let mut index = range.start;
        loop {
            *tested += 1;
            let whose = [slot, (index * WIDTH) as u32];
            self.leaves.blocks[index].meet_at(simd, for_blocks, whose, collect);
            index += 1;
            if index >= range.end {
                return collect.reach();
            }
        }
    }

    /// Offers hits in a leaf up to the first; whether there is none.
    #[inline(always)]
    fn leaf_any<S: Simd, C: Collect>(
        &self,
        simd: S,
        range: Range<usize>,
        for_blocks: &BlockRay<S>,
        slot: u32,
        collect: &mut C,
        tested: &mut u64,
    ) -> bool {
        for index in range {
            *tested += 1;
            let whose = [slot, (index * WIDTH) as u32];
            self.leaves.blocks[index].meet_at(simd, for_blocks, whose, collect);
            if collect.is_done() {
                return false;
            }
        }
        true
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
