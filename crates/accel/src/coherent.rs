// SPDX-License-Identifier: GPL-3.0-or-later
//! Separates the rays of a tile by direction class: those of one class go through a tree together.
//! Source: [RSH05] (rays of one octant). Space: that of the traversal.
//! Invariant: each active ray is in one class's group, or among the rest. Tests: `tests/brute_force.rs`
//! (`query`).

use gnurt_accel_core::bits::{TILE, all};
use gnurt_accel_core::direction_class::{DirectionClass, DirectionClasses};
use gnurt_accel_core::tile::{LANES, NearestTile, RayTile};
use gnurt_accel_core::traversal::TileTraversal;

use crate::engine::Engine;

/// Fewer rays of one class go one by one.
pub(crate) const WORTH_A_TILE: u32 = 4;

/// Calls `go` for each sufficiently frequent class, with a state whose first rays have it, all of them
/// active; lanes beyond them up to the next multiple of 16 have no extent. Returns the bits of the rays that
/// are to go one by one.
pub(crate) fn by_direction_class(
    engine: &Engine,
    traversal: &mut TileTraversal,
    go: &mut dyn FnMut(DirectionClass, &mut TileTraversal),
) -> u64 {
    if let Some(direction_class) = traversal.rays.direction_class
        && traversal.active.trailing_ones() == traversal.active.count_ones()
    {
        if traversal.active.count_ones() < WORTH_A_TILE {
            return traversal.active;
        }
        let active = traversal.active;
        go(direction_class, &mut traversal.only(active));
        return 0;
    }
    let direction_classes = engine.tiles.direction_classes(traversal.rays);
    let mut single = traversal.active & !direction_classes.regular;
    let mut left = traversal.active & direction_classes.regular;
    while left != 0 {
        let (direction_class, bits) = direction_classes.like(left.trailing_zeros() as usize, left);
        left &= !bits;
        if bits.count_ones() < WORTH_A_TILE {
            single |= bits;
        } else if bits == u64::MAX || is_as_good_as_full(traversal.rays, &direction_classes, bits) {
            go(direction_class, &mut traversal.only(u64::MAX));
        } else {
            split_incoherent(direction_class, bits, traversal, go);
        }
    }
    single
}

/// The rays in `bits` with copies of their own, side by side.
#[inline(never)]
fn split_incoherent(
    direction_class: DirectionClass,
    bits: u64,
    traversal: &mut TileTraversal,
    go: &mut dyn FnMut(DirectionClass, &mut TileTraversal),
) {
    let (mut some, mut best) = (RayTile::EMPTY, NearestTile::EMPTY);
    let count = traversal.rays.gather(traversal.nearest, bits, &mut some, &mut best);
    go(direction_class, &mut traversal.of_copies(&some, all(count), &mut best));
    traversal.nearest.scatter(bits, &best);
}

/// Whether the tile can be used unchanged for the rays in `bits`: no lanes would be saved without the others,
/// all of which have the same class.
fn is_as_good_as_full(rays: &RayTile, direction_classes: &DirectionClasses, bits: u64) -> bool {
    rays.is_full
        && bits.count_ones() as usize > TILE - LANES
        && direction_classes.like(bits.trailing_zeros() as usize & (TILE - 1), direction_classes.regular).1
            == u64::MAX
}
