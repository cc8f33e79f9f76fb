// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile of rays through a top tree. Source: [RSH05] for what rays share, as `walk_beam`. Space: that of the boxes.
//! Proof: `tests/instances.rs` of `gnurt-accel`, which asks at every level.

use gnurt_accel_core::beam::{Beam, Slopes};
use gnurt_accel_core::bits::{TILE, all};
use gnurt_accel_core::heading::Heading;
use gnurt_accel_core::tile::LANES;
use gnurt_accel_core::trip::TileTrip;
use gnurt_simd::Simd;

use super::BoxIndex;
use crate::planes::{MovingMember, TilePlanes};
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
        let planes = self.planes(simd, trip, count);
        let shot = &Shot { beam, slopes, count, heading, planes };
        let farthest = shot.slopes.steps_ahead(simd, trip.nearest, count);
        let visited = match &self.treelets[..] {
            [only] => tile_treelet(simd, only, shot, farthest, trip, enter).1,
            treelets => tile_upper(simd, &self.upper, treelets, shot, farthest, trip, enter),
        };
        trip.counters.nodes += u64::from(visited) * count as u64;
    }
}

impl BoxIndex {
    /// A tile's rays prepared one by one, where boxes move. Not on the stack, which scenes in one another share.
    #[inline(never)]
    fn planes<S: Simd>(&self, simd: S, trip: &TileTrip, count: usize) -> Option<Box<TilePlanes>> {
        if !self.moves() {
            return None;
        }
        simd.vectorize(
            #[inline(always)]
            || Some(Box::new(TilePlanes::of(simd, trip.rays, count, self.origin, self.greatest()))),
        )
    }
}

/// A tile's rays, prepared for boxes.
struct Shot {
    beam: Beam,
    slopes: Slopes,
    /// How many rays there are.
    count: usize,
    heading: Heading,
    /// Each ray by itself, where boxes move.
    planes: Option<Box<TilePlanes>>,
}

impl Shot {
    /// Which of the rays, each at its moment, may meet the member at a place of a block that moves.
    #[inline(never)]
    fn at_moments<S: Simd>(&self, simd: S, member: MovingMember, trip: &TileTrip) -> u64 {
        let Some(planes) = &self.planes else { return u64::MAX };
        simd.vectorize(
            #[inline(always)]
            || {
                let chunks = (0..self.count).step_by(LANES);
                chunks.fold(0, |bits, at| {
                    bits | planes.meet_moving(simd, &member, self.heading, trip.rays, trip.nearest, at) << at
                })
            },
        )
    }
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
                    for at in range {
                        let block = &nodes[at];
                        let (mut bits, _) = shot.beam.meet(simd, &block.rows, farthest);
                        while bits != 0 {
                            let lane = bits.trailing_zeros() as usize;
                            bits &= bits - 1;
                            let mut active = all(shot.count) & trip.nearest.looking(simd);
                            if let Some(keys) = treelet.at_keys()
                                && keys.moves(at, lane)
                            {
                                active &= shot.at_moments(simd, MovingMember { keys, block: at, lane }, trip);
                            }
                            enter(block.child(lane).index(), &mut trip.only(active));
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
