// SPDX-License-Identifier: GPL-3.0-or-later
//! The input of trees: the kinds of geometry, and one numbering for all of their primitives. The kinds and
//! the two halves of a quad are Embree's. Space: object.
//! Invariant: numbers ascend with the geometry, then with the primitive, so that they order hits as their ids do.
//! Tests: `tests::each_fault_is_counted_once`, `tests::quads_have_two_numbers`.

use std::sync::Arc;

pub use crate::bad_primitives::{BadPrimitives, LARGEST_COORDINATE, MOST_TRIANGLES};
use crate::curve::Curves;
use crate::grids::Grids;
use crate::user::UserGeometry;

/// No plane of a box lies beyond this: the box of a sphere reaches to twice [`LARGEST_COORDINATE`], and those of compact
/// nodes a sixteenth farther. Times the inverse of a regular ray's flattest direction, 2^50, that is far from an overflow.
pub const FARTHEST_PLANE: f32 = 4e18;

/// One mesh: borrowed arrays. Its `geom_id` is its index in the list of the build.
#[derive(Clone, Copy, Debug, Default)]
pub struct Triangles<'a> {
    /// Vertex positions, object space.
    pub positions: &'a [[f32; 3]],
    /// Vertices of each triangle; its index is its `prim_id`.
    pub indices: &'a [[u32; 3]],
}

/// One mesh of quads: borrowed arrays.
///
/// A quad is two triangles, of its vertices 0, 1, 3 and 2, 3, 1, and need not be flat. Where vertices 2 and 3 are one
/// it is a triangle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quads<'a> {
    /// Vertex positions, object space.
    pub positions: &'a [[f32; 3]],
    /// Vertices of each quad, around it; its index is its `prim_id`.
    pub indices: &'a [[u32; 4]],
}

/// Spheres: borrowed arrays of the same length; excess elements are ignored. A sphere's index is its
/// `prim_id`.
///
/// A ray hits a sphere's surface twice, from inside once. Radii are positive; other spheres are dropped and
/// counted among the primitives of zero area.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spheres<'a> {
    /// Centres, object space.
    pub centers: &'a [[f32; 3]],
    /// Radii.
    pub radii: &'a [f32],
}

/// Discs: borrowed arrays of the same length; excess elements are ignored. A disc's index is its `prim_id`.
///
/// Radii are positive and normals not zero; other discs are dropped and counted among the primitives of zero area.
#[derive(Clone, Copy, Debug, Default)]
pub struct Discs<'a> {
    /// Centres, object space.
    pub centers: &'a [[f32; 3]],
    /// Radii.
    pub radii: &'a [f32],
    /// Normals of any length; `None` for discs that face each ray.
    pub normals: Option<&'a [[f32; 3]]>,
}

/// One mesh that moves during an open shutter: borrowed arrays.
///
/// Vertices move in straight lines from key to key. Rays of [`Ray::time`](crate::Ray::time) 0 see the first
/// key, those of 1 the last one. A triangle with a bad coordinate at some key is dropped.
#[derive(Clone, Copy, Debug, Default)]
pub struct MovingTriangles<'a> {
    /// Vertex positions, object space, at times evenly spaced from 0 to 1: a list for each. One list is
    /// static.
    pub keys: &'a [&'a [[f32; 3]]],
    /// Vertices of each triangle; its index is its `prim_id`.
    pub indices: &'a [[u32; 3]],
}

impl<'a> MovingTriangles<'a> {
    /// The mesh at a key. Panics where there is none.
    #[must_use]
    pub fn at_key(&self, key: usize) -> Triangles<'a> {
        Triangles { positions: self.keys[key], indices: self.indices }
    }
}

/// Quads that move during an open shutter: as [`MovingTriangles`], with the quads of [`Quads`].
#[derive(Clone, Copy, Debug, Default)]
pub struct MovingQuads<'a> {
    /// Vertex positions by key.
    pub keys: &'a [&'a [[f32; 3]]],
    /// Vertices of each quad, around it; its index is its `prim_id`.
    pub indices: &'a [[u32; 4]],
}

