// SPDX-License-Identifier: GPL-3.0-or-later
//! Containment of points in closed meshes. The method: a ray's crossings, counted without rounding
//! (`crossings.rs`), are even outside and odd inside. Space: world, or that of a directly queried object.
//! Invariant: no point is on the wrong side, at any distance from the surface, with any vertices and edges
//! along the ray.
//! Tests: `tests/surfaces/inside.rs`.

use crate::Query;
use crate::crossings::Crossed;
use crate::target::Target;
use gnurt_accel_core::exact::{Line, Triangle, side_of_sphere};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::Region;

/// Where a point lies with respect to closed surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// In none of them.
    Outside,
    /// On one of them, exactly, and in none.
    Surface,
    /// In one of them.
    Inside,
}

/// How far a ray leans from an axis, so that it seldom passes along faces, of which there are many along axes.
pub(crate) const LEAN: [f64; 2] = [0.037_109_375, 0.019_287_109_375];

/// The side of a point; NaN and infinite ones are outside.
pub(crate) fn side(target: Target, mask: u32, point: [f64; 3], crossed: &mut Crossed) -> Side {
    let bounds = target.around();
    let (low, high) = (bounds.min.map(f64::from), bounds.max.map(f64::from));
    // Not so of NaN.
    if !(0..3).all(|k| low[k] <= point[k] && point[k] <= high[k]) {
        return Side::Outside;
    }
    // The shortest distance outwards.
    let paths = [0, 1, 2].map(|k| [(high[k] - point[k], k, 1.0), (point[k] - low[k], k, -1.0)]);
    let shortest = paths.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, axis, line_path) = shortest.unwrap_or((0.0, 0, 1.0));
    let mut dir = [0.0; 3];
    (dir[axis], dir[(axis + 1) % 3], dir[(axis + 2) % 3]) = (line_path, LEAN[0], LEAN[1]);
    let line = Line::new(point, dir, 0.0, f64::INFINITY);
    crossed.clear();
    let (mut is_in_ball, mut on) = (false, Vec::new());
    target.show(&Region::line(&line), mask, &mut |surface| match &surface.primitive {
        Primitive::Triangle(corners) => {
            if line.starts_on(&Triangle::new(corners, surface.path)) {
                on.push(surface.slot);
            }
            crossed.take(&line, surface);
        }
        Primitive::Sphere(center, radius) => {
            let side = surface.line().map_or(1, |line| side_of_sphere(line.org, *center, *radius));
            is_in_ball |= side < 0;
            if side == 0 {
                on.push(surface.slot);
            }
        }
        Primitive::Curve(..) | Primitive::User(..) => crossed.take(&line, surface),
        // They enclose nothing.
        Primitive::Disc(..) => {}
    });
    crossed.finish();
    match (is_in_ball || is_in_an_object(crossed, &on), on.is_empty()) {
        (true, _) => Side::Inside,
        (false, false) => Side::Surface,
        (false, true) => Side::Outside,
    }
}

/// Whether the crossings of one of the objects are odd, except for objects that the ray starts on.
fn is_in_an_object(crossed: &mut Crossed, on: &[u32]) -> bool {
    let Crossed { triangles, others } = crossed;
    others.extend(triangles.iter().map(|&(slot, _)| (slot, 1)));
    others.sort_unstable();
    let is_odd = |object: &[(u32, u32)]| object.iter().map(|(_, n)| n).sum::<u32>() % 2 == 1;
    others.chunk_by(|a, b| a.0 == b.0).any(|object| !on.contains(&object[0].0) && is_odd(object))
}

impl Target<'_> {
    /// The distance to the nearest surface, negative inside.
    pub(crate) fn signed_distance(self, query: &Query, point: [f64; 3], crossed: &mut Crossed) -> f64 {
        if !point.iter().all(|x| x.is_finite()) {
            return f64::NAN;
        }
        let nearest = self.closest_point(query, point, f64::INFINITY);
        let distance = nearest.map_or(f64::INFINITY, |hit| hit.distance);
        match side(self, query.mask, point, crossed) {
            Side::Outside => distance,
            Side::Surface => 0.0,
            Side::Inside => -distance,
        }
    }
}
