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
use crate::tile::{LANES, NearestTile, PerRay, RayTile};
use crate::triangle::{LanesMeeting, Sheared, axes_from, meet_lanes};

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
        let visited = tree.sweep(simd, &beam, farthest, |blocks| {
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
        });
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
        chunk: usize,
        nearest: &mut NearestTile,
    ) -> bool {
        let simd = self.simd;
        let at = chunk * LANES;
        let load = |values: &PerRay| f32x16::from_slice(simd, &values[at..at + LANES]);
        let [x, y, z] = axes_from(self.heading.longest_axis);
        let corner = |corner: usize, axis: usize| f32x16::splat(simd, block.corner(place, corner, axis));
        let corners = [
            [corner(0, x), corner(0, y), corner(0, z)],
            [corner(1, x), corner(1, y), corner(1, z)],
            [corner(2, x), corner(2, y), corner(2, z)],
        ];
        let sheared = Sheared {
            org: [load(&self.rays.org[x]), load(&self.rays.org[y]), load(&self.rays.org[z])],
            shear: [load(&slopes.shear[0]), load(&slopes.shear[1]), load(&slopes.shear[2])],
        };
        let best = load(&nearest.t);
        let everyone = mask32x16::splat(simd, true);
        let met = meet_lanes(simd, corners, &sheared, everyone, load(&self.rays.t_near), best);
        if !met.hit.any_true() {
            return false;
        }
        let LanesMeeting { t, u, v, hit } = met;
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
        let store = |values: &mut PerRay, new: f32x16<S>| {
            let old = f32x16::from_slice(simd, &values[at..at + LANES]);
            better.select(new, old).store_slice(&mut values[at..at + LANES]);
        };
        store(&mut nearest.t, t);
        store(&mut nearest.u, u);
        store(&mut nearest.v, v);
        better.select(number, old_number).store_slice(&mut nearest.number[at..at + LANES]);
        better.select(slot, old_slot).store_slice(&mut nearest.slot[at..at + LANES]);
        true
    }
}
