// SPDX-License-Identifier: GPL-3.0-or-later
//! A floor that only catches shadow: Lambert's reflector that shows what lies behind the scene where all light reaches it.
//! Source: [Deb98] section 6 (differences that things make to a known background); [Lam60].
//! Integrators that know `backdrop` may take the light that is missing from it in place of the light that arrives: no noise where
//! nothing is missing. Others see a Lambertian reflector, and the same on average. Proof: crates/render/tests/shadow_catcher.rs.

use glam::Vec3;

use crate::batch::{Detail, SurfaceBatch, Vec3s};
use crate::bsdf::{Model, Scattering};
use crate::materials::color::PlainColor;
use crate::materials::whitted;
use crate::shader::{SurfaceShader, Tracer};

/// A floor that only catches shadow.
#[derive(Clone, Copy, Debug)]
pub struct ShadowCatcher {
    /// Share of light that is scattered.
    pub albedo: Vec3,
    /// What it shows where all light of the environment reaches it.
    pub radiance: Vec3,
}

impl SurfaceShader for ShadowCatcher {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        whitted::shade(tracer, hits, self, out);
    }

    fn scatter(&self, hits: &SurfaceBatch, out: &mut Vec<Scattering>) -> bool {
        let model = Model::Lambert { albedo: self.albedo };
        out.extend((0..hits.len()).map(|i| Scattering::new(hits, i, model)));
        true
    }

    fn backdrop(&self) -> Option<Vec3> {
        Some(self.radiance)
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.albedo));
    }

    fn albedo_detail(&self) -> Detail {
        Detail::Color
    }

    fn plain_albedo(&self) -> Option<PlainColor> {
        Some(PlainColor { factor: self.albedo, tinted: false })
    }
}
