// SPDX-License-Identifier: GPL-3.0-or-later
//! Ward's lobe of anisotropic surfaces, as published: exp(-tan² of the microfacet, by the widths along it) /
//! (4 pi ax ay root(cos cos)).
//! Source: [War92], equations 5a and 8; sampling of half vectors there. As OSL's `ward` has it: dark at
//! grazing views of smooth surfaces.
//! Differs: where a rough surface at grazing views sends back more than all light it is scaled down, for
//! either direction.
//! Space: a frame with z = the shading normal, x and y along the axes of the slopes. Tests: `tests`, `tests`
//! of `bsdf`.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

/// Value times the cosine, and density; `made` is the result of [`sent_back`] for `wo`.
pub(super) fn eval_pdf(widths: [f32; 2], made: f32, wo: Vec3, wi: Vec3) -> (f32, f32) {
    if wi.z <= 0.0 {
        return (0.0, 0.0);
    }
    let Some(h) = (wo + wi).try_normalize() else { return (0.0, 0.0) };
    let [x, y] = [h.x / widths[0], h.y / widths[1]];
    let lobe = (-(x * x + y * y) / (h.z * h.z)).exp() / (4.0 * PI * widths[0] * widths[1]);
    let made = made.max(sent_back(widths, wi)).max(1.0);
    (lobe * (wi.z / wo.z).sqrt() / made, lobe / (h.dot(wo).max(1e-20) * h.z * h.z * h.z))
}

/// A direction, which may lie below the surface.
pub(super) fn sample(widths: [f32; 2], wo: Vec3, u: [f32; 2]) -> Vec3 {
    let steep = (-(1.0 - u[1]).max(f32::MIN_POSITIVE).ln()).sqrt();
    let (s, c) = (TAU * u[0]).sin_cos();
    let h = Vec3::new(widths[0] * steep * c, widths[1] * steep * s, 1.0).normalize();
    (-wo).reflect(h)
}

/// Approximate albedo of the published lobe: the mean weight over slopes along the view and across it, which
/// are Gaussian.
pub(super) fn sent_back([along, across]: [f32; 2], wo: Vec3) -> f32 {
    /// Slopes along the view, up to this number of widths.
    const STEPS: u32 = 20;
    const STEEPEST: f32 = 3.0;
    let sin = wo.x.hypot(wo.y);
    let [x, y] = if sin > 0.0 { [wo.x / sin, wo.y / sin] } else { [1.0, 0.0] };
    // The width along the view; that across it, of microfacets whose slope along it is known, and the
    // displacement of its mean.
    let width = (along * x).hypot(across * y);
    let aside = along * across / width;
    let lean = x * y * (across * across - along * along) / (width * width);
    let (mut sum, mut total) = (0.0, 0.0);
    for step in 0..STEPS {
        let abscissa = STEEPEST * (2.0 * (step as f32 + 0.5) / STEPS as f32 - 1.0);
        let (slope, weight) = (abscissa * width, (-abscissa * abscissa).exp());
        total += weight;
        // Gauss's and Hermite's rule with five points.
        for (node, share) in [
            (0.0, 0.533_333),
            (0.958_573, 0.222_076),
            (-0.958_573, 0.222_076),
            (2.020_183, 0.011_257),
            (-2.020_183, 0.011_257),
        ] {
            let other = lean * slope + aside * node;
            let up = 1.0 / (1.0 + slope * slope + other * other).sqrt();
            let cos = (sin * slope + wo.z) * up;
            let out = 2.0 * cos * up - wo.z;
            if out > 0.0 && cos > 0.0 {
                sum += weight * share * cos * up * up * up * (out / wo.z).sqrt();
            }
        }
    }
    sum / total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_than_all_is_sent_back() {
        for widths in [[0.1, 0.1], [0.5, 0.2], [1.0, 1.0], [0.2, 0.9]] {
            for (cos, angle) in [(0.01_f32, 0.3_f32), (0.05, 1.5), (0.3, 0.0), (0.8, 0.7)] {
                let sin = (1.0 - cos * cos).sqrt();
                let wo = Vec3::new(sin * angle.cos(), sin * angle.sin(), cos);
                let (rings, sectors) = (60, 60);
                let reported = sent_back(widths, wo);
                let (mut published, mut ours) = (0.0_f64, 0.0_f64);
                for (ring, sector) in (0..rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
                    let edge = |k: i32| (k as f32 / rings as f32).powi(2);
                    let (a, b) = (edge(ring), edge(ring + 1));
                    let z = 0.5 * (a + b);
                    let r = (1.0 - z * z).sqrt();
                    // Narrow sectors opposite to the view.
                    let edge = |k: i32| PI * (2.0 * k as f32 / sectors as f32 - 1.0).powi(3) + PI + angle;
                    let (from, to) = (edge(sector), edge(sector + 1));
                    let (s, c) = (0.5 * (from + to)).sin_cos();
                    let wi = Vec3::new(r * c, r * s, z);
                    let value = eval_pdf(widths, reported, wo, wi).0 * (b - a) * (to - from);
                    let made = reported.max(sent_back(widths, wi)).max(1.0);
                    ours += f64::from(value);
                    published += f64::from(value * made);
                }
                let off = (f64::from(reported) - published).abs();
                assert!(off < 0.16 * published + 0.01, "{widths:?} {wo}: {reported}, not {published}");
                assert!(ours < 1.01, "{widths:?} {wo}: makes light: {ours}");
            }
        }
    }
}
