// SPDX-License-Identifier: GPL-3.0-or-later
//! Lambertian reflectors: alike from everywhere, on both sides.
//! Source: [Lam60]; references/README point 2. Proof: crates/render/tests/lights.rs (closed forms, furnace).

use crate::batch::{Detail, SurfaceBatch, Vec3s};
use crate::bsdf::{Model, Scattering};
use crate::materials::color::{PlainColor, TexturedColor};
use crate::materials::lambertian::Lambertian;
use crate::materials::whitted;
use crate::shader::{SurfaceShader, Tracer};

/// A Lambertian reflector.
#[derive(Clone, Debug)]
pub struct Matte {
    /// Share of light that is scattered.
    pub albedo: TexturedColor,
}

impl SurfaceShader for Matte {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        whitted::shade(tracer, hits, self, out);
    }

    fn scatter(&self, hits: &SurfaceBatch, out: &mut Vec<Scattering>) -> bool {
        let lambert = |i| Model::Lambert { albedo: self.albedo.at_hit(hits, i) };
        out.extend((0..hits.len()).map(|i| Scattering::new(hits, i, lambert(i))));
        true
    }

    fn lambertian(&self) -> Option<Lambertian> {
        Some(Lambertian { albedo: self.albedo.clone(), emission: None })
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.albedo.at_hit(hits, i)));
    }

    fn albedo_detail(&self) -> Detail {
        Detail::Color
    }

    fn plain_albedo(&self) -> Option<PlainColor> {
        self.albedo.plain()
    }
}
