// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile of rays through the tree: multi-level ray tracing.
//! Source: [RSH05]: subtrees, then triangles, are discarded for all rays at once; only what is left meets single rays,
//! sixteen to a step. Differs: the interval test is made on the eight children of a node, then on the eight triangles
//! of a block; the tree is searched front to back, so that a tile's common entry point is found on the way and what
//! lies behind all hits is skipped.
//! In: a tile whose first `count` rays have one heading. Each ray gets the hit that it would get alone.
//! Proof: `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x16, mask32x16, prelude::*, u32x16};

use super::Tree;
use super::beam::{Beam, CHUNKS, Slopes};
use super::blocks::TriangleBlock;
use crate::Counters;
use crate::nearest::Mode;
use crate::packet::Heading;
use crate::tile::{LANES, NearestTile, PerRay, RayTile, chunk};
use crate::triangle::{LanesMeeting, Sheared, axes_from, meet_alone, pass_edges};

/// A tile on its way through one object's tree.
pub(super) struct Sweep<'a, S: Simd> {
    pub(super) simd: S,
    pub(super) tree: &'a Tree,
    pub(super) blocks: &'a [TriangleBlock],
    pub(super) reach: f32,
    pub(super) slot: u32,
    pub(super) rays: &'a RayTile,
    pub(super) count: usize,
    pub(super) heading: Heading,
}

impl<S: Simd> Sweep<'_, S> {
    /// Improves the hits of the tile's rays.
    #[inline(always)]
    pub(super) fn run<M: Mode>(&self, nearest: &mut NearestTile, counters: &mut Counters) {
        let Self { simd, tree, rays, count, heading, .. } = *self;
        let chunks = count.div_ceil(LANES);
        let mut slopes = Slopes::EMPTY;
        let (each, whole) = slopes.prepare(simd, rays, count, heading);
        let beam = Beam::new(simd, &whole, heading, &tree.bounds, self.reach);
        let mut parts = [beam; CHUNKS];
        for (part, ranges) in parts.iter_mut().zip(&each).take(chunks) {
            *part = Beam::new(simd, ranges, heading, &tree.bounds, self.reach);
        }
        // How many steps each chunk still looks ahead, and the tile.
        let mut ahead = [f32::NEG_INFINITY; CHUNKS];
        let mut farthest = f32::NEG_INFINITY;
        for chunk in 0..chunks {
            ahead[chunk] = slopes.chunk_ahead(simd, nearest, chunk);
            farthest = farthest.max(ahead[chunk]);
        }

        let mut tested = 0;
        let visited = tree.sweep(
            simd,
            &beam,
            farthest,
            #[inline(always)]
            |blocks| {
                for block in &self.blocks[blocks] {
                    let extents = [block.extent(simd, 0), block.extent(simd, 1), block.extent(simd, 2)];
                    if beam.meet_extents(simd, &extents, farthest) == 0 {
                        continue;
                    }
                    for chunk in 0..chunks {
                        let mut bits = parts[chunk].meet_extents(simd, &extents, ahead[chunk]);
                        let mut found = false;
                        while bits != 0 {
                            let place = bits.trailing_zeros() as usize;
                            bits &= bits - 1;
                            tested += 1;
                            found |= self.meet::<M>(block, place, &slopes, chunk, nearest);
                        }
                        if found {
                            ahead[chunk] = slopes.chunk_ahead(simd, nearest, chunk);
                        }
                    }
                    farthest = ahead[0].max(ahead[1]).max(ahead[2]).max(ahead[3]);
                }
                farthest
            },
        );
        counters.nodes += u64::from(visited) * (LANES * chunks) as u64;
        counters.triangles += tested * LANES as u64;
    }

    /// One triangle against one chunk; whether any ray hits.
    #[inline(always)]
    fn meet<M: Mode>(
        &self,
        block: &TriangleBlock,
        place: usize,
        slopes: &Slopes,
        which: usize,
        nearest: &mut NearestTile,
    ) -> bool {
        let simd = self.simd;
        let at = which * LANES;
        let [x, y, z] = axes_from(self.heading.longest_axis);
        let corners = [
            block.corner(simd, place, 0, [x, y, z]),
            block.corner(simd, place, 1, [x, y, z]),
            block.corner(simd, place, 2, [x, y, z]),
        ];
        let sheared = Sheared {
            org: [
                chunk(simd, &self.rays.org[x], at),
                chunk(simd, &self.rays.org[y], at),
                chunk(simd, &self.rays.org[z], at),
            ],
            shear: [
                chunk(simd, &slopes.shear[0], at),
                chunk(simd, &slopes.shear[1], at),
                chunk(simd, &slopes.shear[2], at),
            ],
        };
        let edges = pass_edges(simd, corners, &sheared);
        if !edges.inside.any_true() {
            return false;
        }
        let best = chunk(simd, &nearest.t, at);
        let t_near = chunk(simd, &self.rays.t_near, at);
        let (met, uncertain) = edges.meet(simd, &sheared, edges.inside, t_near, best);
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
