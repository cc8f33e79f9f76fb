// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts the rays of a tile by heading: those of one heading go through a tree together.
//! Source: [RSH05] (rays of one octant). Space: that of the trip.
//! Invariant: each active ray goes with one heading, or is among the rest. Tests: `tests/brute_force.rs` (`ask`).

use gnurt_accel_core::bits::{TILE, all};
use gnurt_accel_core::heading::{Heading, Headings};
use gnurt_accel_core::tile::{LANES, NearestTile, RayTile};
use gnurt_accel_core::trip::TileTrip;

use crate::engine::Engine;

/// Fewer rays of one heading go one by one.
pub(crate) const WORTH_A_TILE: u32 = 4;

/// Calls `go` for each heading that is worth it, with a trip whose first rays have it, all of them active; lanes beyond
/// them up to the next multiple of 16 look for nothing. Returns the bits of the rays that are to go one by one.
pub(crate) fn by_heading(
    engine: &Engine,
    trip: &mut TileTrip,
    go: &mut dyn FnMut(Heading, &mut TileTrip),
) -> u64 {
    if let Some(heading) = trip.rays.heading
        && trip.active.trailing_ones() == trip.active.count_ones()
    {
        if trip.active.count_ones() < WORTH_A_TILE {
            return trip.active;
        }
        let active = trip.active;
        go(heading, &mut trip.only(active));
        return 0;
    }
    let headings = engine.tiles.headings(trip.rays);
    let mut alone = trip.active & !headings.regular;
    let mut left = trip.active & headings.regular;
    while left != 0 {
        let (heading, bits) = headings.like(left.trailing_zeros() as usize, left);
        left &= !bits;
        if bits.count_ones() < WORTH_A_TILE {
            alone |= bits;
        } else if bits == u64::MAX || is_as_good_as_full(trip.rays, &headings, bits) {
            go(heading, &mut trip.only(u64::MAX));
        } else {
            go_apart(heading, bits, trip, go);
        }
    }
    alone
}

/// The rays in `bits` with copies of their own, side by side.
#[inline(never)]
fn go_apart(heading: Heading, bits: u64, trip: &mut TileTrip, go: &mut dyn FnMut(Heading, &mut TileTrip)) {
    let (mut some, mut best) = (RayTile::EMPTY, NearestTile::EMPTY);
    let count = trip.rays.gather(trip.nearest, bits, &mut some, &mut best);
    go(heading, &mut trip.of_copies(&some, all(count), &mut best));
    trip.nearest.scatter(bits, &best);
}

/// Whether the tile can go as it is for the rays in `bits`: no lanes would be saved without the others, all of which have the
/// same heading.
fn is_as_good_as_full(rays: &RayTile, headings: &Headings, bits: u64) -> bool {
    rays.is_full
        && bits.count_ones() as usize > TILE - LANES
        && headings.like(bits.trailing_zeros() as usize & (TILE - 1), headings.regular).1 == u64::MAX
}
