// SPDX-License-Identifier: GPL-3.0-or-later
//! Smooth glass.
//! Source: see `bsdf/dielectric.rs`.
//! Differs: shadow rays of Whitted's renderer go straight through with the share that is not mirrored, as if the glass
//! were thin, so that windows let light in; there are no caustics.
//! Tests: crates/render/tests/mirrors.rs.

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::bsdf::{Bsdf, ClosureBatch, Lobe, Medium, fresnel};
use crate::shader::{SurfaceShader, Tracer};

/// Smooth glass; the geometric normal points out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction inside over outside, > 0.
    pub ior: f32,
    /// Tint of reflection.
    pub reflectance: Vec3,
    /// Tint of transmission.
    pub transmittance: Vec3,
    /// Absorption coefficient within, 1 over world units, >= 0.
    pub absorption: Vec3,
    /// How much greater the index is for blue-green light (486.1 nm) than for red (656.3 nm), >= 0.
    pub spread: f32,
}

/// Transmittance of this absorption for light that comes straight to lane `i` from within.
pub(super) fn inside(hits: &SurfaceBatch, i: usize, absorption: Vec3) -> Vec3 {
    if hits.front(i) || absorption == Vec3::ZERO { Vec3::ONE } else { (-absorption * hits.t[i]).exp() }
}

impl SurfaceShader for Dielectric {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            let eta = if hits.front(i) { 1.0 / self.ior } else { self.ior };
            let lobes = Lobe::glass(eta, self.reflectance, self.transmittance, false).dispersed(self.spread);
            let (point, wo) = (hits.point(i), -hits.ray_dir.get(i));
            let bent = point.bent_normal(hits.facing_ns(i), wo);
            let [_, through] = Bsdf::new(bent, lobes).delta_branches(wo);
            let leads_in = through.is_none_or(|s| point.scatter_ray(s.wi, true, f32::INFINITY).is_some());
            out.set(i, if leads_in { bent } else { point.ng }, &[lobes]);
            if self.has_medium() {
                out.fill(i, Medium::behind(self.absorption, hits.front(i)));
            }
        }
    }

    fn has_medium(&self) -> bool {
        self.absorption != Vec3::ZERO
    }

    fn transmit(&self, _tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        for i in 0..hits.len() {
            let cos = hits.ray_dir.get(i).dot(hits.facing_ng(i)).abs();
            // Straight on, so the share is that of the denser side's outside wherever one is.
            let share = fresnel::dielectric(cos, (1.0 / self.ior).min(self.ior));
            out.set(i, self.transmittance * inside(hits, i, self.absorption) * (1.0 - share));
        }
    }

    fn is_opaque(&self) -> bool {
        self.transmittance == Vec3::ZERO
    }

    fn is_solid(&self) -> bool {
        true
    }

    fn albedo(&self, _hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..out.len()).for_each(|i| out.set(i, self.transmittance.max(self.reflectance)));
    }
}
