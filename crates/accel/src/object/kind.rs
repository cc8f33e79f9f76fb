// SPDX-License-Identifier: GPL-3.0-or-later
//! Which geometries of an object share a tree: those of one kind and one mask.

use gnurt_accel_bvh::BlockSort;
use gnurt_accel_core::geometry::GeometryKind;

use crate::Geometry;

/// The kinds of trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Surfaces,
    /// Moving meshes, with this many keys.
    Moving(u32),
    /// All that is not a triangle.
    Blocks(BlockSort),
}

/// A kind, and a mask.
pub(super) type Group = (Kind, u32);

/// The group of a geometry.
pub(super) fn group_of(geometry: &Geometry) -> Group {
    let kind = match (&geometry.kind, BlockSort::of(&geometry.kind)) {
        (GeometryKind::Moving(mesh), _) => Kind::Moving(mesh.keys.len() as u32),
        (_, Some(sort)) => Kind::Blocks(sort),
        (_, None) => Kind::Surfaces,
    };
    (kind, geometry.mask)
}
