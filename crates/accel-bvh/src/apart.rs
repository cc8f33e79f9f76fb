// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays of a tile that have nothing in common: one after the other, or, where memory is what they wait for, by turns.
//! Source: decision 0016. Tests: `tests/brute_force.rs` of `gnurt-accel`, `turns::tests`.

use gnurt_accel_core::beam::has_wide_lanes;
use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::heading::Headings;
use gnurt_accel_core::trip::TileTrip;
use gnurt_simd::Simd;

use crate::alone::PreparedTile;
use crate::index::BvhIndex;
use crate::node::Child;
use crate::turns::Turns;

/// Improves the hits of a tile's active rays, which go these ways and need not have anything in common.
#[inline(always)]
pub(crate) fn walk_apart<S: Simd>(simd: S, index: &BvhIndex, headings: &Headings, trip: &mut TileTrip) {
    let count = TILE - trip.active.leading_zeros() as usize;
    let prepared = &PreparedTile::new(simd, trip.rays, count, index.greatest);
    let alone = prepared.alone(trip.rays, headings);
    if const { has_wide_lanes::<S>() }
        && index.waits_for_memory()
        && trip.rays.start_apart(simd, trip.active, &index.tree.bounds)
    {
        return Turns { simd, index, alone, headings }.run(trip);
    }
    alone.walk(simd, index, Child::node(0), trip);
}
