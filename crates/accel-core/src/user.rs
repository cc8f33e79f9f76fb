// SPDX-License-Identifier: GPL-3.0-or-later
//! Geometry defined by the caller: boxes and a test per primitive. Embree's user geometry and OptiX's custom
//! primitives. Space: object.
//! Tests: `tests/mixed.rs`.

use std::fmt;

use crate::aabb::Aabb;
use crate::ray::Ray;

/// Where a ray meets a user primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UserHit {
    /// Ray parameter.
    pub t: f32,
    /// First parameter on the primitive, handed on to [`Hit::u`](crate::Hit::u).
    pub u: f32,
    /// Second parameter of the hit.
    pub v: f32,
}

/// Primitives with a test by the caller: curves, distance fields, points of a cloud.
///
/// Calls come from all threads that trace rays. Trees call it primitive by primitive, for those whose boxes a ray meets.
pub trait UserGeometry: Send + Sync + fmt::Debug {
    /// How many primitives there are; must not change.
    fn count(&self) -> u32;

    /// The box around primitive `prim_id`, object space; must not change. Empty or unsound boxes leave it out.
    fn bounds(&self, prim_id: u32) -> Aabb;

    /// How many times of an open shutter it has boxes for, evenly spaced from 0 to 1; must not change. Primitives of
    /// several keys move: between two keys, they stay in the interpolated box. [`Ray::time`] tells when a ray sees them.
    fn keys(&self) -> u32 {
        1
    }

    /// The box at a key; must not change.
    fn bounds_at(&self, prim_id: u32, key: u32) -> Aabb {
        let _ = key;
        self.bounds(prim_id)
    }

    /// Calls `hit` for where `ray` meets primitive `prim_id`, in any order.
    ///
    /// Hits outside of `[ray.t_near, ray.t_far]` are allowed and ignored; `t_far` is the best hit so far in a
    /// query for the closest one. `ray.dir` may be a multiple of the requested direction; the parameters are
    /// those of `ray`. NaN is ignored.
    fn intersect(&self, prim_id: u32, ray: &Ray, hit: &mut dyn FnMut(UserHit));

    /// The point of primitive `prim_id` that is nearest to `point`, object space. Primitives without an answer, which
    /// is the default, are not seen by closest point queries. Where instances are scaled differently along different
    /// axes, the answer is taken as it is, although another point may then be nearer in the world.
    fn closest_point(&self, prim_id: u32, point: [f32; 3]) -> Option<[f32; 3]> {
        let _ = (prim_id, point);
        None
    }

    /// The same at a time.
    fn closest_point_at(&self, prim_id: u32, point: [f32; 3], time: f32) -> Option<[f32; 3]> {
        let _ = time;
        self.closest_point(prim_id, point)
    }

    /// The normal of a hit at `point` and at a time, of any length, object space; `None` where there is none, which is the
    /// default.
    fn normal(&self, prim_id: u32, uv: [f32; 2], point: Option<[f64; 3]>, time: f32) -> Option<[f64; 3]> {
        let _ = (prim_id, uv, point, time);
        None
    }
}
