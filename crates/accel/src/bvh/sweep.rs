// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile of rays through the tree: multi-level ray tracing, and packets where it does not pay.
//! Source: [RSH05]: subtrees, then triangles, are discarded for all rays at once. Differs: the interval test is made on
//! the eight children of a node, then on the eight triangles of a block; the tree is searched front to back, so that a
//! tile's common entry point is found on the way and what lies behind all hits is skipped. Where intervals leave
//! [`MANY`] children or more, rays are tested against each child, sixteen to a step, and only those that meet it go on
//! (masks, the paper's Figure 4); a few that are left go on alone ([BWW*12]).
//! In: a tile whose first `count` rays have one heading. Each ray gets the hit that it would get alone.
//! Proof: `tests/brute_force.rs`.

use gnurt_simd::{Simd, Stack, f32x16, mask32x16, prelude::*, u32x16};

use super::beam::Slopes;
use super::blocks::{BlockRay, TriangleBlock};
use super::chunks::{Candidate, Chunks};
use super::index::walk_blocks;
use super::leaves::ask_for;
use super::planes::TilePlanes;
use super::walk::farthest_first;
use super::{BvhIndex, Child, WIDTH};
use crate::Counters;
use crate::nearest::{Best, Mode, Nearest};
use crate::packet::Heading;
use crate::tile::{LANES, NearestTile, PerRay, RayTile, TILE, all, chunk};
use crate::triangle::{LanesMeeting, Sheared, axes_from, meet_alone, pass_edges};

/// A tile on its way through one object's tree.
pub(crate) struct Sweep<'a, S: Simd, T> {
    pub(crate) simd: S,
    /// Tree and triangles.
    pub(crate) tree: &'a T,
    pub(crate) reach: f32,
    pub(crate) slot: u32,
    pub(crate) rays: &'a RayTile,
    pub(crate) count: usize,
    pub(crate) heading: Heading,
}

/// Where intervals leave this many children of a node, rays are tested one by one.
const MANY: u32 = 2;
/// So many rays or fewer go on alone.
const FEW: u32 = 2;

/// What waits: a child, the rays that may meet it, and after how many steps the first of them may.
#[derive(Clone, Copy)]
struct Waiting {
    steps: f32,
    child: Child,
    rays: u64,
}

impl<S: Simd> Sweep<'_, S, BvhIndex> {
    /// Improves the hits of the tile's rays.
    #[inline(always)]
    pub(super) fn run<M: Mode>(&self, nearest: &mut NearestTile, counters: &mut Counters) {
        let Self { simd, rays, count, heading, .. } = *self;
        let (tree, leaves) = self.tree.parts();
        let waits = self.tree.waits_for_memory();
        let chunks = simd.part(
            #[inline(always)]
            || Chunks::new(simd, rays, count, heading, self.reach, nearest, |_| false),
        );
        let Some(mut chunks) = chunks else {
            return;
        };
        let mut planes = TilePlanes::EMPTY;
        let mut planes_ready = false;

        let mut stack = Stack::<Waiting, 512>::new();
        stack.push(Waiting { steps: 0.0, child: Child::node(0), rays: all(count) });
        while let Some(Waiting { steps, child, rays: mut bits }) = stack.pop() {
            if steps > chunks.farthest {
                continue;
            }
            if M::ANY {
                bits &= nearest.looking(simd);
                if bits == 0 {
                    continue;
                }
            }
            let here = u64::from(bits.count_ones());
            counters.nodes += here;
            if here as u32 <= FEW {
                if !planes_ready {
                    planes.prepare(simd, rays, count, self.reach);
                    planes_ready = true;
                }
                let mut touched = 0;
                while bits != 0 {
                    let i = bits.trailing_zeros() as usize & (TILE - 1);
                    bits &= bits - 1;
                    let mut lane = nearest.get(i);
                    let before = lane.t;
                    simd.part(
                        #[inline(always)]
                        || self.alone::<M>(i, child, &planes, &chunks.slopes, &mut lane, counters),
                    );
                    // Also where `t` stays: a triangle with a lower number may lie there.
                    nearest.set(i, &lane);
                    if lane.t != before {
                        touched |= 1 << (i / LANES);
                    }
                }
                if touched != 0 {
                    chunks.look_again(simd, nearest, touched);
                }
                continue;
            }
            if child.is_leaf() {
                for index in child.blocks() {
                    let mut room = None;
                    let block = leaves.block(simd, index, &mut room);
                    chunks.block(
                        simd,
                        block,
                        bits,
                        nearest,
                        #[inline(always)]
                        |candidate, slopes, nearest| {
                            let tested = bits >> (candidate.chunk * LANES) & 0xffff;
                            counters.triangles += u64::from(tested.count_ones());
                            self.meet::<M>(block, &candidate, slopes, nearest)
                        },
                    );
                }
                continue;
            }

            let expanded;
            let node = match tree.nodes.get(child.index()) {
                Some(node) => node,
                None => {
                    expanded = tree.compact[child.index()].expand(simd);
                    &expanded
                }
            };
            let (mut places, near) = chunks.beam.meet(simd, node, chunks.farthest);
            let near = near.as_array();
            let one_by_one = places.count_ones() >= MANY;
            if one_by_one && !planes_ready {
                planes.prepare(simd, rays, count, self.reach);
                planes_ready = true;
            }
            let mut pushed = 0;
            while places != 0 {
                let place = places.trailing_zeros() as usize & (WIDTH - 1);
                places &= places - 1;
                let mut those = bits;
                if one_by_one {
                    those = 0;
                    for at in (0..count).step_by(LANES) {
                        if bits >> at & 0xffff != 0 {
                            let meet = simd.part(
                                #[inline(always)]
                                || planes.meet(simd, node, place, heading, rays, nearest, at),
                            );
                            those |= meet << at;
                        }
                    }
                    those &= bits;
                    if those == 0 {
                        continue;
                    }
                }
                let child = node.child(place);
                if waits {
                    ask_for(tree, leaves, child);
                }
                stack.push(Waiting { steps: near[place], child, rays: those });
                pushed += 1;
            }
            farthest_first(stack.top(pushed), |waiting: &Waiting| waiting.steps);
        }
    }

    /// One of the rays on its own, from `child` on.
    #[inline(always)]
    fn alone<M: Mode>(
        &self,
        i: usize,
        child: Child,
        planes: &TilePlanes,
        slopes: &Slopes,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        let Self { simd, rays, heading, slot, .. } = *self;
        let for_nodes = planes.alone(simd, i, heading.rows(), rays.t_near[i]);
        let axes = axes_from(heading.longest_axis);
        let [x, y, z] = axes;
        let sheared = Sheared {
            org: [rays.org[x][i], rays.org[y][i], rays.org[z][i]],
            shear: [slopes.shear[0][i], slopes.shear[1][i], slopes.shear[2][i]],
        };
        let for_blocks = BlockRay::sheared(simd, axes, sheared, rays.t_near[i]);
        let mut best = Best::<M>::new(*nearest);
        let (tree, leaves) = self.tree.parts();
        walk_blocks(simd, tree, leaves, child, &for_nodes, &for_blocks, slot, &mut best, counters);
        *nearest = best.0;
    }
}

