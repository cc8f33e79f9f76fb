// SPDX-License-Identifier: GPL-3.0-or-later
//! Beckmann's microfacets, whose slopes have a Gaussian distribution: density, shadowing, sampling of the
//! visible ones. Single scattering only; the light of further bounces is lost.
//! Source: [WMLT07] (the distribution), [Hei14] (shadowing in closed form, stretched microfacets, the density
//! of visible slopes). Sampling is original: the distribution function of the slopes along the view has a
//! closed form, which is inverted by halving.
//! Space: a frame with z = the shading normal, x and y along the axes of the slopes. Tests: `tests`, `tests`
//! of `bsdf`.

use std::f32::consts::PI;

use glam::Vec3;

use super::rough_dielectric::Microfacets;
use crate::real::Vector;

/// Slopes of two widths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beckmann {
    /// Root of twice the variance along x, in (0, 1]; along y.
    widths: [f32; 2],
}

/// Root of pi.
const ROOT_PI: f32 = 1.772_453_9;
/// Steeper slopes than this many widths do not count.
const STEEPEST: f32 = 4.0;
/// Halvings of where a slope may lie.
const HALVINGS: u32 = 26;

impl Beckmann {
    pub(super) fn new(widths: [f32; 2]) -> Self {
        Self { widths: widths.map(|width| width.clamp(1e-3, 1.0)) }
    }

    /// The direction in the frame where microfacets are stretched to slopes of width 1.
    fn stretched(self, w: Vec3) -> Vec3 {
        Vec3::new(w.x * self.widths[0], w.y * self.widths[1], w.z)
    }
}

impl Microfacets<f32> for Beckmann {
    fn density(&self, _: Vector<f32>, h: Vector<f32>) -> f32 {
        if h.z <= 0.0 {
            return 0.0;
        }
        let [x, y] = [h.x / (self.widths[0] * h.z), h.y / (self.widths[1] * h.z)];
        let cos2 = h.z * h.z;
        (-(x * x + y * y)).exp() / (PI * self.widths[0] * self.widths[1] * cos2 * cos2)
    }

    fn lambda(&self, w: Vector<f32>, cos: f32) -> f32 {
        let w = self.stretched(w.into());
        let a = cos.abs() / w.x.hypot(w.y).max(1e-20);
        if a > STEEPEST {
            return 0.0;
        }
        (0.5 * ((-a * a).exp() / (a * ROOT_PI) - rest_of_error(a))).max(0.0)
    }

    fn sample_visible(&self, wo: Vector<f32>, u: [f32; 2]) -> Vector<f32> {
        let view = self.stretched(wo.into());
        let across = view.x.hypot(view.y);
        let [x, y] = if across > 0.0 { [view.x / across, view.y / across] } else { [1.0, 0.0] };
        let [along, aside] = [visible_slope(across / view.z, u[0]), visible_slope(0.0, u[1])];
        let [x, y] = [x * along - y * aside, y * along + x * aside];
        Vec3::new(x * self.widths[0], y * self.widths[1], 1.0).normalize().into()
    }

    fn lost(&self, _: Vector<f32>, _: f32, _: f32, _: bool) -> f32 {
        0.0
    }
}

/// One less the error function, of `x` >= 0: the approximation 7.1.26 of Abramowitz and Stegun, 1.5e-7 off at
/// most.
fn rest_of_error(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let series =
        t * (0.254_829_6 + t * (-0.284_496_74 + t * (1.421_413_7 + t * (-1.453_152 + t * 1.061_405_4))));
    series * (-x * x).exp()
}

/// The slope, towards the view, of a visible microfacet, for slopes of width 1 and a view with tangent `tan`
/// >= 0; `u` is the cumulative probability.
fn visible_slope(tan: f32, u: f32) -> f32 {
    // Of the integral of (1 + tan x) exp(-x²), where that is positive.
    let below = |x: f32| {
        let error = (1.0 - rest_of_error(x.abs())).copysign(x);
        0.5 * (ROOT_PI * error - tan * (-x * x).exp())
    };
    let (mut low, mut high) = ((-1.0 / tan.max(1e-20)).max(-STEEPEST), STEEPEST);
    let (start, end) = (below(low), below(high));
    let target = start + (end - start) * u;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if below(middle) < target { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums over the hemisphere of microfacets, with rings that are narrow around the normal.
    fn sum(of: impl Fn(Vec3) -> f32) -> f32 {
        let (rings, sectors) = (400, 100);
        let mut sum = 0.0_f64;
        for ring in 0..rings {
            let [a, b] = [ring, ring + 1].map(|k| 1.0 - (k as f32 / rings as f32).powi(2));
            let (z, sin) = (0.5 * (a + b), (1.0 - (0.5 * (a + b)).powi(2)).sqrt());
            for sector in 0..sectors {
                let (s, c) = ((sector as f32 + 0.5) / sectors as f32 * 2.0 * PI).sin_cos();
                sum += f64::from(of(Vec3::new(sin * c, sin * s, z)) * (a - b));
            }
        }
        (sum * f64::from(2.0 * PI) / f64::from(sectors)) as f32
    }

    #[test]
    fn facets_cover_the_ground_and_what_is_seen_of_it() {
        for widths in [[0.3, 0.3], [0.9, 0.3], [0.15, 0.6], [1.0, 1.0]] {
            let microfacets = Beckmann::new(widths);
            let ground = sum(|h| microfacets.density(Vec3::Z.into(), h.into()) * h.z);
            assert!((ground - 1.0).abs() < 2e-3, "{widths:?}: projected area {ground}");
            for wo in [Vec3::new(0.3, 0.1, 0.9), Vec3::new(0.2, 0.9, 0.2), Vec3::new(1.0, 0.4, 0.05)] {
                let wo = wo.normalize();
                let visible = sum(|h| microfacets.density(Vec3::Z.into(), h.into()) * wo.dot(h).max(0.0));
                let target = wo.z * (1.0 + microfacets.lambda(wo.into(), wo.z));
                assert!((visible / target - 1.0).abs() < 4e-3, "{widths:?} {wo}: {visible}, not {target}");
            }
        }
    }

    /// Means over evenly spread samples equal those over the visible microfacets.
    #[test]
    fn samples_are_what_is_seen() {
        let microfacets = Beckmann::new([0.7, 0.25]);
        for wo in [Vec3::Z, Vec3::new(0.5, 0.3, 0.7).normalize(), Vec3::new(-0.3, 1.0, 0.1).normalize()] {
            let n = 100;
            let mut found = Vec3::ZERO;
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let u = [i, j].map(|k| (k as f32 + 0.5) / n as f32);
                found += Vec3::from(microfacets.sample_visible(wo.into(), u)) / (n * n) as f32;
            }
            let share = |h: Vec3| {
                microfacets.density(Vec3::Z.into(), h.into()) * wo.dot(h).max(0.0)
                    / (wo.z * (1.0 + microfacets.lambda(wo.into(), wo.z)))
            };
            let target = Vec3::from([0, 1, 2].map(|k: usize| sum(|h| share(h) * h[k])));
            assert!((found - target).length() < 4e-3, "{wo}: {found}, not {target}");
        }
    }
}
