// SPDX-License-Identifier: GPL-3.0-or-later
//! An object or a scene placed in the world, and rays carried into its space.
//! Source: original; two levels after [WBS03a].
//! Spaces: rays come in world space and leave in object space; `t` is the same in both, directions keep their scale.
//! The origin is carried relative to the object's place, split in two floats, so that objects far from the world's
//! origin lose no precision near themselves. Rays with origins in double precision are carried in double precision.
//! Proof: `tests::carries_rays`, `tests/watertight.rs`, `tests/far_away.rs`.

use std::sync::Arc;

use gnurt_simd::{Simd, f32x16, prelude::*};

use crate::tile::{LANES, PerRay, RayTile, TILE};
use crate::{Aabb, ObjectTree, Ray, SceneTree};

/// What an instance shows.
#[derive(Clone, Debug)]
pub enum Shape {
    /// An object.
    Object(Arc<ObjectTree>),
    /// A scene with instances of its own.
    Scene(Arc<SceneTree>),
}

/// An object or a scene, and where it is.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Shared by all instances of it.
    pub shape: Shape,
    /// Columns of the affine map to the space of the scene that the instance is in: images of the x, y and z axes, then
    /// of the origin.
    pub world_from_object: [[f64; 3]; 4],
    /// Which rays see it: those whose mask has a bit in common with this one.
    pub mask: u32,
}

impl Instance {
    /// An object or a scene at a place, seen by all rays.
    #[must_use]
    pub fn new(shape: impl Into<Shape>, world_from_object: [[f64; 3]; 4]) -> Self {
        Self { shape: shape.into(), world_from_object, mask: u32::MAX }
    }

    /// One that lies in the world as it is, seen by all rays.
    #[must_use]
    pub fn identity(shape: impl Into<Shape>) -> Self {
        Self::new(shape, IDENTITY)
    }

    /// The same instance, seen by rays whose mask has a bit in common with `mask`.
    #[must_use]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }
}

impl From<Arc<ObjectTree>> for Shape {
    fn from(object: Arc<ObjectTree>) -> Self {
        Self::Object(object)
    }
}

impl From<Arc<SceneTree>> for Shape {
    fn from(scene: Arc<SceneTree>) -> Self {
        Self::Scene(scene)
    }
}

impl Shape {
    /// How many scenes lie in one another here.
    pub(super) fn depth(&self) -> u32 {
        match self {
            Self::Object(_) => 0,
            Self::Scene(scene) => scene.depth,
        }
    }

    /// How many objects are in it.
    pub(super) fn leaves(&self) -> u32 {
        match self {
            Self::Object(_) => 1,
            Self::Scene(scene) => scene.leaves,
        }
    }

    fn bounds(&self) -> Box64 {
        match self {
            Self::Object(object) => Box64::from(object.bounds()),
            Self::Scene(scene) => scene.bounds64,
        }
    }
}

const IDENTITY: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// A box in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Box64 {
    pub(super) min: [f64; 3],
    pub(super) max: [f64; 3],
}

impl Box64 {
    pub(super) const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    pub(super) fn is_empty(&self) -> bool {
        (0..3).any(|k| self.min[k] > self.max[k])
    }

    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            min: [0, 1, 2].map(|k| self.min[k].min(other.min[k])),
            max: [0, 1, 2].map(|k| self.max[k].max(other.max[k])),
        }
    }

    /// With all coordinates rounded to the nearest floats.
    pub(super) fn nearest(&self) -> Aabb {
        Aabb { min: self.min.map(|x| x as f32), max: self.max.map(|x| x as f32) }
    }

    /// A box of floats around it.
    pub(super) fn rounded(&self) -> Aabb {
        let outward = |x: f64, towards: f32, next: fn(f32) -> f32| {
            let near = x as f32;
            if (f64::from(near) - x) * f64::from(towards) < 0.0 { next(near) } else { near }
        };
        Aabb {
            min: self.min.map(|x| outward(x, -1.0, f32::next_down)),
            max: self.max.map(|x| outward(x, 1.0, f32::next_up)),
        }
    }
}

impl From<Aabb> for Box64 {
    fn from(bounds: Aabb) -> Self {
        Self { min: bounds.min.map(f64::from), max: bounds.max.map(f64::from) }
    }
}

