// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile of rays through the kd-tree: multi-level ray tracing.
//! Source: [RSH05]: the tile goes down as one interval of its rays' parameters, so that a subtree is entered only if
//! some ray may meet it. Differs: the tile goes on to the leaves, nearest first, instead of stopping at an entry point;
//! triangles are discarded for the whole tile and then for each sixteen rays of it before any ray is tested. Origins
//! need not be one point: they are an interval, too. Mailboxes [AW87].
//! Invariant: a leaf that one of the rays alone would come to before its hit is visited. Proof: `tests/brute_force.rs`.

use gnurt_simd::{Simd, Stack};

use super::leaves::Leaves;
use super::slab::{least, most};
use super::{DEEPEST, KdTree};
use crate::bvh::{Beam, CHUNKS, Slopes, Sweep};
use crate::nearest::Mode;
use crate::tile::{LANES, NearestTile};
use crate::{Counters, INVALID_ID};

/// A tree and its leaves.
pub(crate) struct Blocked<'a> {
    pub(crate) tree: &'a KdTree,
    pub(crate) leaves: &'a Leaves,
}

/// A far child that is still to be visited.
#[derive(Clone, Copy)]
struct Waiting {
    node: u32,
    first: f32,
    last: f32,
}

/// The last triangles that a chunk was tested against: a second test has nothing to add \[AW87\].
struct Mailbox {
    numbers: [u32; 64],
}

impl Mailbox {
    const EMPTY: Self = Self { numbers: [INVALID_ID; 64] };

    /// Whether a triangle is known; from now on it is.
    #[inline(always)]
    fn has(&mut self, number: u32) -> bool {
        let place = &mut self.numbers[number as usize & 63];
        std::mem::replace(place, number) == number
    }
}

/// Tiles may be this wide, as a part of the tree's size.
const FARTHEST_SPREAD: f32 = 1.0 / 16.0;

impl<S: Simd> Sweep<'_, S, Blocked<'_>> {
    /// Improves the hits of the tile's rays; or does nothing and says so, where they spread so far that one by one is
    /// faster: an interval that most leaves lie in tells nothing.
    #[inline(always)]
    pub(super) fn run<M: Mode>(&self, nearest: &mut NearestTile, counters: &mut Counters) -> bool {
        let Self { simd, tree, rays, count, heading, .. } = *self;
        let chunks = count.div_ceil(LANES);
        let mut slopes = Slopes::EMPTY;
        let (each, whole) = slopes.prepare(simd, rays, count, heading);
        let [x, y, z] = tree.tree.bounds.extent();
        let size = x.max(y).max(z) as f32;
        if whole.spread(size) > FARTHEST_SPREAD * size {
            return false;
        }
        let beam = Beam::new(&whole, heading, self.reach);
        let mut parts = [Beam::EMPTY; CHUNKS];
        for (part, ranges) in parts.iter_mut().zip(&each).take(chunks) {
            *part = Beam::new(ranges, heading, self.reach);
        }
        // How many steps each chunk still looks ahead, and the tile.
        let mut ahead = [f32::NEG_INFINITY; CHUNKS];
        for (which, ahead) in ahead.iter_mut().enumerate().take(chunks) {
            *ahead = slopes.chunk_ahead(simd, nearest, which);
        }
        let farthest = |ahead: &[f32; CHUNKS]| ahead[0].max(ahead[1]).max(ahead[2]).max(ahead[3]);

        let mut mailboxes = [Mailbox::EMPTY; CHUNKS];
        let (mut visited, mut tested) = (0u64, 0u64);
        tree.walk_together(
            &beam,
            farthest(&ahead),
            &mut visited,
            #[inline(always)]
            |blocks| {
                for block in &self.blocks[blocks] {
                    let extents = [block.extent(simd, 0), block.extent(simd, 1), block.extent(simd, 2)];
                    if beam.meet_extents(simd, &extents, farthest(&ahead)) == 0 {
                        continue;
                    }
                    for which in 0..chunks {
                        let mut places = parts[which].meet_extents(simd, &extents, ahead[which]);
                        let mut found = false;
                        while places != 0 {
                            let place = places.trailing_zeros() as usize;
                            places &= places - 1;
                            if !mailboxes[which].has(block.numbers[place & 7]) {
                                tested += LANES as u64;
                                found |= self.meet::<M>(block, place, &slopes, which, nearest);
                            }
                        }
                        if found {
                            ahead[which] = slopes.chunk_ahead(simd, nearest, which);
                        }
                    }
                }
                farthest(&ahead)
            },
        );
        counters.nodes += visited * (LANES * chunks) as u64;
        counters.triangles += tested;
        true
    }
}

impl Blocked<'_> {
    /// Calls `leaf` with the blocks of each leaf that the beam meets before `reach` steps, nearest first; it answers
    /// with the new reach.
    #[inline(always)]
    fn walk_together(
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
        let mut waiting = Stack::<Waiting, DEEPEST>::new();
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
                        waiting.push(Waiting { node: far, first: most(first, meet_first), last });
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