impl<S: Simd, T> Sweep<'_, S, T> {
    /// One triangle against one chunk; whether any ray hits.
    #[inline(always)]
    pub(crate) fn meet<M: Mode>(
        &self,
        block: &TriangleBlock,
        candidate: &Candidate<S>,
        slopes: &Slopes,
        nearest: &mut NearestTile,
    ) -> bool {
        let simd = self.simd;
        let (place, at) = (candidate.place, candidate.chunk * LANES);
        let shear = [
            chunk(simd, &slopes.shear[0], at),
            chunk(simd, &slopes.shear[1], at),
            chunk(simd, &slopes.shear[2], at),
        ];
        let edges = pass_edges(simd, candidate.corners, &shear);
        if !edges.inside.any_true() {
            return false;
        }
        let best = chunk(simd, &nearest.t, at);
        let t_near = chunk(simd, &self.rays.t_near, at);
        let (met, uncertain) = edges.meet(simd, shear[2], edges.inside, t_near, best);
        let mut found = false;
        if uncertain.any_true() {
            found = self.meet_alone::<M>(block, place, slopes, at, uncertain.to_bitmask(), nearest);
        }
        if !met.hit.any_true() {
            return found;
        }
        let LanesMeeting { t, u, v, hit } = met;
        let best = chunk(simd, &nearest.t, at);
        let number = u32x16::splat(simd, block.numbers[place & 7]);
        let slot = u32x16::splat(simd, self.slot);
        let old_number = u32x16::from_slice(simd, &nearest.number[at..at + LANES]);
        let old_slot = u32x16::from_slice(simd, &nearest.slot[at..at + LANES]);
        let (t, better) = if M::ANY {
            (f32x16::splat(simd, f32::NEG_INFINITY), hit)
        } else {
            let lower = slot.simd_lt(old_slot) | (slot.simd_eq(old_slot) & number.simd_lt(old_number));
            (t, hit & (t.simd_lt(best) | (t.simd_eq(best) & lower)))
        };
        store(simd, &mut nearest.t, at, better, t);
        store(simd, &mut nearest.u, at, better, u);
        store(simd, &mut nearest.v, at, better, v);
        better.select(number, old_number).store_slice(&mut nearest.number[at..at + LANES]);
        better.select(slot, old_slot).store_slice(&mut nearest.slot[at..at + LANES]);
        true
    }

    /// Lanes that floats cannot decide.
    #[cold]
    #[inline(never)]
    fn meet_alone<M: Mode>(
        &self,
        block: &TriangleBlock,
        place: usize,
        slopes: &Slopes,
        at: usize,
        mut bits: u64,
        nearest: &mut NearestTile,
    ) -> bool {
        let axes = axes_from(self.heading.longest_axis);
        let corners = block.corners_of(place, axes);
        let mut found = false;
        while bits != 0 {
            let i = at + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let mut best = nearest.get(i);
            let alone = Sheared {
                org: axes.map(|k| self.rays.org[k][i]),
                shear: [slopes.shear[0][i], slopes.shear[1][i], slopes.shear[2][i]],
            };
            if let Some(meeting) = meet_alone(&corners, &alone, self.rays.t_near[i], best.t) {
                best.offer::<M>(meeting, block.numbers[place & 7], self.slot);
                nearest.set(i, &best);
                found = true;
            }
        }
        found
    }
}

/// Overwrites the lanes in `mask`.
#[inline(always)]
fn store<S: Simd>(simd: S, values: &mut PerRay, at: usize, mask: mask32x16<S>, new: f32x16<S>) {
    let old = chunk(simd, values, at);
    mask.select(new, old).store_slice(&mut values[at..at + LANES]);
}