impl Default for Box64 {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// An instance made ready for rays.
#[derive(Debug)]
pub(crate) struct Placed {
    pub(super) shape: Shape,
    /// Its number in the list that the scene was built from.
    pub(crate) inst_id: u32,
    /// The number of its first object among all of the scene.
    pub(super) first_leaf: u32,
    pub(super) mask: u32,
    /// `None` where world and object space are the same.
    pub(crate) object_from_world: Option<ObjectFromWorld>,
}

/// `p_object = linear * (p_world - place)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectFromWorld {
    /// Rows of the linear part.
    pub(crate) rows: [[f32; 3]; 3],
    /// Where the object's origin is in the world: nearest floats, and what they leave over.
    pub(crate) place: [[f32; 3]; 2],
}

/// The same in double precision, and its inverse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exact {
    /// Rows of the linear part of the map into the object.
    pub(super) rows: [[f64; 3]; 3],
    /// Images of the axes, then of the origin.
    pub(super) columns: [[f64; 3]; 4],
}

impl Exact {
    /// The inverse, where there is one.
    fn new(columns: &[[f64; 3]; 4]) -> Option<Self> {
        let [a, b, c, _] = *columns;
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let normals = [cross(b, c), cross(c, a), cross(a, b)];
        let determinant: f64 = (0..3).map(|k| a[k] * normals[0][k]).sum();
        (determinant != 0.0)
            .then(|| Self { rows: normals.map(|n| n.map(|x| x / determinant)), columns: *columns })
    }

    /// A point of the world in the object's space.
    pub(super) fn point(&self, world: [f64; 3]) -> [f64; 3] {
        let from = [0, 1, 2].map(|k| world[k] - self.columns[3][k]);
        self.rows.map(|row| row[0] * from[0] + row[1] * from[1] + row[2] * from[2])
    }

    /// A ray whose origin is known in double precision, and that origin in the object's space.
    pub(super) fn ray(&self, ray: &Ray, origin: &[f64; 3]) -> (Ray, [f64; 3]) {
        let inside = self.point(*origin);
        let dir = ray.dir.map(f64::from);
        let dir = self.rows.map(|row| (row[0] * dir[0] + row[1] * dir[1] + row[2] * dir[2]) as f32);
        (Ray { org: inside.map(|x| x as f32), dir, ..*ray }, inside)
    }
}

impl ObjectFromWorld {
    #[inline(always)]
    pub(crate) fn ray(&self, ray: &Ray) -> Ray {
        let [high, low] = self.place;
        let from = |k: usize| (ray.org[k] - high[k]) - low[k];
        let from = [from(0), from(1), from(2)];
        Ray { org: self.vector(from), dir: self.vector(ray.dir), ..*ray }
    }

    #[inline(always)]
    fn vector(&self, v: [f32; 3]) -> [f32; 3] {
        let along = |r: &[f32; 3]| r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
        [along(&self.rows[0]), along(&self.rows[1]), along(&self.rows[2])]
    }

    /// The same for all rays of a tile.
    #[inline(always)]
    pub(super) fn tile<S: Simd>(&self, simd: S, rays: &RayTile, inside: &mut RayTile) {
        let [high, low] = self.place;
        let at = |value: f32| f32x16::splat(simd, value);
        for first in (0..TILE).step_by(LANES) {
            let load = |values: &PerRay| f32x16::from_slice(simd, &values[first..first + LANES]);
            let [ox, oy, oz] = [load(&rays.org[0]), load(&rays.org[1]), load(&rays.org[2])];
            let [dx, dy, dz] = [load(&rays.dir[0]), load(&rays.dir[1]), load(&rays.dir[2])];
            let fx = (ox - at(high[0])) - at(low[0]);
            let fy = (oy - at(high[1])) - at(low[1]);
            let fz = (oz - at(high[2])) - at(low[2]);
            for (k, row) in self.rows.iter().enumerate() {
                let org = at(row[0]) * fx + at(row[1]) * fy + at(row[2]) * fz;
                let dir = at(row[0]) * dx + at(row[1]) * dy + at(row[2]) * dz;
                org.store_slice(&mut inside.org[k][first..first + LANES]);
                dir.store_slice(&mut inside.dir[k][first..first + LANES]);
            }
        }
        inside.t_near = rays.t_near;
        inside.mask = rays.mask;
    }
}

