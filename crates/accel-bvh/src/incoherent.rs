// SPDX-License-Identifier: GPL-3.0-or-later
//! Incoherent rays of a tile: traced singly, or interleaved if they wait for memory.
//! Source: decision 0016. Tests: `tests/brute_force.rs` of `gnurt-accel`, `interleaved::tests`.

use gnurt_accel_core::beam::has_wide_lanes;
use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::direction_class::DirectionClasses;
use gnurt_accel_core::traversal::TileTraversal;
use gnurt_simd::Simd;

use crate::index::BvhIndex;
use crate::interleaved::Interleaved;
use crate::node::Child;
use crate::single_rays::PreparedTile;

/// Improves the hits of a tile's active rays, which have these direction classes and may be incoherent.
#[inline(always)]
pub(crate) fn walk_incoherent<S: Simd>(
    simd: S,
    index: &BvhIndex,
    direction_classes: &DirectionClasses,
    traversal: &mut TileTraversal,
) {
    let count = TILE - traversal.active.leading_zeros() as usize;
    let prepared = &PreparedTile::new(simd, traversal.rays, count, index.greatest);
    let single_rays = prepared.single_rays(traversal.rays, direction_classes);
    if const { has_wide_lanes::<S>() }
        && index.waits_for_memory()
        && traversal.rays.origins_differ(simd, traversal.active, &index.tree.bounds)
    {
        return Interleaved { simd, index, single_rays, direction_classes }.run(traversal);
    }
    single_rays.walk(simd, index, Child::node(0), traversal);
}
