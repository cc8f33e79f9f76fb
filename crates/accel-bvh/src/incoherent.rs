// SPDX-License-Identifier: GPL-3.0-or-later
//! Incoherent rays of a tile: traced singly, or interleaved if they wait for memory.
//! Source: decision 0016. Tests: `tests/brute_force.rs` of `gnurt-accel`, `interleaved::tests`.

use gnurt_accel_core::Aabb;
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
    let bounds = &index.tree.bounds;
    let mut active = traversal.active;
    if !is_inside(bounds, traversal.rays.origin(active)) {
        // Those that miss the tree's box have visited its root.
        active &= prepared.enter(simd, traversal, count, bounds);
        traversal.counters.nodes += u64::from((traversal.active & !active).count_ones());
    }
    let traversal = &mut traversal.only(active);
    let single_rays = prepared.single_rays(traversal.rays, direction_classes);
    if const { has_wide_lanes::<S>() }
        && index.waits_for_memory()
        && traversal.rays.origins_differ(simd, traversal.active, bounds)
    {
        return Interleaved { simd, index, single_rays, direction_classes }.run(traversal);
    }
    single_rays.walk(simd, index, Child::node(0), traversal);
}

/// Whether a point is in a box.
#[inline(always)]
fn is_inside(bounds: &Aabb, [x, y, z]: [f32; 3]) -> bool {
    let ([low_x, low_y, low_z], [high_x, high_y, high_z]) = (bounds.min, bounds.max);
    let along_x = low_x <= x && x <= high_x;
    along_x && low_y <= y && y <= high_y && low_z <= z && z <= high_z
}
