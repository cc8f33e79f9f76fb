// SPDX-License-Identifier: GPL-3.0-or-later
//! Which geometries of an object share a tree: those of one kind and one mask.

use gnurt_accel_bvh::BlockSort;
use gnurt_accel_core::geometry::GeometryKind;

use crate::Geometry;

/// The kinds of trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Surfaces,
    /// Moving meshes: how many keys they have, and the bits of the times of the first and of the last one.
    Moving(u32, [u32; 2]),
    /// All that is not a triangle.
    Blocks(BlockSort),
}

/// A kind, and a mask.
pub(super) type Group = (Kind, u32);

/// The group of a geometry.
pub(super) fn group_of(geometry: &Geometry) -> Group {
    let kind = match (&geometry.kind, BlockSort::of(&geometry.kind)) {
        (_, Some(sort)) => Kind::Blocks(sort),
        (GeometryKind::Moving(moving), _) => moving_kind(moving.keys.len() as u32, moving.range),
        (_, None) => Kind::Surfaces,
    };
    (kind, geometry.mask)
}

/// The kind of moving meshes with so many keys, between these times.
pub(super) fn moving_kind(keys: u32, range: [f32; 2]) -> Kind {
    Kind::Moving(keys, range.map(f32::to_bits))
}