impl<'a> MovingQuads<'a> {
    /// The mesh at a key. Panics where there is none.
    #[must_use]
    pub fn at_key(&self, key: usize) -> Quads<'a> {
        Quads { positions: self.keys[key], indices: self.indices }
    }
}

/// The kind and data of a geometry.
#[derive(Clone, Debug)]
pub enum GeometryKind<'a> {
    /// A triangle mesh.
    Triangles(Triangles<'a>),
    /// A mesh of quads.
    Quads(Quads<'a>),
    /// Grids of vertices.
    Grids(Grids<'a>),
    /// Spheres.
    Spheres(Spheres<'a>),
    /// Spheres that rays hit from outside only.
    SphereOutsides(Spheres<'a>),
    /// Discs.
    Discs(Discs<'a>),
    /// Curves with a width.
    Curves(Curves<'a>),
    /// A triangle mesh that moves while the shutter is open.
    Moving(MovingTriangles<'a>),
    /// Quads that move while the shutter is open.
    MovingQuads(MovingQuads<'a>),
    /// Primitives defined by the caller; stored in the tree.
    User(Arc<dyn UserGeometry>),
}

/// One geometry of an object. Its `geom_id` is its index in the list of the build.
#[derive(Clone, Debug)]
pub struct Geometry<'a> {
    /// Its kind and data.
    pub kind: GeometryKind<'a>,
    /// Which rays see it: those whose mask has a bit in common with this one.
    ///
    /// An object has a tree for each mask and kind, so few different masks cost nothing and many cost speed.
    pub mask: u32,
    /// The times of its first and its last key, if it moves: before and after these no ray sees it. They may lie
    /// outside of the open shutter, which is from 0 to 1.
    pub times: [f32; 2],
}

impl<'a> Geometry<'a> {
    /// A geometry that all rays see.
    #[must_use]
    pub fn new(kind: GeometryKind<'a>) -> Self {
        Self { kind, mask: u32::MAX, times: [0.0, 1.0] }
    }

    /// Primitives of the caller's own making.
    #[must_use]
    pub fn user(geometry: Arc<dyn UserGeometry>) -> Self {
        Self::new(GeometryKind::User(geometry))
    }

    /// The same geometry, seen by rays whose mask has a bit in common with `mask`.
    #[must_use]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }

    /// The same geometry with keys from one time to another.
    #[must_use]
    pub fn within(self, times: [f32; 2]) -> Self {
        Self { times, ..self }
    }

    /// How many keys it has; 1 if it stands still.
    #[must_use]
    pub fn keys(&self) -> u32 {
        match &self.kind {
            GeometryKind::Moving(mesh) => mesh.keys.len() as u32,
            GeometryKind::MovingQuads(mesh) => mesh.keys.len() as u32,
            GeometryKind::User(user) => user.keys(),
            _ => 1,
        }
    }

    /// How many numbers its primitives take.
    fn count(&self) -> usize {
        match &self.kind {
            GeometryKind::Triangles(mesh) => mesh.indices.len(),
            GeometryKind::Quads(mesh) => 2 * mesh.indices.len(),
            GeometryKind::Grids(grids) => 2 * grids.cells(),
            GeometryKind::Spheres(spheres) | GeometryKind::SphereOutsides(spheres) => {
                spheres.centers.len().min(spheres.radii.len())
            }
            GeometryKind::Discs(discs) => {
                let count = discs.centers.len().min(discs.radii.len());
                discs.normals.map_or(count, |normals| count.min(normals.len()))
            }
            GeometryKind::Curves(curves) => curves.indices.len(),
            GeometryKind::Moving(mesh) if mesh.keys.is_empty() => 0,
            GeometryKind::Moving(mesh) => mesh.indices.len(),
            GeometryKind::MovingQuads(mesh) if mesh.keys.is_empty() => 0,
            GeometryKind::MovingQuads(mesh) => 2 * mesh.indices.len(),
            GeometryKind::User(user) => user.count() as usize,
        }
    }
}

impl<'a> From<Triangles<'a>> for Geometry<'a> {
    fn from(mesh: Triangles<'a>) -> Self {
        Self::new(GeometryKind::Triangles(mesh))
    }
}

impl<'a> From<MovingTriangles<'a>> for Geometry<'a> {
    fn from(mesh: MovingTriangles<'a>) -> Self {
        Self::new(GeometryKind::Moving(mesh))
    }
}

impl<'a> From<MovingQuads<'a>> for Geometry<'a> {
    fn from(mesh: MovingQuads<'a>) -> Self {
        Self::new(GeometryKind::MovingQuads(mesh))
    }
}

impl<'a> From<Quads<'a>> for Geometry<'a> {
    fn from(mesh: Quads<'a>) -> Self {
        Self::new(GeometryKind::Quads(mesh))
    }
}

impl<'a> From<Grids<'a>> for Geometry<'a> {
    fn from(grids: Grids<'a>) -> Self {
        Self::new(GeometryKind::Grids(grids))
    }
}

impl<'a> From<Spheres<'a>> for Geometry<'a> {
    fn from(spheres: Spheres<'a>) -> Self {
        Self::new(GeometryKind::Spheres(spheres))
    }
}

impl<'a> From<Discs<'a>> for Geometry<'a> {
    fn from(discs: Discs<'a>) -> Self {
        Self::new(GeometryKind::Discs(discs))
    }
}

