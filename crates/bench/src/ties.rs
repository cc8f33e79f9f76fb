// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether a ray hits two triangles at the same point, so that either is a right result: at an edge that they
//! share, or where one lies on the other.
//! Source: the test of \[MT97\], in double precision. Space: world; directions of any length.
//! Tests: `tests::neighbours_tie_and_others_do_not`.

use gnurt::accel::{Ray, Triangles};

/// The distance outside of a triangle, in weights of its corners, at which a ray may count as a hit: the
/// rounding of floats, for triangles seen edge on.
pub(crate) const BESIDE: f64 = 1e-3;

/// Relative difference of parameters that are the same.
const SAME: f64 = 1e-5;

/// Whether `a` and `b` are both met, up to rounding, and at one `t`.
pub(crate) fn is_tie(triangles: &Triangles, ray: &Ray, a: u32, b: u32) -> bool {
    let (Some(a), Some(b)) = (meet(triangles, ray, a), meet(triangles, ray, b)) else { return false };
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

/// `t` of the triangle's plane, if the ray meets that in the triangle or just outside of it.
pub(crate) fn meet(triangles: &Triangles, ray: &Ray, prim_id: u32) -> Option<f64> {
    let corners = triangles.indices.get(prim_id as usize)?.map(|i| triangles.positions.get(i as usize));
    let [Some(a), Some(b), Some(c)] = corners else { return None };
    let minus = |p: &[f32; 3], q: &[f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(q[k]));
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let (ab, ac, from) = (minus(b, a), minus(c, a), minus(&ray.org, a));
    let dir = ray.dir.map(f64::from);
    let across = cross(dir, ac);
    let volume = dot(ab, across);
    let around = cross(from, ab);
    let (u, v, t) = (dot(from, across) / volume, dot(dir, around) / volume, dot(ac, around) / volume);
    // Not so of NaN: a ray in the plane meets nothing.
    (u >= -BESIDE && v >= -BESIDE && u + v <= 1.0 + BESIDE && t.is_finite()).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_tie_and_others_do_not() {
        let positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.], [0., 0., 1.], [1., 0., 1.]];
        let indices = [[0, 1, 2], [1, 3, 2], [0, 1, 2], [0, 1, 5], [7, 8, 9]];
        let triangles = Triangles { positions: &positions, indices: &indices };
        let ray = Ray::new([0.5, 0.5, 3.0], [0.0, 0.0, -1.0]);
        assert!(is_tie(&triangles, &ray, 0, 1), "on the edge of both");
        let inside = Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -1.0]);
        assert!(is_tie(&triangles, &inside, 0, 2), "one lies on the other");
        assert!(!is_tie(&triangles, &inside, 0, 1), "the neighbour is not met there");
        assert!(
            !is_tie(&triangles, &inside, 0, 3) && !is_tie(&triangles, &inside, 0, 4),
            "edge on; no such corners"
        );
        assert!(!is_tie(&triangles, &inside, 0, 77), "no such triangle");
    }
}
