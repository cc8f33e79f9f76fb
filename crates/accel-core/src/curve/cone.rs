// SPDX-License-Identifier: GPL-3.0-or-later
//! A ray and the surface of all spheres between two: a cone with spheres at its ends. Source: [HWU*19], whose cone of
//! spheres this is; the surface is where the least of `|p - c(u)|^2 - r(u)^2` over the axis is zero.
//! Space: object. Invariant: without joints the surface is closed, and met an even number of times from outside.
//! Tests: `tests/curves.rs` of `gnurt-accel`.

use super::ray::{CurveHit, Offer, RayFrame};
use super::{Vector, along, dot, minus, place};

/// Spheres between two.
struct Spheres {
    start: Vector,
    radii: [f64; 2],
    axis: Vector,
    /// How much radii grow.
    growth: f64,
    /// Square of the length of the cone's side; not positive where one sphere holds the other.
    side: f64,
}

impl Spheres {
    fn new(from: [f64; 4], to: [f64; 4]) -> Self {
        let axis = minus(place(to), place(from));
        let growth = to[3] - from[3];
        let side = dot(axis, axis) - growth * growth;
        Self { start: place(from), radii: [from[3], to[3]], axis, growth, side }
    }

    /// The sphere that comes nearest to a point, or reaches farthest around it: not limited to the ends.
    fn nearest(&self, from_start: Vector) -> f64 {
        (dot(from_start, self.axis) + self.radii[0] * self.growth) / self.side
    }

    /// Whether a point is inside of one of them, by more than rounding.
    fn holds(&self, point: Vector) -> bool {
        let from = minus(point, self.start);
        let u = match self.side > 0.0 {
            true => self.nearest(from).clamp(0.0, 1.0),
            false => f64::from(self.growth > 0.0),
        };
        let radius = self.radii[0] + u * self.growth;
        let off = along(from, -u, self.axis);
        dot(off, off) < radius * radius * (1.0 - 1e-9)
    }
}

/// Both roots of `a t^2 + 2 b t + c`, where there are any.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let root = b * b - a * c;
    // Not so of NaN, and of a ray along a cylinder.
    if !(root >= 0.0 && a != 0.0) {
        return None;
    }
    let q = if b < 0.0 { root.sqrt() - b } else { -root.sqrt() - b };
    Some(if q == 0.0 { [0.0; 2] } else { [q / a, c / q] })
}

/// Offers the hits; none in the cones that it is joined to, or on the sphere at the start of a cone that goes on from another.
pub(super) fn meet(
    &[from, to]: &[[f64; 4]; 2],
    joints: [&Option<[f64; 4]>; 2],
    is_seen_from_outside: bool,
    ray: &RayFrame,
    hit: Offer,
) {
    let spheres = Spheres::new(from, to);
    let before = joints[0].map(|other| Spheres::new(other, from));
    let after = joints[1].map(|other| Spheres::new(to, other));
    // From a point that is near: squares of large coordinates would lose the radius.
    let dir = ray.axes[2];
    let middle = along(spheres.start, 0.5, spheres.axis);
    let start = dot(minus(middle, ray.org), dir);
    let org = along(ray.org, start, dir);
    let from_start = minus(org, spheres.start);
    let mut offer = |s: f64, u: f64| {
        let point = along(org, s, dir);
        let is_within = |other: &Option<Spheres>| other.as_ref().is_some_and(|other| other.holds(point));
        if is_within(&before) || is_within(&after) {
            return;
        }
        let out = minus(point, along(spheres.start, u, spheres.axis));
        if !(is_seen_from_outside && dot(out, dir) > 0.0) {
            hit(CurveHit { t: (start + s) / ray.length, u, v: 0.0 });
        }
    };
    let mut of_sphere = |u: f64, radius: f64, is_its: &dyn Fn(f64) -> bool| {
        let off = minus(org, along(spheres.start, u, spheres.axis));
        let found = roots(1.0, dot(off, dir), dot(off, off) - radius * radius);
        for s in found.into_iter().flatten() {
            if is_its(spheres.nearest(along(from_start, s, dir))) {
                offer(s, u);
            }
        }
    };
    if spheres.side <= 0.0 {
        // One holds the other.
        let u = f64::from(spheres.growth > 0.0);
        of_sphere(u, from[3].max(to[3]), &|_| true);
        return;
    }
    if before.is_none() {
        of_sphere(0.0, from[3], &|u| u < 0.0);
    }
    of_sphere(1.0, to[3], &|u| u > 1.0);
    let [q, e] = [dot(from_start, spheres.axis) + from[3] * spheres.growth, dot(dir, spheres.axis)];
    let a = 1.0 - e * e / spheres.side;
    let b = dot(from_start, dir) - q * e / spheres.side;
    let c = dot(from_start, from_start) - from[3] * from[3] - q * q / spheres.side;
    for s in roots(a, b, c).into_iter().flatten() {
        let u = (q + s * e) / spheres.side;
        // A point of the other half of the cone is on no sphere.
        if (0.0..=1.0).contains(&u) && from[3] + u * spheres.growth >= 0.0 {
            offer(s, u);
        }
    }
}
