// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile cut into chunks of sixteen rays: what each of them, and all together, may still meet.
//! Source: [RSH05] (intervals); the second level of intervals is original. Invariant: `farthest` is the largest `ahead`.
//! Proof: `tests/brute_force.rs`.

use gnurt_simd::Simd;

use super::beam::{Beam, CHUNKS, Ranges, Slopes};
use super::blocks::TriangleBlock;
use crate::packet::Heading;
use crate::tile::{LANES, NearestTile, RayTile};

/// Chunks of one tile.
pub(crate) struct Chunks {
    pub(crate) slopes: Slopes,
    /// All rays as intervals.
    pub(crate) beam: Beam,
    /// How many steps any ray still looks ahead.
    pub(crate) farthest: f32,
    count: usize,
    /// The rays of each chunk as intervals.
    parts: [Beam; CHUNKS],
    /// How many steps each chunk still looks ahead.
    ahead: [f32; CHUNKS],
}

impl Chunks {
    /// The first `count` rays of a tile, all of one heading; nothing if `too_wide` says so of all of them.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(
        simd: S,
        rays: &RayTile,
        count: usize,
        heading: Heading,
        reach: f32,
        nearest: &NearestTile,
        too_wide: impl Fn(&Ranges) -> bool,
    ) -> Option<Self> {
        let mut slopes = Slopes::EMPTY;
        let (each, whole) = slopes.prepare(simd, rays, count, heading);
        if too_wide(&whole) {
            return None;
        }
        let beam = Beam::new(&whole, heading, reach);
        let count = count.div_ceil(LANES);
        let mut parts = [Beam::EMPTY; CHUNKS];
        for (part, ranges) in parts.iter_mut().zip(&each).take(count) {
            *part = Beam::new(ranges, heading, reach);
        }
        let ahead = [f32::NEG_INFINITY; CHUNKS];
        let mut chunks = Self { slopes, beam, farthest: f32::NEG_INFINITY, count, parts, ahead };
        chunks.look_again(simd, nearest, u32::MAX);
        Some(chunks)
    }

    /// After hits of the chunks in `touched`.
    #[inline(always)]
    pub(crate) fn look_again<S: Simd>(&mut self, simd: S, nearest: &NearestTile, touched: u32) {
        for which in 0..self.count {
            if touched >> which & 1 == 1 {
                self.ahead[which] = self.slopes.chunk_ahead(simd, nearest, which);
            }
        }
        let [a, b, c, d] = self.ahead;
        self.farthest = a.max(b).max(c).max(d);
    }

    /// Calls `meet(place, chunk, its slopes)` for each triangle of a block that rays in `bits` may meet; it says whether
    /// one did.
    #[inline(always)]
    pub(crate) fn block<S: Simd>(
        &mut self,
        simd: S,
        block: &TriangleBlock,
        bits: u64,
        nearest: &mut NearestTile,
        mut meet: impl FnMut(usize, usize, &Slopes, &mut NearestTile) -> bool,
    ) {
        let extents = [block.extent(simd, 0), block.extent(simd, 1), block.extent(simd, 2)];
        if self.beam.meet_extents(simd, &extents, self.farthest) == 0 {
            return;
        }
        let mut touched = 0;
        for which in 0..self.count {
            if bits >> (which * LANES) & 0xffff == 0 {
                continue;
            }
            let mut places = self.parts[which].meet_extents(simd, &extents, self.ahead[which]);
            while places != 0 {
                let place = places.trailing_zeros() as usize;
                places &= places - 1;
                touched |= u32::from(meet(place, which, &self.slopes, nearest)) << which;
            }
        }
        if touched != 0 {
            self.look_again(simd, nearest, touched);
        }
    }
}
