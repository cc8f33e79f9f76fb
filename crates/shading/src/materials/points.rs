// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces defined by a function from a hit to its scattering: most models need no more.
//! Tests: `tests` of `bsdf`.

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::bsdf::{Bsdf, ClosureBatch, Kind, Lobe, Medium};
use crate::materials::color::TexturedColor;
use crate::shader::SurfaceShader;

/// A surface whose points scatter by the function, for a lane of a batch.
#[derive(Clone)]
pub struct FromPoints<F>(pub F);

impl<F: Fn(&SurfaceBatch, usize) -> Bsdf + Send + Sync> SurfaceShader for FromPoints<F> {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            let bsdf = (self.0)(hits, i);
            out.set(i, bsdf.normal(), bsdf.lobes().as_slice());
        }
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, (self.0)(hits, i).albedo(-hits.ray_dir.get(i))));
    }
}

/// A rough diffuse surface; `roughness` is in [0, 1].
#[must_use]
pub fn rough_matte(albedo: TexturedColor, roughness: f32) -> impl SurfaceShader {
    FromPoints(move |hits: &SurfaceBatch, i| {
        let albedo = albedo.at_hit(hits, i).clamp(Vec3::ZERO, Vec3::ONE);
        Bsdf::new(hits.facing_ns(i), Lobe::oren_nayar(albedo, roughness))
    })
}

/// A metal by its complex index of refraction; `roughness` is glTF's, in [0, 1].
#[must_use]
pub fn metal(eta: Vec3, k: Vec3, roughness: f32) -> impl SurfaceShader {
    let metal = Lobe::metal(roughness * roughness, eta, k);
    FromPoints(move |hits: &SurfaceBatch, i| shiny(hits, i, hits.facing_ns(i), metal))
}

/// Rough glass; the geometric normal points out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughGlass {
    front: Lobe,
    back: Lobe,
    absorption: Vec3,
}

impl RoughGlass {
    /// Glass of index `ior`, a pane if `thin`; `roughness` is glTF's, in [0, 1]; tints are those of
    /// reflection and transmission.
    #[must_use]
    pub fn new(ior: f32, roughness: f32, [reflectance, transmittance]: [Vec3; 2], thin: bool) -> Self {
        let side = |eta| Lobe::rough_glass(roughness * roughness, eta, reflectance, transmittance, thin);
        Self { front: side(1.0 / ior), back: side(ior), absorption: Vec3::ZERO }
    }

    /// The same with an inside, if it is no pane: with this absorption coefficient (1 over world units), and
    /// an index that is greater by `spread` for blue-green light than for red.
    #[must_use]
    pub fn with_inside(self, absorption: Vec3, spread: f32) -> Self {
        let absorption = if self.front.kind == Kind::Pane { Vec3::ZERO } else { absorption };
        Self { front: self.front.dispersed(spread), back: self.back.dispersed(spread), absorption }
    }
}

impl SurfaceShader for RoughGlass {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            let front = hits.front(i);
            let bsdf = shiny(hits, i, hits.facing_ns(i), if front { self.front } else { self.back });
            out.set(i, bsdf.normal(), bsdf.lobes().as_slice());
            if self.has_medium() {
                out.fill(i, Medium::behind(self.absorption, front));
            }
        }
    }

    fn has_medium(&self) -> bool {
        self.absorption != Vec3::ZERO
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        for i in 0..hits.len() {
            let lobe = if hits.front(i) { self.front } else { self.back };
            out.set(i, shiny(hits, i, hits.facing_ns(i), lobe).albedo(-hits.ray_dir.get(i)));
        }
    }
}

/// A lane that scatters around the normal `ns`, bent so that mirror images stay above.
fn shiny(hits: &SurfaceBatch, i: usize, ns: Vec3, lobe: Lobe) -> Bsdf {
    let ns = hits.point(i).bent_normal(ns, -hits.ray_dir.get(i));
    Bsdf::new(ns, lobe)
}
