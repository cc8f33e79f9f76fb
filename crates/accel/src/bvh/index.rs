// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's triangles under a wide BVH.
//! Source: original. Space: object. Proof: `tests/brute_force.rs`.

mod store;

use gnurt_simd::{Simd, prefer_huge_pages};
use rayon::prelude::*;

use super::blocks::{BlockRay, TriangleBlock};
use super::slab::NodeRay;
use super::sweep::Sweep;
use super::{Child, Primitives, Tree, WIDTH, try_build};
use crate::control::Watch;
use crate::geometry::Screened;
use crate::kd::split_boxes;
use crate::nearest::{Collect, Mode};
use crate::packet::Heading;
use crate::tile::{NearestTile, RayTile};
use crate::{Aabb, BuildError, Counters, Quality, Ray, Threads, TreeStats};

/// Tree and triangles.
#[derive(Debug, PartialEq)]
pub(crate) struct BvhIndex {
    tree: Tree,
    blocks: Vec<TriangleBlock>,
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
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let mut tree = try_build(screened, quality, threads, watch)?;
        watch.take(tree.blocks.len() * size_of::<TriangleBlock>());
        watch.result()?;
        let stats = tree.measure();
        let in_blocks = std::mem::take(&mut tree.blocks);
        let number = |i: u32| screened.good.get(i as usize).copied().unwrap_or(crate::INVALID_ID);
        let mut blocks = Vec::with_capacity(in_blocks.len());
        prefer_huge_pages(&blocks);
        let block = |places: &[u32; WIDTH]| TriangleBlock::new(screened, &places.map(number));
        threads.run(|parallel| match parallel {
            true => blocks.par_extend(in_blocks.par_iter().with_min_len(256).map(block)),
            false => blocks.extend(in_blocks.iter().map(block)),
        });
        watch.give(size_of_val(&in_blocks[..]));
        let reach = tree.bounds.reach();
        Ok(Self { tree, blocks, reach, stats })
    }

    /// Box around all triangles.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// Tree and triangles.
    pub(super) fn parts(&self) -> (&Tree, &[TriangleBlock]) {
        (&self.tree, &self.blocks)
    }

    pub(crate) fn stats(&self) -> TreeStats {
        TreeStats {
            tree_bytes: size_of_val(&self.tree.nodes[..]) as u64,
            primitive_bytes: size_of_val(&self.blocks[..]) as u64,
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
        let Self { tree, blocks, .. } = self;
        walk_blocks(simd, tree, blocks, Child::node(0), &for_nodes, &for_blocks, slot, collect, counters);
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
        let Self { tree, blocks, reach, .. } = self;
        Sweep { simd, tree, blocks, reach: *reach, slot, rays, count, heading }.run::<M>(nearest, counters);
    }
}

/// One ray from `start` on through the tree and its blocks.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "tree, ray and result")]
pub(super) fn walk_blocks<S: Simd, C: Collect>(
    simd: S,
    tree: &Tree,
    blocks: &[TriangleBlock],
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
                for block in &blocks[range] {
                    tested += 1;
                    block.meet(simd, for_blocks, slot, collect);
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
                for block in &blocks[range] {
                    tested += 1;
                    block.meet(simd, for_blocks, slot, collect);
                }
                collect.reach()
            },
        )
    };
    counters.nodes += u64::from(visited);
    counters.triangles += tested * WIDTH as u64;
}
