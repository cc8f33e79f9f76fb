// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's triangles under a wide BVH.
//! Source: original. Space: object. Proof: `tests/brute_force.rs`.

mod store;

use gnurt_simd::Simd;

use super::apart::Apart;
use super::blocks::BlockRay;
use super::faces::has_wide_lanes;
use super::leaves::Leaves;
use super::slab::NodeRay;
use super::sweep::Sweep;
use super::turns::Turns;
use super::{Child, Primitives, Tree, WIDTH, try_build};
use crate::control::Watch;
use crate::geometry::Screened;
use crate::kd::split_boxes;
use crate::nearest::{Best, Collect, Mode};
use crate::packet::Heading;
use crate::tile::{Headings, NearestTile, RayTile, TILE, each};
use crate::{Aabb, BuildError, Counters, Memory, Quality, Ray, Threads, TreeStats};

/// Tree and triangles.
#[derive(Debug, PartialEq)]
pub(crate) struct BvhIndex {
    tree: Tree,
    leaves: Leaves,
    reach: f32,
    stats: TreeStats,
}

impl Primitives for Screened<'_> {
    fn count(&self) -> usize {
        self.good.len()
    }

    fn bounds(&self, i: usize) -> Aabb {
        Aabb::around(&self.corners(self.good[i]))
    }

    fn split(&self, i: usize, cell: &Aabb, axis: usize, at: f32) -> Option<[Option<Aabb>; 2]> {
        Some(split_boxes(&self.corners(self.good[i]), cell, axis, at))
    }
}

impl BvhIndex {
    /// Builds over the good triangles.
    pub(crate) fn build(
        screened: &Screened,
        quality: Quality,
        memory: Memory,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let mut tree = try_build(screened, quality, threads, watch)?;
        let mut held = tree.node_bytes();
        tree.settle(memory);
        watch.recount(&mut held, tree.node_bytes());
        let stats = tree.measure();
        let in_blocks = std::mem::take(&mut tree.blocks);
        let leaves = Leaves::build(screened, memory, &in_blocks, threads, watch)?;
        watch.give(size_of_val(&in_blocks[..]));
        let reach = tree.reach();
        Ok(Self { tree, leaves, reach, stats })
    }

    /// Box around all triangles.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// Tree and triangles.
    pub(super) fn parts(&self) -> (&Tree, &Leaves) {
        (&self.tree, &self.leaves)
    }

    pub(crate) fn stats(&self) -> TreeStats {
        TreeStats {
            tree_bytes: self.tree.node_bytes() as u64,
            primitive_bytes: self.leaves.memory_bytes() as u64,
            ..self.stats
        }
    }

    /// Offers what `ray` meets; it is sound and regular, the tree not empty.
    #[inline(always)]
    pub(crate) fn search<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let for_nodes = NodeRay::new(simd, ray, self.reach);
        let for_blocks = BlockRay::new(simd, ray);
        let Self { tree, leaves, .. } = self;
        walk_blocks(simd, tree, leaves, Child::node(0), &for_nodes, &for_blocks, slot, collect, counters);
    }

    /// The same for those rays of a tile that are in `active`, which go these `ways` and need not have anything in common.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "they are what a tile's way through a tree takes")]
    pub(crate) fn search_apart<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        ways: Headings,
        active: u64,
        slot: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        let Self { tree, leaves, reach, .. } = self;
        let apart = &Apart::new(simd, rays, ways, TILE - active.leading_zeros() as usize, *reach);
        if const { has_wide_lanes::<S>() }
            && self.waits_for_memory()
            && rays.start_apart(simd, active, &tree.bounds)
        {
            return Turns { simd, tree, leaves, rays, apart, slot }.run::<M>(active, nearest, counters);
        }
        each(
            active,
            #[inline(always)]
            |i| {
                let mut best = Best::<M>::new(nearest.get(i));
                let for_nodes = apart.for_nodes(simd, i, apart.ways.of(i).rows(), rays.t_near[i]);
                let for_blocks = apart.for_blocks(simd, i, rays.t_near[i]);
                let root = Child::node(0);
                walk_blocks(simd, tree, leaves, root, &for_nodes, &for_blocks, slot, &mut best, counters);
                nearest.set(i, &best.0);
            },
        );
    }

    /// The same for the first `count` rays of a tile, all of one heading. Lanes beyond them up to the next multiple of
    /// 16 hold copies of rays that look for nothing (`t` is -inf).
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "they are what a tile's way through a tree takes")]
    pub(crate) fn sweep<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        count: usize,
        heading: Heading,
        slot: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        Sweep { simd, tree: self, reach: self.reach, slot, rays, count, heading }.run::<M>(nearest, counters);
    }
}

/// Where rays are expected to miss the cache more often than this, they take turns: the least that pays of six scenes has
/// 8.9, the most that does not 7.6.
const WORTH_TURNS: f32 = 8.0;

/// The part of a tree that a core's own cache holds, in bytes.
const CACHED: f32 = 2e6;

impl BvhIndex {
    /// Whether a ray that does not follow in another one's steps misses the cache often: by what it is expected to visit,
    /// and the part of the tree that is somewhere else. Compact trees know no turns.
    pub(super) fn waits_for_memory(&self) -> bool {
        let bytes = size_of_val(&self.tree.nodes[..]) + size_of_val(&self.leaves.blocks[..]);
        let elsewhere = 1.0 - CACHED / (bytes as f32).max(CACHED);
        self.stats.sah_cost as f32 * elsewhere > WORTH_TURNS
    }
}

/// One ray from `start` on through the tree and its blocks.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "tree, ray and result")]
pub(super) fn walk_blocks<S: Simd, C: Collect>(
    simd: S,
    tree: &Tree,
    leaves: &Leaves,
    start: Child,
    for_nodes: &NodeRay<S>,
    for_blocks: &BlockRay<S>,
    slot: u32,
    collect: &mut C,
    counters: &mut Counters,
) {
    let mut tested = 0;
    let visited = if C::ANY {
        tree.walk_any(
            simd,
            start,
            for_nodes,
            collect.reach(),
            #[inline(always)]
            |range| {
                for index in range {
                    tested += 1;
                    leaves.block(simd, index, &mut None).meet(simd, for_blocks, slot, collect);
                    if collect.is_done() {
                        return false;
                    }
                }
                true
            },
        )
    } else {
        tree.walk(
            simd,
            start,
            for_nodes,
            collect.reach(),
            #[inline(always)]
            |range| {
                for index in range {
                    tested += 1;
                    leaves.block(simd, index, &mut None).meet(simd, for_blocks, slot, collect);
                }
                collect.reach()
            },
        )
    };
    counters.nodes += u64::from(visited);
    counters.triangles += tested * WIDTH as u64;
}
