// SPDX-License-Identifier: GPL-3.0-or-later
//! Lambertian reflectors: alike from everywhere, on both sides.
//! Source: [Lam60]; references/README point 2. Tests: crates/render/tests/lights.rs (closed forms, furnace).

use crate::batch::{SurfaceBatch, Vec3s};
use crate::bsdf::ClosureBatch;
use crate::materials::color::TexturedColor;
use crate::shader::SurfaceShader;

/// A Lambertian reflector.
#[derive(Clone, Debug)]
pub struct Matte {
    /// Share of light that is scattered.
    pub albedo: TexturedColor,
}

impl SurfaceShader for Matte {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        out.set_lambertian(hits, |i| self.albedo.at_hit(hits, i));
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.albedo.at_hit(hits, i)));
    }
}
