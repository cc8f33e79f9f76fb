// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays carried into the space of an instance.
//! Source: two levels after [WBS03a]. Invariant: a tile's rays get the same bits as single rays.
//! Tests: `scene::instance::tests::carries_rays` and `tests/instances.rs` of `gnurt-accel`.

use crate::ray::Ray;

/// Rows of the inverse of a map's linear part, given the images of the axes, then of the origin; `None` where there is none.
#[inline]
#[must_use]
pub fn inverse(columns: &[[f64; 3]; 4]) -> Option<[[f64; 3]; 3]> {
    // Written out for speed: rays through moving instances come here.
    let [a, b, c, _] = *columns;
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let (x, y, z) = (cross(b, c), cross(c, a), cross(a, b));
    let determinant = a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
    if determinant == 0.0 {
        return None;
    }
    let over = |n: [f64; 3]| [n[0] / determinant, n[1] / determinant, n[2] / determinant];
    Some([over(x), over(y), over(z)])
}

/// `p_object = linear * (p_world - translation)`.
#[derive(Clone, Copy, Debug)]
pub struct ObjectFromWorld {
    /// Rows of the linear part.
    pub rows: [[f32; 3]; 3],
    /// The object's origin in the world: nearest floats, and the remainders.
    pub translation: [[f32; 3]; 2],
}

impl ObjectFromWorld {
    /// `ray` in the object's space; its parameters stay.
    #[inline(always)]
    pub fn ray(&self, ray: &Ray) -> Ray {
        let [high, low] = self.translation;
        let from = |k: usize| (ray.org[k] - high[k]) - low[k];
        let from = [from(0), from(1), from(2)];
        Ray { org: self.vector(from), dir: self.vector(ray.dir), ..*ray }
    }

    #[inline(always)]
    fn vector(&self, v: [f32; 3]) -> [f32; 3] {
        let along = |r: &[f32; 3]| r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
        [along(&self.rows[0]), along(&self.rows[1]), along(&self.rows[2])]
    }
}
