// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces that are given by a function from a hit to its scattering: what most models need and no more.
//! Source: original. Proof: `tests` of `bsdf`.

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::bsdf::{Conductor, Lobe, Model, Reflectance, RoughDielectric, Scattering};
use crate::materials::color::TexturedColor;
use crate::materials::whitted;
use crate::shader::{SurfaceShader, Tracer};

/// A surface whose points scatter as the function says for a lane of a batch.
#[derive(Clone)]
pub struct FromPoints<F>(pub F);

impl<F: Fn(&SurfaceBatch, usize) -> Scattering + Send + Sync> SurfaceShader for FromPoints<F> {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        whitted::shade(tracer, hits, self, out);
    }

    fn scatter(&self, hits: &SurfaceBatch, out: &mut Vec<Scattering>) -> bool {
        out.extend((0..hits.len()).map(|i| (self.0)(hits, i)));
        true
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, (self.0)(hits, i).bsdf.albedo(-hits.ray_dir.get(i))));
    }
}

/// A rough diffuse surface; `roughness` is in [0, 1].
#[must_use]
pub fn rough_matte(albedo: TexturedColor, roughness: f32) -> impl SurfaceShader {
    FromPoints(move |hits: &SurfaceBatch, i| {
        let albedo = albedo.at_hit(hits, i).clamp(Vec3::ZERO, Vec3::ONE);
        Scattering::new(hits, i, Model::Lobe(Lobe::OrenNayar { albedo, roughness }))
    })
}

/// A metal by its complex index of refraction; `roughness` is glTF's, in [0, 1].
#[must_use]
pub fn metal(eta: Vec3, k: Vec3, roughness: f32) -> impl SurfaceShader {
    let metal = Conductor::new(roughness * roughness, Reflectance::Index { eta, k });
    FromPoints(move |hits: &SurfaceBatch, i| shiny(hits, i, hits.facing_ns(i), Lobe::Conductor(metal)))
}

/// Rough glass of index `ior`, a pane if `thin`; `roughness` is glTF's, in [0, 1].
#[must_use]
pub fn rough_glass(
    ior: f32,
    roughness: f32,
    reflectance: Vec3,
    transmittance: Vec3,
    thin: bool,
) -> impl SurfaceShader {
    let side = |eta| RoughDielectric::new(roughness * roughness, eta, reflectance, transmittance, thin);
    let (front, back) = (side(1.0 / ior), side(ior));
    FromPoints(move |hits: &SurfaceBatch, i| {
        let glass = if hits.front(i) { front } else { back };
        shiny(hits, i, hits.facing_ns(i), Lobe::RoughDielectric(glass))
    })
}

/// A lane that scatters around the normal `ns`, bent so that mirror images stay above.
fn shiny(hits: &SurfaceBatch, i: usize, ns: Vec3, lobe: Lobe) -> Scattering {
    let ns = hits.point(i).bent_normal(ns, -hits.ray_dir.get(i));
    Scattering::around(ns, Model::Lobe(lobe))
}
