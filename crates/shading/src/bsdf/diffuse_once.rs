// SPDX-License-Identifier: GPL-3.0-or-later
//! Two diffuse models of other renderers, which do not keep all light: Oren's and Nayar's with single
//! scattering between the microfacets, and Burley's, which is dark or bright at grazing angles by the
//! roughness.
//! Source: [ON94] (their qualitative model, without the cut-off term of the azimuth: that is 0 where
//! microfacets face away), [Bur12] section 5.3. Albedos are integrals in closed form. Differs: where a
//! surface of Burley's model sends back more than all light it is scaled down. Directions are given by their
//! cosines to the shading normal. `roughness` is in [0, 1]. Tests: `tests` here and of `bsdf`.

use std::f32::consts::FRAC_1_PI;

/// Which of them; a number of a lobe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Model {
    /// Oren's and Nayar's.
    OrenNayar,
    /// Burley's.
    Burley,
}

impl Model {
    /// The number that represents it in a lobe's `eta`, where diffuse lobes have 1.
    pub(super) fn number(self) -> f32 {
        match self {
            Self::OrenNayar => 2.0,
            Self::Burley => 3.0,
        }
    }

    /// The model of a number.
    pub(super) fn of(number: f32) -> Option<Self> {
        [Self::OrenNayar, Self::Burley].into_iter().find(|model| model.number() == number)
    }

    /// The value times pi over the albedo, whose largest channel is `top`, without the cosine of `i`, for two
    /// directions whose dot product is `dot`.
    pub(super) fn value(self, [roughness, top]: [f32; 2], dot: f32, [o, i]: [f32; 2]) -> f32 {
        match self {
            Self::OrenNayar => {
                let [a, b] = shares(roughness);
                let s = (dot - o * i).max(0.0);
                // Never more than 1: the sine of the smaller angle over that of the larger, times a cosine.
                a + b * if s > 0.0 { s / o.max(i) } else { 0.0 }
            }
            Self::Burley => {
                let rise = roughness * (1.0 + dot) - 0.5;
                let value = (1.0 + rise * fall(o)) * (1.0 + rise * fall(i));
                value / (top * burley(roughness, o).max(burley(roughness, i))).max(1.0)
            }
        }
    }

    /// Share of light that the surface sends back over its albedo, whose largest channel is `top`, seen at
    /// the cosine `cos`; of Burley's about where that is scaled down.
    pub(super) fn albedo(self, [roughness, top]: [f32; 2], cos: f32) -> f32 {
        let cos = cos.clamp(0.0, 1.0);
        match self {
            Self::OrenNayar => {
                let [a, b] = shares(roughness);
                let sin = (1.0 - cos * cos).sqrt();
                // (1 - sin³) / cos without the cancellation: 1 - sin = cos² / (1 + sin).
                let low = cos * (1.0 + sin + sin * sin) / (3.0 * (1.0 + sin));
                let high = 0.5 * (cos.acos() - cos * sin);
                a + b * 2.0 * FRAC_1_PI * sin * (low + high)
            }
            Self::Burley => {
                let sent = burley(roughness, cos);
                sent / (top * sent).max(1.0)
            }
        }
    }
}

/// The share that every microfacet scatters, and the additional share of retroreflection.
fn shares(roughness: f32) -> [f32; 2] {
    let square = roughness * roughness;
    [1.0 - 0.5 * square / (square + 0.33), 0.45 * square / (square + 0.09)]
}

/// Schlick's rise towards grazing angles.
fn fall(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    m * m * m * m * m
}

/// Albedo of Burley's model as it was published: the mean over the azimuth, then integrals of powers of the
/// cosine.
fn burley(roughness: f32, cos: f32) -> f32 {
    let (here, sin2) = (fall(cos), 1.0 - cos * cos);
    // The rise at the cosine x, on the mean: c0 + c1 x.
    let (c0, c1) = (roughness - 0.5, roughness * cos);
    let once = here * (c0 + c1 * (2.0 / 3.0)) + 2.0 * (c0 / 42.0 + c1 / 168.0);
    let twice = 2.0 * (c0 * c0 / 42.0 + 2.0 * c0 * c1 / 168.0 + c1 * c1 / 504.0);
    1.0 + once + here * (twice + roughness * roughness * sin2 * (11.0 / 504.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    /// Albedo of a white surface by the midpoint rule.
    fn sum(of: impl Fn(f32, [f32; 2]) -> f32, o: f32) -> f32 {
        let (rings, sectors) = (400, 200);
        let mut sum = 0.0_f64;
        for ring in 0..rings {
            let i = (ring as f32 + 0.5) / rings as f32;
            for sector in 0..sectors {
                let angle = TAU * (sector as f32 + 0.5) / sectors as f32;
                let dot = o * i + ((1.0 - o * o) * (1.0 - i * i)).sqrt() * angle.cos();
                sum += f64::from(of(dot, [o, i]) * i);
            }
        }
        sum as f32 * 2.0 / (rings * sectors) as f32
    }

    #[test]
    fn albedos_are_the_integrals() {
        for (roughness, o) in [(0.0, 0.5), (0.3, 0.05), (0.3, 0.9), (1.0, 0.1), (1.0, 0.6), (1.0, 1.0)] {
            let of =
                |model: Model, top: f32| sum(|dot, cosines| model.value([roughness, top], dot, cosines), o);
            let found = Model::OrenNayar.albedo([roughness, 1.0], o);
            let expected = of(Model::OrenNayar, 1.0);
            assert!((found - expected).abs() < 2e-3, "oren-nayar {roughness} {o}: {found}, not {expected}");
            let plain = |dot: f32, [o, i]: [f32; 2]| {
                let rise = roughness * (1.0 + dot) - 0.5;
                (1.0 + rise * fall(o)) * (1.0 + rise * fall(i))
            };
            let (found, expected) = (burley(roughness, o), sum(plain, o));
            assert!((found - expected).abs() < 2e-3, "burley {roughness} {o}: {found}, not {expected}");
            for top in [0.5, 1.0] {
                let (found, expected) = (Model::Burley.albedo([roughness, top], o), of(Model::Burley, top));
                let light = top * expected;
                assert!(light < 1.001, "{roughness} {top} {o}: makes light: {light}");
                assert!((found - expected).abs() < 0.05, "{roughness} {top} {o}: {found}, not {expected}");
            }
        }
    }
}
