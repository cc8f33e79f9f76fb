// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile of rays through a top tree. Source: [RSH05] for what rays share, as `walk_beam`. Space: that of the boxes.
//! Proof: `tests/instances.rs` of `gnurt-accel`, which asks at every level.

use gnurt_accel_core::beam::{Beam, Slopes};
use gnurt_accel_core::bits::{TILE, all};
use gnurt_accel_core::heading::Heading;
use gnurt_accel_core::trip::TileTrip;
use gnurt_simd::Simd;

use super::BoxIndex;
use crate::treelet::Treelet;
use crate::walk::walk_beam;

impl BoxIndex {
    /// Calls `enter` with the places of boxes that a tile's first rays, all of them active and of one heading, may meet, and
    /// with the trip of those rays that still look for something. There are boxes.
    #[inline(always)]
    pub(crate) fn search_tile<S: Simd>(
        &self,
        simd: S,
        heading: Heading,
        trip: &mut TileTrip,
        enter: &mut dyn FnMut(usize, &mut TileTrip),
    ) {
        let count = TILE - trip.active.leading_zeros() as usize;
        let mut slopes = Slopes::EMPTY;
        slopes.prepare(simd, trip.rays, count, heading);
        let whole = slopes.all_ranges(simd, trip.rays, count);
        let beam = Beam::new(&whole.relative_to(self.origin), heading, self.greatest());
        let shot = &Shot { beam, slopes, count };
        let farthest = shot.slopes.steps_ahead(simd, trip.nearest, count);
        let visited = match &self.treelets[..] {
            [only] => tile_treelet(simd, only, shot, farthest, trip, enter).1,
            treelets => tile_upper(simd, &self.upper, treelets, shot, farthest, trip, enter),
        };
        trip.counters.nodes += u64::from(visited) * count as u64;
    }
}

/// A tile's rays, prepared for boxes.
struct Shot {
    beam: Beam,
    slopes: Slopes,
    /// How many rays there are.
    count: usize,
}

/// Calls `enter` with the members whose boxes a tile's rays may meet within `farthest` steps. Returns how far they reach
/// then, and the number of nodes visited.
#[inline(never)]
fn tile_treelet<S: Simd>(
    simd: S,
    treelet: &Treelet,
    shot: &Shot,
    mut farthest: f32,
    trip: &mut TileTrip,
    enter: &mut dyn FnMut(usize, &mut TileTrip),
) -> (f32, u32) {
    simd.vectorize(
        #[inline(always)]
        || {
            let nodes = treelet.nodes();
            let visited = walk_beam(
                nodes,
                simd,
                &shot.beam,
                farthest,
                #[inline(always)]
                |range| {
                    for block in &nodes[range] {
                        let (mut bits, _) = shot.beam.meet(simd, &block.rows, farthest);
                        while bits != 0 {
                            let place = block.child(bits.trailing_zeros() as usize).index();
                            bits &= bits - 1;
                            let active = all(shot.count) & trip.nearest.looking(simd);
                            enter(place, &mut trip.only(active));
                        }
                    }
                    farthest = shot.slopes.steps_ahead(simd, trip.nearest, shot.count);
                    farthest
                },
            );
            (farthest, visited)
        },
    )
}

/// The same through the upper treelet into those below; returns the number of nodes visited.
#[inline(never)]
fn tile_upper<S: Simd>(
    simd: S,
    upper: &Treelet,
    treelets: &[Treelet],
    shot: &Shot,
    mut farthest: f32,
    trip: &mut TileTrip,
    enter: &mut dyn FnMut(usize, &mut TileTrip),
) -> u32 {
    simd.vectorize(
        #[inline(always)]
        || {
            let (nodes, mut visited) = (upper.nodes(), 0);
            let above = walk_beam(
                nodes,
                simd,
                &shot.beam,
                farthest,
                #[inline(always)]
                |range| {
                    for block in &nodes[range] {
                        let (mut bits, _) = shot.beam.meet(simd, &block.rows, farthest);
                        while bits != 0 {
                            let number = block.child(bits.trailing_zeros() as usize).index();
                            bits &= bits - 1;
                            let below = tile_treelet(simd, &treelets[number], shot, farthest, trip, enter);
                            farthest = below.0;
                            visited += below.1;
                        }
                    }
                    farthest
                },
            );
            visited + above
        },
    )
}
