// SPDX-License-Identifier: GPL-3.0-or-later
//! The nearest point of a surface to a given point.
//! The purpose of Embree's point queries and parry's point projections. Spaces: distances are measured in the
//! space of the queried tree. Inside of an instance a [`Probe`] carries the linear map to that space, so that
//! rotated, scaled and sheared instances are all exact; trees are searched in their own space, with the least
//! factor by which lengths grow.
//! Invariant: all decisive arithmetic is in double precision; floats only skip primitives that are surely
//! farther. So every level and structure gives the same answer. Tests: `tests/closest_point.rs`.

mod disc;
mod probe;
mod shapes;
mod sphere;

pub use disc::{on_disc, through_disc};
pub use probe::Probe;
pub use shapes::{on_sphere, on_triangle};
pub use sphere::through_sphere;

use crate::hit::Hit;
use crate::nearest::Nearest;

/// The point of a surface that is nearest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// How far away it is.
    pub distance: f64,
    /// Its position, in the space of the queried tree.
    pub point: [f64; 3],
    /// First parameter on the primitive; see [`Hit`].
    pub u: f32,
    /// Second parameter on the primitive.
    pub v: f32,
    /// Primitive within its geometry, counted from 0.
    pub prim_id: u32,
    /// Geometry within its object, counted from 0.
    pub geom_id: u32,
    /// Instance within the queried scene; 0 for a direct query of an object's tree.
    pub inst_id: u32,
    /// See [`Hit::leaf_id`].
    pub leaf_id: u32,
}

/// The state of a search for near points. Called through a pointer, so that trees are compiled once for all
/// of them.
pub trait NearestPoint {
    /// Nothing farther counts.
    fn distance(&self) -> f64;
    /// Takes a point of a primitive: the offset to it from the given one, in the space of the queried tree,
    /// and its parameters. The same primitive may come several times.
    fn offer(&mut self, offset: [f64; 3], uv: [f64; 2], number: u32, slot: u32);
}

/// A point of a primitive.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    pub distance: f64,
    pub offset: [f64; 3],
    pub uv: [f64; 2],
    pub number: u32,
    pub slot: u32,
}

impl Near {
    pub fn new(offset: [f64; 3], uv: [f64; 2], number: u32, slot: u32) -> Self {
        let distance = offset.iter().map(|x| x * x).sum::<f64>().sqrt();
        Self { distance, offset, uv, number, slot }
    }

    /// The hit near `point`; `resolve` returns the ids.
    pub fn hit(&self, point: [f64; 3], resolve: impl FnOnce(&Nearest) -> Hit) -> PointHit {
        let [u, v] = self.uv.map(|x| x as f32);
        let Hit { u, v, prim_id, geom_id, inst_id, leaf_id, .. } =
            resolve(&Nearest { u, v, number: self.number, slot: self.slot, ..Nearest::none(0.0) });
        let point = [0, 1, 2].map(|k| point[k] + self.offset[k]);
        PointHit { distance: self.distance, point, u, v, prim_id, geom_id, inst_id, leaf_id }
    }
}

/// The nearest point so far.
#[derive(Clone, Copy, Debug)]
pub struct ClosestPoint {
    radius: f64,
    best: Option<Near>,
}

impl ClosestPoint {
    pub fn within(radius: f64) -> Self {
        Self { radius, best: None }
    }

    /// The hit near `point`; `resolve` returns the ids.
    pub fn hit(&self, point: [f64; 3], resolve: impl FnOnce(&Nearest) -> Hit) -> Option<PointHit> {
        self.best.map(|best| best.hit(point, resolve))
    }
}

impl NearestPoint for ClosestPoint {
    fn distance(&self) -> f64 {
        self.best.map_or(self.radius, |best| best.distance)
    }

    /// Takes a point if it is nearer, or as near and of a lower primitive.
    fn offer(&mut self, offset: [f64; 3], uv: [f64; 2], number: u32, slot: u32) {
        let near = Near::new(offset, uv, number, slot);
        let is_better = match &self.best {
            None => near.distance <= self.radius,
            Some(best) => (near.distance, slot, number) < (best.distance, best.slot, best.number),
        };
        if is_better {
            self.best = Some(near);
        }
    }
}
