// SPDX-License-Identifier: GPL-3.0-or-later
//! The GGX microfacet distribution: density of microfacets, shadowing, sampling of the visible ones.
//! Source: [WMLT07] (GGX), [Hei14] (height-correlated Smith shadowing), [DB23] (sampling by spherical caps).
//! Directions are given by their cosines to the shading normal, so that no frame is needed; `sample_visible`
//! is in a frame with z = the shading normal.
//! Tests: `tests::{facets_cover_the_ground, samples_match_the_lobe}`.

use std::f32::consts::PI;
use std::iter::Sum;
use std::ops::{Div, Mul};

use glam::Vec3;

use crate::real::{Real, Vector};
use crate::sampling::sin_cos_of_fraction;

/// Below this the lobe is a mirror's for a float, and its peak would overflow.
pub(crate) const SMALLEST_ALPHA: f32 = 1e-3;

/// Microfacets of one roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ggx<R> {
    alpha: R,
}

impl<R: Real> Ggx<R> {
    /// Microfacets whose slopes have the width `alpha`.
    #[inline(always)]
    pub(crate) fn from_alpha(alpha: R) -> Self {
        Self { alpha: alpha.within(SMALLEST_ALPHA, 1.0) }
    }

    /// Width of the slopes, in [1e-3, 1].
    #[inline(always)]
    pub(crate) fn alpha(self) -> R {
        self.alpha
    }

    /// Density of microfacets facing `h` per solid angle and ground area, by its cosine and the square of its
    /// sine.
    #[inline(always)]
    pub(crate) fn density(self, cos: R, sin2: R) -> R {
        let a2 = self.alpha * self.alpha;
        // cos² (a² - 1) + 1, written so that nothing cancels near the normal.
        let d = cos * cos * a2 + sin2;
        let density = a2 / (d * d * PI);
        R::pick(cos.above_all(0.0), density, cos.all(0.0))
    }

    /// Smith's auxiliary function: area of hidden microfacets over that of visible ones.
    #[inline(always)]
    pub(crate) fn lambda(self, cos: R) -> R {
        let cos2 = cos * cos;
        let tan2 = cos2.rest().or_more(cos.all(0.0)) / cos2;
        ((cos.all(1.0) + self.alpha * self.alpha * tan2).root() - cos.all(1.0)) * 0.5
    }

    /// A visible microfacet, in proportion to its share of the view; along the second axis microfacets have
    /// the width `across`.
    #[inline(always)]
    pub(crate) fn sample_visible_across(self, across: R, wo: Vector<R>, u: [R; 2]) -> Vector<R> {
        let stretched = Vector::new(wo.x * self.alpha, wo.y * across, wo.z).normalize();
        let (sin, cos) = sin_cos_of_fraction(u[0]);
        let z = u[1].rest() * (stretched.z + wo.z.all(1.0)) - stretched.z;
        let radius = (z * z).rest().or_more(z.all(0.0)).root();
        let h = Vector::new(radius * cos, radius * sin, z) + stretched;
        Vector::new(h.x * self.alpha, h.y * across, h.z.or_more(h.z.all(1e-7))).normalize()
    }
}

impl Ggx<f32> {
    /// `roughness` is glTF's perceptual one; alpha is its square.
    pub(crate) fn new(roughness: f32) -> Self {
        Self::from_alpha(roughness * roughness)
    }

    /// Weight of light in the direction of a sampled microfacet, by the cosines: without Fresnel's factor.
    pub(crate) fn sample_weight(self, cos_o: f32, cos_i: f32) -> f32 {
        let hidden = self.lambda(cos_o);
        (1.0 + hidden) / (1.0 + hidden + self.lambda(cos_i))
    }

    /// The mean of `f` over the visible microfacets, for a viewer at `wo`, each by its share of the view;
    /// `wo` has no y, so that both halves are alike. For tables: strata are narrow towards the rare
    /// microfacets that face away, because the loss of light is there.
    pub(super) fn mean_visible<T>(self, wo: Vec3, f: impl Fn(Vec3) -> T) -> T
    where
        T: Sum + Mul<f32, Output = T> + Div<f32, Output = T>,
    {
        self.mean_visible_across(self.alpha, (0.5, [16, 32]), wo, f)
    }

    /// The same for microfacets of another width across, over part of the circle and in this number of strata
    /// around and away.
    pub(super) fn mean_visible_across<T>(
        self,
        across: f32,
        (phase, [around, steps]): (f32, [usize; 2]),
        wo: Vec3,
        f: impl Fn(Vec3) -> T,
    ) -> T
    where
        T: Sum + Mul<f32, Output = T> + Div<f32, Output = T>,
    {
        let strata = (0..around).flat_map(|i| (0..steps).map(move |j| (i, j)));
        let values = strata.map(|(i, j)| {
            let left = 1.0 - (j as f32 + 0.5) / steps as f32;
            let u = [phase * (i as f32 + 0.5) / around as f32, 1.0 - left * left];
            f(self.sample_visible_across(across, wo.into(), u).into()) * (2.0 * left)
        });
        values.sum::<T>() / (around * steps) as f32
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
            let ground = integrate(|h| f64::from(ggx.density(h.z, h.x * h.x + h.y * h.y) * h.z));
            assert!((ground - 1.0).abs() < 2e-3, "roughness {roughness}: projected area {ground}");
        }
    }

    /// The mean of weights over samples is the lobe's integral; and the means of directions agree.
    #[test]
    fn samples_match_the_lobe() {
        for (roughness, angle) in [(0.3, 0.5_f32), (0.6, 1.2), (1.0, 0.9)] {
            let ggx = Ggx::new(roughness);
            let wo = Vec3::new(angle.sin(), 0.0, angle.cos());
            const N: u32 = 1 << 14;
            let mut sampled = [0.0_f64; 3];
            for sample in 0..N {
                let u = sample_pair(0, SampleKey { pixel: 1, sample, branch: 0 }, 0, 0);
                let wi = (-wo).reflect(ggx.sample_visible_across(ggx.alpha(), wo.into(), u).into());
                let weight = if wi.z > 0.0 { f64::from(ggx.sample_weight(wo.z, wi.z)) } else { 0.0 };
                let weight = weight / f64::from(N);
                for (sum, statistic) in sampled.iter_mut().zip([1.0, wi.x, wi.z]) {
                    *sum += weight * f64::from(statistic);
                }
            }
            let lobe = |wi: Vec3| {
                let h = (wo + wi).normalize();
                let hidden = ggx.lambda(wo.z) + ggx.lambda(wi.z);
                let density = ggx.density(h.z, h.x * h.x + h.y * h.y);
                if wi.z > 0.0 { f64::from(density / ((1.0 + hidden) * 4.0 * wo.z)) } else { 0.0 }
            };
            let statistics: [fn(Vec3) -> f32; 3] = [|_| 1.0, |w| w.x, |w| w.z];
            for (sampled, statistic) in sampled.iter().zip(statistics) {
                let expected = integrate(|wi| lobe(wi) * f64::from(statistic(wi)));
                assert!(
                    (sampled - expected).abs() < 4e-3,
                    "roughness {roughness}: {sampled}, lobe {expected}"
                );
            }
            assert!(sampled[0] <= 1.0, "no energy is made");
        }
    }
}