impl<'a> From<Curves<'a>> for Geometry<'a> {
    fn from(curves: Curves<'a>) -> Self {
        Self::new(GeometryKind::Curves(curves))
    }
}

/// Numbers of all primitives of an object: triangles, halves of quads, and all others.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Numbering {
    /// First number of each geometry, and one past the last.
    pub starts: Vec<u32>,
    /// Which geometries are quads, or grids of them.
    pub quads: Vec<bool>,
    /// Primitives that got no number.
    pub too_many: u64,
}

/// A number split into its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Located {
    pub geom_id: u32,
    pub prim_id: u32,
    /// The half of a quad that holds its vertices 1, 2 and 3.
    pub second_half: bool,
}

impl Numbering {
    pub fn new(geometries: &[Geometry]) -> Self {
        let mut numbering = Self { starts: vec![0], ..Self::default() };
        let mut next = 0;
        for geometry in geometries {
            let quads = matches!(
                geometry.kind,
                GeometryKind::Quads(_) | GeometryKind::MovingQuads(_) | GeometryKind::Grids(_)
            );
            let (count, free) = (geometry.count(), MOST_TRIANGLES - next);
            // Quads are taken whole.
            let taken = count.min(if quads { free / 2 * 2 } else { free });
            numbering.too_many += ((count - taken) >> u32::from(quads)) as u64;
            next += taken;
            numbering.starts.push(next as u32);
            numbering.quads.push(quads);
        }
        numbering
    }

    /// Numbers of one geometry.
    #[inline]
    pub fn range(&self, geometry: usize) -> std::ops::Range<u32> {
        self.starts[geometry]..self.starts[geometry + 1]
    }

    /// Which primitive has this number.
    #[inline]
    pub fn locate(&self, number: u32) -> Located {
        let geometry = geometry_of(&self.starts, number);
        let within = number - self.starts[geometry];
        let geom_id = geometry as u32;
        if self.quads[geometry] {
            Located { geom_id, prim_id: within / 2, second_half: within & 1 == 1 }
        } else {
            Located { geom_id, prim_id: within, second_half: false }
        }
    }
}

/// The geometry that holds `number`, given where each one starts.
#[inline]
pub fn geometry_of(starts: &[u32], number: u32) -> usize {
    if starts.len() == 2 { 0 } else { starts.partition_point(|&start| start <= number) - 1 }
}
