// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile of rays through the kd-tree: multi-level ray tracing.
//! Source: [RSH05]: the tile goes down as one interval of its rays' parameters, so that a subtree is entered only if
//! some ray may meet it. Differs: the tile continues to the leaves, nearest first, instead of stopping at an
//! entry point; triangles are discarded for the whole tile and then for each sixteen rays of it before any
//! ray is tested. Origins need not be one point: they are an interval, too. Mailboxes [AW87].
//! Invariant: a leaf that a single ray would reach before its hit is visited. Tests: `tests/brute_force.rs`.

use gnurt_accel_core::beam::{Beam, CHUNKS, Ranges};
use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::chunks::Chunks;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::float::{least, most};
use gnurt_accel_core::tile::LANES;
use gnurt_accel_core::tile_test::TileTest;
use gnurt_accel_core::traversal::TileTraversal;
use gnurt_simd::{Simd, StackBuffer};

use crate::leaves::Leaves;
use crate::mailbox::Mailbox;
use crate::node::{DEEPEST, KdTree};

/// A tree and its leaves.
pub(crate) struct Blocked<'a> {
    pub(crate) tree: &'a KdTree,
    pub(crate) leaves: &'a Leaves,
}

/// A far child that is still to be visited.
#[derive(Clone, Copy)]
struct FarChild {
    node: u32,
    first: f32,
    last: f32,
}

/// Tiles may be this wide, as a part of the tree's size.
const FARTHEST_SPREAD: f32 = 1.0 / 16.0;

impl Blocked<'_> {
    /// Improves the hits of a tile's first rays, all of them active and of one direction class. Returns false
    /// without a result if their intervals are so wide that single rays are faster.
    #[inline(always)]
    pub(crate) fn walk_tile<S: Simd>(
        &self,
        simd: S,
        greatest: f32,
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
    ) -> bool {
        let TileTraversal { rays, kind, slot, .. } = *traversal;
        let count = TILE - traversal.active.leading_zeros() as usize;
        let [x, y, z] = self.tree.bounds.extent();
        let size = x.max(y).max(z) as f32;
        let too_wide = |whole: &Ranges| whole.spread(size) > FARTHEST_SPREAD * size;
        let Some(mut chunks) =
            Chunks::new(simd, rays, count, direction_class, greatest, traversal.nearest, too_wide)
        else {
            return false;
        };
        let test = TileTest { simd, rays, kind, slot, direction_class };
        let mut mailboxes = [Mailbox::<64>::EMPTY; CHUNKS];
        let (mut visited, mut tested) = (0u64, 0u64);
        let (beam, farthest) = (chunks.beam, chunks.farthest);
        self.walk_coherent(
            &beam,
            farthest,
            &mut visited,
            #[inline(always)]
            |blocks| {
                for block in &self.leaves.blocks[blocks] {
                    chunks.block(
                        simd,
                        block,
                        traversal.active,
                        traversal.nearest,
                        #[inline(always)]
                        |candidate, slopes, nearest| {
                            let known = mailboxes[candidate.chunk].has(block.numbers[candidate.lane & 7]);
                            tested += if known { 0 } else { LANES as u64 };
                            !known && test.meet(block, &candidate, slopes, nearest)
                        },
                    );
                }
                chunks.farthest
            },
        );
        traversal.counters.nodes += visited * count as u64;
        traversal.counters.triangles += tested;
        true
    }
}

impl Blocked<'_> {
    /// Calls `leaf` with the blocks of each leaf that the beam meets before `reach` steps, nearest first; it answers
    /// with the new reach.
    #[inline(always)]
    fn walk_coherent(
        &self,
        beam: &Beam,
        mut reach: f32,
        visited: &mut u64,
        mut leaf: impl FnMut(std::ops::Range<usize>) -> f32,
    ) {
        let beam = beam.planes();
        let [mut first, mut last] = beam.clip(&self.tree.bounds, reach);
        if first > last {
            return;
        }
        let mut buffer = StackBuffer::<FarChild, DEEPEST>::new();
        let mut waiting = buffer.stack();
        let mut at = 0;
        loop {
            let mut node = self.tree.nodes[at as usize];
            *visited += 1;
            while !node.is_leaf() {
                let axis = node.axis();
                let [meet_first, meet_last] = beam.meet(axis, node.plane());
                let near = node.left() + beam.back[axis];
                let far = node.left() + 1 - beam.back[axis];
                at = if meet_last < first {
                    far
                } else {
                    if meet_first <= last {
                        waiting.push(FarChild { node: far, first: most(first, meet_first), last });
                        last = least(last, meet_last);
                    }
                    near
                };
                node = self.tree.nodes[at as usize];
                *visited += 1;
            }
            if node.item() != 0 {
                reach = leaf(self.leaves.of(node));
            }
            loop {
                let Some(next) = waiting.pop() else { return };
                if next.first <= reach {
                    (at, first, last) = (next.node, next.first, least(next.last, reach));
                    break;
                }
            }
        }
    }
}
