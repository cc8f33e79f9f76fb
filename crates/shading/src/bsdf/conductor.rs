// SPDX-License-Identifier: GPL-3.0-or-later
//! Rough metals: GGX facets that mirror, with all bounces between them.
//! Source: [WMLT07] (GGX), [Hei14] (height-correlated shadowing), [DB23] (sampling), [KC17] (further bounces).
//! Space: the shading frame. Proof: `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::energy::Energy;
use super::ggx::Ggx;
use super::{BsdfSample, fresnel};
use crate::sampling::cosine_hemisphere;

/// What the facets of a metal mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reflectance {
    /// Schlick's approximation.
    Schlick {
        /// At normal incidence, in [0, 1].
        f0: Vec3,
    },
    /// Fresnel's equations.
    Index {
        /// Index of refraction per channel, > 0.
        eta: Vec3,
        /// Extinction coefficient per channel, >= 0.
        k: Vec3,
    },
}

/// A rough metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    ggx: Ggx,
    reflectance: Reflectance,
    /// Reflectance averaged over all angles.
    average: Vec3,
}

impl Conductor {
    /// `alpha` is the width of the facets' slopes, in (0, 1]: the square of glTF's roughness.
    #[must_use]
    pub fn new(alpha: f32, reflectance: Reflectance) -> Self {
        let average = match reflectance {
            Reflectance::Schlick { f0 } => fresnel::schlick_average(f0, 1.0),
            Reflectance::Index { eta, k } => {
                const N: usize = 16;
                let middle = |i: usize| (i as f32 + 0.5) / N as f32;
                (0..N).map(|i| fresnel::conductor(middle(i), eta, k) * (2.0 * middle(i) / N as f32)).sum()
            }
        };
        Self { ggx: Ggx::from_alpha(alpha), reflectance, average: average.clamp(Vec3::ZERO, Vec3::ONE) }
    }

    /// Width of the facets' slopes.
    pub(super) fn alpha(&self) -> f32 {
        self.ggx.alpha()
    }

    fn fresnel(&self, cos: f32) -> Vec3 {
        match self.reflectance {
            Reflectance::Schlick { f0 } => f0 + (Vec3::ONE - f0) * fresnel::schlick_rise(cos),
            Reflectance::Index { eta, k } => fresnel::conductor(cos, eta, k),
        }
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if wi.z <= 0.0 {
            return Vec3::ZERO;
        }
        let (h, energy) = ((wo + wi).normalize_or(Vec3::Z), Energy::of(self.ggx));
        self.fresnel(wo.dot(h)) * self.ggx.lobe_cos(wo, wi, h)
            + energy.more(self.average) * energy.more_cos(wo.z, wi.z)
    }

    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z <= 0.0 {
            return 0.0;
        }
        let (h, more) = ((wo + wi).normalize_or(Vec3::Z), self.share_of_more(wo));
        (1.0 - more) * self.ggx.mirrored_pdf(wo, h) + more * FRAC_1_PI * wi.z
    }

    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let wi = if u[0] < self.share_of_more(wo) {
            cosine_hemisphere([u[1], u[2]])
        } else {
            (-wo).reflect(self.ggx.sample_visible(wo, [u[1], u[2]]))
        };
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.eval(wo, wi) / pdf,
            pdf,
            delta: false,
            transmitted: false,
        })
    }

    pub(super) fn albedo(&self, wo: Vec3) -> Vec3 {
        let energy = Energy::of(self.ggx);
        let white = energy.white(wo.z);
        let once = match self.reflectance {
            Reflectance::Schlick { f0 } => energy.once(wo.z, f0, 1.0),
            Reflectance::Index { .. } => self.fresnel(wo.z).lerp(self.average, 1.0 - white) * white,
        };
        once + energy.more(self.average) * (1.0 - white)
    }

    /// Probability with which directions are drawn from the lobe of further bounces.
    fn share_of_more(&self, wo: Vec3) -> f32 {
        let energy = Energy::of(self.ggx);
        let white = energy.white(wo.z);
        let more = (1.0 - white) * energy.more(self.average).max_element();
        more / (more + white * self.average.max_element()).max(f32::MIN_POSITIVE)
    }
}
