// SPDX-License-Identifier: GPL-3.0-or-later
//! An object placed in the world, and rays carried into its space.
//! Source: original; two levels after [WBS03a].
//! Spaces: rays come in world space and leave in object space; `t` is the same in both, directions keep their scale.
//! The origin is carried relative to the object's place, split in two floats, so that objects far from the world's
//! origin lose no precision near themselves. Proof: `tests::carries_rays`, `tests/watertight.rs`.

use std::sync::Arc;

use gnurt_simd::{Simd, f32x16, prelude::*};

use crate::tile::{LANES, PerRay, RayTile, TILE};
use crate::{Aabb, ObjectTree, Ray};

/// An object and where it is.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Shared by all instances of the object.
    pub object: Arc<ObjectTree>,
    /// Columns of the affine map to the world: images of the x, y and z axes, then of the origin.
    pub world_from_object: [[f64; 3]; 4],
}

impl Instance {
    /// An object that lies in the world as it is.
    #[must_use]
    pub fn identity(object: Arc<ObjectTree>) -> Self {
        Self { object, world_from_object: IDENTITY }
    }
}

const IDENTITY: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// An instance made ready for rays.
#[derive(Debug)]
pub(crate) struct Placed {
    pub(crate) object: Arc<ObjectTree>,
    /// Its number in the list that the scene was built from.
    pub(crate) inst_id: u32,
    /// Box in the world.
    pub(crate) bounds: Aabb,
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
    }
}

impl Placed {
    /// `None` where the transform has no inverse in floats, or a value that is not finite.
    pub(crate) fn new(instance: &Instance, inst_id: u32) -> Option<Self> {
        let columns = &instance.world_from_object;
        let object_from_world =
            if *columns == IDENTITY { None } else { Some(ObjectFromWorld::inverse_of(columns)?) };
        let bounds = match object_from_world {
            None => instance.object.bounds(),
            Some(_) => carry_box(columns, &instance.object.bounds())?,
        };
        Some(Self { object: Arc::clone(&instance.object), inst_id, bounds, object_from_world })
    }
}

impl ObjectFromWorld {
    fn inverse_of(columns: &[[f64; 3]; 4]) -> Option<Self> {
        let [a, b, c, place] = *columns;
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let normals = [cross(b, c), cross(c, a), cross(a, b)];
        let determinant: f64 = (0..3).map(|k| a[k] * normals[0][k]).sum();
        if determinant == 0.0 {
            return None;
        }
        let rows = normals.map(|n| n.map(|x| (x / determinant) as f32));
        let high = place.map(|x| x as f32);
        let low = [0, 1, 2].map(|k| (place[k] - f64::from(high[k])) as f32);
        let sound = rows.iter().chain([&high, &low]).flatten().all(|x| x.is_finite());
        let spans = rows.iter().all(|row| row.iter().any(|&x| x != 0.0));
        (sound && spans).then_some(Self { rows, place: [high, low] })
    }
}

/// The world box of an object's box: around its eight corners, a little wider than rounding could make it.
fn carry_box(columns: &[[f64; 3]; 4], object: &Aabb) -> Option<Aabb> {
    if object.is_empty() {
        return Some(Aabb::EMPTY);
    }
    let [axes @ .., place] = columns;
    let mut bounds = Aabb::EMPTY;
    for (k, &at) in place.iter().enumerate() {
        let (mut low, mut high, mut size) = (at, at, at.abs());
        for (axis, column) in axes.iter().enumerate() {
            let ends = [object.min[axis], object.max[axis]].map(|x| column[k] * f64::from(x));
            low += ends[0].min(ends[1]);
            high += ends[0].max(ends[1]);
            size += ends[0].abs().max(ends[1].abs());
        }
        let slack = size * f64::from(f32::EPSILON);
        bounds.min[k] = (low - slack) as f32;
        bounds.max[k] = (high + slack) as f32;
    }
    bounds.min.iter().chain(&bounds.max).all(|x| x.is_finite()).then_some(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn carries_rays() {
        // Scaled by 2 along x, turned a quarter around z, then moved far away.
        let columns = [[0.0, 2.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1e6 + 0.125, 0.3, -7.0]];
        let map = ObjectFromWorld::inverse_of(&columns).expect("invertible");
        let world = Ray::new([1e6 - 1.0, 4.0, -7.0], [0.0, 2.0, 0.0]);
        let object = map.ray(&world);
        assert_eq!(object.dir, [1.0, 0.0, 0.0], "world y is object x, scaled");
        let error = (object.org[0] - 1.85).abs() + (object.org[1] - 1.125).abs() + object.org[2].abs();
        assert!(error < 1e-6, "{:?} is relative to the object's place", object.org);
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
