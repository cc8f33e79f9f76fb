// SPDX-License-Identifier: GPL-3.0-or-later
//! Which geometries of an object share a tree: those of one kind and one mask.

use gnurt_accel_core::geometry::GeometryKind;

use crate::Geometry;

/// The kinds of trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Surfaces,
    /// Moving meshes, with this many keys.
    Moving(u32),
    Spheres,
    User,
}

/// A kind, and a mask.
pub(super) type Group = (Kind, u32);

/// The group of a geometry.
pub(super) fn group_of(geometry: &Geometry) -> Group {
    let kind = match geometry.kind {
        GeometryKind::Triangles(_) | GeometryKind::Quads(_) => Kind::Surfaces,
        GeometryKind::Moving(ref mesh) => Kind::Moving(mesh.keys.len() as u32),
        GeometryKind::Spheres(_) => Kind::Spheres,
        GeometryKind::User(_) => Kind::User,
    };
    (kind, geometry.mask)
}
