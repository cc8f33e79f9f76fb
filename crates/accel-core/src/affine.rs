// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays carried into the space of an instance.
//! Source: original; two levels after [WBS03a]. Invariant: a tile's rays get the bits that each would get alone.
//! Proof: `scene::instance::tests::carries_rays` and `tests/instances.rs` of `gnurt-accel`.

use crate::ray::Ray;

/// `p_object = linear * (p_world - place)`.
#[derive(Clone, Copy, Debug)]
pub struct ObjectFromWorld {
    /// Rows of the linear part.
    pub rows: [[f32; 3]; 3],
    /// Where the object's origin is in the world: nearest floats, and what they leave over.
    pub place: [[f32; 3]; 2],
}

impl ObjectFromWorld {
    /// `ray` in the object's space; its parameters stay.
    #[inline(always)]
    pub fn ray(&self, ray: &Ray) -> Ray {
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
}
