// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a ray goes through a sphere. Source: [HGA19]. Space: object. Tests: `tests/mixed.rs` of `gnurt-accel`.

use crate::ray::Ray;

/// Both parameters of the hits of a ray with a sphere, ascending: roots of `a t^2 + 2 b t + c`, the one
/// farther from zero first. In double precision: a float loses the distance from the surface of a huge
/// sphere, and few spheres come here.
#[must_use]
#[inline(always)]
pub fn through_sphere(ray: &Ray, center: [f32; 3], radius: f32) -> [f32; 2] {
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let from = |k: usize| f64::from(ray.org[k]) - f64::from(center[k]);
    let (from, dir, r) = ([from(0), from(1), from(2)], ray.dir.map(f64::from), f64::from(radius));
    let (a, b, c) = (dot(dir, dir), dot(from, dir), dot(from, from) - r * r);
    let across = [0, 1, 2].map(|k| from[k] - b / a * dir[k]);
    let root = (a * (r * r - dot(across, across)).max(0.0)).sqrt();
    let q = if b < 0.0 { root - b } else { -root - b };
    // 0 / 0, where a ray starts on the sphere and along it, is no number; the other root is zero, too.
    let (one, two) = ((c / q) as f32, (q / a) as f32);
    [one.min(two), one.max(two)]
}
