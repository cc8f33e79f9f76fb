// SPDX-License-Identifier: GPL-3.0-or-later
//! The nearest point of a surface to a given point.
//! Source: original; what Embree's point queries and parry's point projections are used for.
//! Spaces: distances are measured in the space of the tree that is asked. Inside of an instance a [`Probe`] carries the
//! linear map to that space along, so that turned, scaled and sheared instances are all exact; trees are searched in
//! their own space, by the least factor that lengths grow with.
//! Invariant: all arithmetic that decides is in double precision; floats only skip what is surely farther. So every
//! level and structure gives the same answer. Proof: `tests/closest_point.rs`.

mod probe;
mod shapes;

pub use probe::Probe;
pub use shapes::{on_sphere, on_triangle};

use crate::hit::{Hit, INVALID_ID};
use crate::nearest::Nearest;

/// The point of a surface that is nearest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// How far away it is.
    pub distance: f64,
    /// Where it is, in the space of the tree that was asked.
    pub point: [f64; 3],
    /// First parameter on the primitive; see [`Hit`].
    pub u: f32,
    /// Second parameter on the primitive.
    pub v: f32,
    /// Primitive within its geometry, counted from 0.
    pub prim_id: u32,
    /// Geometry within its object, counted from 0.
    pub geom_id: u32,
    /// Instance within the scene that was asked; 0 where an object's tree is asked directly.
    pub inst_id: u32,
    /// See [`Hit::leaf_id`].
    pub leaf_id: u32,
}

/// The nearest point so far.
#[derive(Clone, Copy, Debug)]
pub struct NearestPoint {
    /// Nothing farther counts.
    pub distance: f64,
    /// From the given point to the nearest, in the space of the tree that was asked.
    offset: [f64; 3],
    uv: [f64; 2],
    number: u32,
    slot: u32,
}

impl NearestPoint {
    pub fn within(radius: f64) -> Self {
        Self { distance: radius, offset: [0.0; 3], uv: [0.0; 2], number: INVALID_ID, slot: INVALID_ID }
    }

    /// Takes a point if it is nearer, or as near and of a lower primitive.
    pub fn offer(&mut self, offset: [f64; 3], uv: [f64; 2], number: u32, slot: u32) {
        let distance = offset.iter().map(|x| x * x).sum::<f64>().sqrt();
        let lower = || distance == self.distance && (slot, number) < (self.slot, self.number);
        if distance < self.distance || lower() {
            *self = Self { distance, offset, uv, number, slot };
        }
    }

    /// What was found near `point`; `resolve` tells the ids.
    pub fn hit(&self, point: [f64; 3], resolve: impl FnOnce(&Nearest) -> Hit) -> Option<PointHit> {
        if self.number == INVALID_ID {
            return None;
        }
        let [u, v] = self.uv.map(|x| x as f32);
        let Hit { u, v, prim_id, geom_id, inst_id, leaf_id, .. } =
            resolve(&Nearest { t: 0.0, u, v, number: self.number, slot: self.slot });
        let point = [0, 1, 2].map(|k| point[k] + self.offset[k]);
        Some(PointHit { distance: self.distance, point, u, v, prim_id, geom_id, inst_id, leaf_id })
    }
}
