// SPDX-License-Identifier: GPL-3.0-or-later
//! The GGX microfacet distribution: density of facets, shadowing, sampling of the visible ones.
//! Source: [WMLT07] (GGX), [Hei14] (height-correlated Smith shadowing), [DB23] (sampling by spherical caps).
//! Space: local, z = the shading normal; `wo` towards the viewer, `wi` towards the light, `h` between them, all unit.
//! Proof: `tests::{facets_cover_the_ground, samples_match_the_lobe}`.

use std::f32::consts::{PI, TAU};
use std::iter::Sum;
use std::ops::{Div, Mul};

use glam::Vec3;

/// Below this the lobe is a mirror's for a float, and its peak would overflow.
const SMALLEST_ALPHA: f32 = 1e-3;

/// Facets of one roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ggx {
    alpha: f32,
}

impl Ggx {
    /// `roughness` is glTF's perceptual one; alpha is its square.
    pub(crate) fn new(roughness: f32) -> Self {
        Self::from_alpha(roughness * roughness)
    }

    /// Facets whose slopes have the width `alpha`.
    pub(crate) fn from_alpha(alpha: f32) -> Self {
        Self { alpha: alpha.clamp(SMALLEST_ALPHA, 1.0) }
    }

    /// Width of the slopes, in [1e-3, 1].
    pub(crate) fn alpha(self) -> f32 {
        self.alpha
    }

    /// Facets facing `h` per solid angle and ground area.
    pub(crate) fn density(self, h: Vec3) -> f32 {
        if h.z <= 0.0 {
            return 0.0;
        }
        let a2 = self.alpha * self.alpha;
        let sin2 = h.x * h.x + h.y * h.y;
        // cos² (a² - 1) + 1, written so that nothing cancels near the normal.
        let d = h.z * h.z * a2 + sin2;
        a2 / (PI * d * d)
    }

    /// Smith's auxiliary function: area of hidden facets over that of visible ones.
    fn lambda(self, w: Vec3) -> f32 {
        let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }

    /// Share of facets that neither the viewer nor the light loses behind others.
    pub(crate) fn visible_from_both(self, wo: Vec3, wi: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(wo) + self.lambda(wi))
    }

    /// Share of facets that the viewer sees.
    pub(crate) fn visible_from(self, w: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// The lobe without Fresnel's factor, times the cosine of `wi`.
    pub(crate) fn lobe_cos(self, wo: Vec3, wi: Vec3, h: Vec3) -> f32 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        self.density(h) * self.visible_from_both(wo, wi) / (4.0 * wo.z)
    }

    /// A facet that the viewer sees, in proportion to its share of the view.
    pub(crate) fn sample_visible(self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(wo.x * self.alpha, wo.y * self.alpha, wo.z).normalize();
        let azimuth = TAU * u[0];
        let z = (1.0 - u[1]) * (1.0 + stretched.z) - stretched.z;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let cap = Vec3::new(radius * azimuth.cos(), radius * azimuth.sin(), z);
        let h = cap + stretched;
        Vec3::new(h.x * self.alpha, h.y * self.alpha, h.z.max(1e-7)).normalize()
    }

    /// The mean of `f` over the facets that a viewer at `wo` sees, each by its share of the view; `wo` has no y, so that
    /// both halves of the facets are alike. For tables: strata are narrow towards the facets that face away, few as they
    /// are, for what loses light lies there.
    pub(super) fn mean_visible<T>(self, wo: Vec3, f: impl Fn(Vec3) -> T) -> T
    where
        T: Sum + Mul<f32, Output = T> + Div<f32, Output = T>,
    {
        const AZIMUTHS: usize = 16;
        const STEPS: usize = 32;
        let strata = (0..AZIMUTHS).flat_map(|i| (0..STEPS).map(move |j| (i, j)));
        let values = strata.map(|(i, j)| {
            let left = 1.0 - (j as f32 + 0.5) / STEPS as f32;
            let u = [0.5 * (i as f32 + 0.5) / AZIMUTHS as f32, 1.0 - left * left];
            f(self.sample_visible(wo, u)) * (2.0 * left)
        });
        values.sum::<T>() / (AZIMUTHS * STEPS) as f32
    }

    /// Density per solid angle of `wi`, mirrored at a facet `h` that [`sample_visible`](Self::sample_visible) chose.
    pub(crate) fn mirrored_pdf(self, wo: Vec3, h: Vec3) -> f32 {
        self.density(h) * self.visible_from(wo) / (4.0 * wo.z)
    }

    /// What a light seen in the direction of a sampled facet counts: all but Fresnel's factor.
    pub(crate) fn sample_weight(self, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z <= 0.0 { 0.0 } else { self.visible_from_both(wo, wi) / self.visible_from(wo) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::sample_pair;

    /// Midpoint rule over the upper hemisphere.
    fn integrate(f: impl Fn(Vec3) -> f64) -> f64 {
        let (rings, sectors) = (2000, 400);
        let mut sum = 0.0;
        for ring in 0..rings {
            // Squares put most rings near the normal, where narrow lobes are.
            let [a, b] =
                [ring, ring + 1].map(|k| (k as f64 / f64::from(rings)).powi(2) * std::f64::consts::FRAC_PI_2);
            let middle = 0.5 * (a + b);
            for sector in 0..sectors {
                let azimuth = std::f64::consts::TAU * (f64::from(sector) + 0.5) / f64::from(sectors);
                let w = glam::DVec3::new(
                    middle.sin() * azimuth.cos(),
                    middle.sin() * azimuth.sin(),
                    middle.cos(),
                );
                sum += f(w.as_vec3()) * (a.cos() - b.cos()) * std::f64::consts::TAU / f64::from(sectors);
            }
        }
        sum
    }

    #[test]
    fn facets_cover_the_ground() {
        for roughness in [0.2, 0.5, 1.0] {
            let ggx = Ggx::new(roughness);
            let ground = integrate(|h| f64::from(ggx.density(h) * h.z));
            assert!((ground - 1.0).abs() < 2e-3, "roughness {roughness}: projected area {ground}");
        }
    }

    /// The mean of weights over samples is the lobe's integral; and so are moments of the direction.
    #[test]
    fn samples_match_the_lobe() {
        for (roughness, angle) in [(0.3, 0.5_f32), (0.6, 1.2), (1.0, 0.9)] {
            let ggx = Ggx::new(roughness);
            let wo = Vec3::new(angle.sin(), 0.0, angle.cos());
            const N: u32 = 1 << 14;
            let mut sampled = [0.0_f64; 3];
            for sample in 0..N {
                let u = sample_pair(0, SampleKey { pixel: 1, sample, branch: 0 }, 0, 0);
                let wi = (-wo).reflect(ggx.sample_visible(wo, u));
                let weight = f64::from(ggx.sample_weight(wo, wi)) / f64::from(N);
                for (sum, moment) in sampled.iter_mut().zip([1.0, wi.x, wi.z]) {
                    *sum += weight * f64::from(moment);
                }
            }
            let lobe = |wi: Vec3| f64::from(ggx.lobe_cos(wo, wi, (wo + wi).normalize()));
            let moments: [fn(Vec3) -> f32; 3] = [|_| 1.0, |w| w.x, |w| w.z];
            for (sampled, moment) in sampled.iter().zip(moments) {
                let wanted = integrate(|wi| lobe(wi) * f64::from(moment(wi)));
                assert!((sampled - wanted).abs() < 4e-3, "roughness {roughness}: {sampled}, lobe {wanted}");
            }
            assert!(sampled[0] <= 1.0, "no energy is made");
        }
    }
}
