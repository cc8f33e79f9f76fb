// SPDX-License-Identifier: GPL-3.0-or-later
//! A shadow catcher: Lambert's reflector that shows the background where all light of the environment reaches
//! it.
//! Source: [Deb98] section 6 (differences between a known background with and without objects); [Lam60].
//! Integrators that use `backdrop` may subtract the missing light from it instead of adding the arriving
//! light: no noise where nothing is missing. Others see a Lambertian reflector, and the same on average.
//! Tests: crates/render/tests/shadow_catcher.rs.

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::bsdf::{ClosureBatch, Lobe};
use crate::shader::SurfaceShader;

/// A floor that only catches shadow.
#[derive(Clone, Copy, Debug)]
pub struct ShadowCatcher {
    /// Share of light that is scattered.
    pub albedo: Vec3,
    /// Its radiance where all light of the environment reaches it.
    pub radiance: Vec3,
}

impl SurfaceShader for ShadowCatcher {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        let lobes = [Lobe::lambert(self.albedo)];
        (0..hits.len()).for_each(|i| out.set(i, hits.facing_ns(i), &lobes));
    }

    fn backdrop(&self) -> Option<Vec3> {
        Some(self.radiance)
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.albedo));
    }
}