impl Placed {
    /// With its map in double precision and its box in the world; `None` where the transform has no inverse in floats,
    /// or a value that is not finite. `first_leaf` is still to be set.
    pub(super) fn new(instance: &Instance, inst_id: u32) -> Option<(Self, Exact, Box64)> {
        let columns = &instance.world_from_object;
        let exact = Exact::new(columns)?;
        let object_from_world =
            if *columns == IDENTITY { None } else { Some(ObjectFromWorld::rounded(&exact)?) };
        let bounds = instance.shape.bounds();
        let bounds = match object_from_world {
            None => bounds,
            Some(_) => carry_box(columns, &bounds, [0.0; 3])?,
        };
        let shape = instance.shape.clone();
        let placed = Self { shape, inst_id, first_leaf: 0, mask: instance.mask, object_from_world };
        Some((placed, exact, bounds))
    }

    /// The box in floats, relative to `origin`.
    pub(super) fn bounds_from(&self, exact: &Exact, origin: [f32; 3]) -> Aabb {
        let bounds = self.shape.bounds();
        let in_floats = matches!(self.shape, Shape::Object(_)) || bounds == Box64::from(bounds.rounded());
        if self.object_from_world.is_none() && origin == [0.0; 3] && in_floats {
            return bounds.rounded();
        }
        let carried = carry_box(&exact.columns, &bounds, origin.map(f64::from));
        carried.map_or(Aabb::EMPTY, |carried| carried.nearest())
    }
}

impl ObjectFromWorld {
    fn rounded(exact: &Exact) -> Option<Self> {
        let rows = exact.rows.map(|row| row.map(|x| x as f32));
        let place = exact.columns[3];
        let high = place.map(|x| x as f32);
        let low = [0, 1, 2].map(|k| (place[k] - f64::from(high[k])) as f32);
        let sound = rows.iter().chain([&high, &low]).flatten().all(|x| x.is_finite());
        let spans = rows.iter().all(|row| row.iter().any(|&x| x != 0.0));
        (sound && spans).then_some(Self { rows, place: [high, low] })
    }
}

/// The world box of an object's box, relative to `origin`: around its eight corners, a little wider than rounding could
/// make it in floats. `None` where a float cannot hold it.
fn carry_box(columns: &[[f64; 3]; 4], object: &Box64, origin: [f64; 3]) -> Option<Box64> {
    if object.is_empty() {
        return Some(Box64::EMPTY);
    }
    let [axes @ .., place] = columns;
    let mut bounds = Box64::EMPTY;
    for k in 0..3 {
        let at = place[k] - origin[k];
        let (mut low, mut high, mut size) = (at, at, at.abs());
        for (axis, column) in axes.iter().enumerate() {
            let ends = [object.min[axis], object.max[axis]].map(|x| column[k] * x);
            low += ends[0].min(ends[1]);
            high += ends[0].max(ends[1]);
            size += ends[0].abs().max(ends[1].abs());
        }
        let slack = size * f64::from(f32::EPSILON);
        bounds.min[k] = low - slack;
        bounds.max[k] = high + slack;
    }
    bounds.min.iter().chain(&bounds.max).all(|&x| (x as f32).is_finite()).then_some(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn carries_rays() {
        // Scaled by 2 along x, turned a quarter around z, then moved far away.
        let columns = [[0.0, 2.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1e6 + 0.125, 0.3, -7.0]];
        let exact = Exact::new(&columns).expect("invertible");
        let map = ObjectFromWorld::rounded(&exact).expect("in the range of floats");
        let world = Ray::new([1e6 - 1.0, 4.0, -7.0], [0.0, 2.0, 0.0]);
        let object = map.ray(&world);
        assert_eq!(object.dir, [1.0, 0.0, 0.0], "world y is object x, scaled");
        let error = (object.org[0] - 1.85).abs() + (object.org[1] - 1.125).abs() + object.org[2].abs();
        assert!(error < 1e-6, "{:?} is relative to the object's place", object.org);
        let (precise, inside) = exact.ray(&world, &[1e6 - 1.0, 4.0 + 1e-9, -7.0]);
        assert_eq!(precise.dir, object.dir, "directions are those of floats here");
        assert!((inside[0] - 1.85 - 5e-10).abs() < 1e-12, "{inside:?} keeps what floats would lose");
    }

    #[test]
    fn flat_and_unsound_maps_are_refused() {
        let object = Arc::new(ObjectTree::build(&[], &Default::default(), crate::Threads::Single));
        for (column, value) in [(0, 0.0), (3, f64::NAN), (1, f64::INFINITY), (2, 1e-300)] {
            let mut instance = Instance::identity(Arc::clone(&object));
            instance.world_from_object[column] = [value; 3];
            assert!(Placed::new(&instance, 0).is_none(), "{value} in column {column} cannot be undone");
        }
        assert!(Placed::new(&Instance::identity(object), 0).is_some(), "an empty object can be placed");
    }
}
