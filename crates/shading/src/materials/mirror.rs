// SPDX-License-Identifier: GPL-3.0-or-later
//! Perfect mirrors, on both sides.
//! Source: [Whi80]. Tests: crates/render/tests/mirrors.rs.

use crate::batch::{SurfaceBatch, Vec3s};
use crate::bsdf::{ClosureBatch, Lobe};
use crate::materials::color::TexturedColor;
use crate::shader::SurfaceShader;

/// A perfect mirror.
#[derive(Clone, Debug)]
pub struct Mirror {
    /// Share of light that is mirrored.
    pub reflectance: TexturedColor,
}

impl SurfaceShader for Mirror {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            let ns = hits.point(i).bent_normal(hits.facing_ns(i), -hits.ray_dir.get(i));
            out.set(i, ns, &[Lobe::mirror(self.reflectance.at_hit(hits, i))]);
        }
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.reflectance.at_hit(hits, i)));
    }
}
