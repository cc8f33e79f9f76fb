// SPDX-License-Identifier: GPL-3.0-or-later
//! Hair: light that a fibre with tilted scales reflects (R), lets through (TT), or lets out after one or more
//! reflections within (TRT and further ones). A lobe is one of the three; together they are the model.
//! Source: \[CBTB16\]; \[PJH23\] section 9.9 for its numbers; [MJC*03] for the terms. Near field: the offset from the middle
//! of the fibre comes from the normal of the hit.
//! Space: x along the fibre to its tip, z the outward normal. Values contain the cosine, and have no horizon: light goes to all
//! sides. Invariant: without absorption all light leaves again. Tests: `tests`.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::fresnel;

/// Directions nearer to the fibre's axis count as that near.
const LEAST_COS: f32 = 1e-4;

/// One of the terms of a fibre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hair {
    /// 0: R; 1: TT; 2: TRT and what follows.
    pub(super) term: usize,
    /// Absorption within the fibre, for a radius of 1.
    pub(super) absorption: Vec3,
    /// Variance of angles along the fibre.
    pub(super) variance: f32,
    /// Scale of the logistic distribution of angles around it.
    pub(super) scale: f32,
    /// Its index of refraction over that around it.
    pub(super) index: f32,
    /// Angle of the scales.
    pub(super) tilt: f32,
}

/// A fibre seen from a direction.
struct Seen {
    sin: f32,
    cos: f32,
    /// Angle around the fibre.
    phi: f32,
    /// Angles of the ray to the normal, outside and inside, in the plane across.
    gamma: f32,
    gamma_within: f32,
    /// Shares of light of R, TT, TRT and the rest.
    shares: [Vec3; 4],
}

/// Angle around the fibre.
fn angle(w: Vec3) -> f32 {
    w.z.atan2(w.y)
}

/// To [-pi, pi].
fn wrapped(angle: f32) -> f32 {
    angle - TAU * (angle / TAU).round()
}

/// Logarithm of the modified Bessel function of order 0, of `x` at least 0.
fn log_bessel(x: f32) -> f32 {
    if x > 12.0 {
        return x + 0.5 * (-(TAU.ln()) - x.ln() + 1.0 / (8.0 * x));
    }
    let (mut sum, mut term) = (1.0, 1.0);
    for i in 1..=24 {
        term *= 0.25 * x * x / (i * i) as f32;
        sum += term;
    }
    sum.ln()
}

/// The share of the logistic distribution below `x`.
fn logistic_below(x: f32, scale: f32) -> f32 {
    1.0 / (1.0 + (-x / scale).exp())
}

/// Its density, trimmed to [-pi, pi].
fn logistic(x: f32, scale: f32) -> f32 {
    let e = (-x.abs() / scale).exp();
    let all = logistic_below(PI, scale) - logistic_below(-PI, scale);
    e / (scale * (1.0 + e) * (1.0 + e)) / all
}

fn sample_logistic(u: f32, scale: f32) -> f32 {
    let low = logistic_below(-PI, scale);
    let at = low + u * (logistic_below(PI, scale) - low);
    (-scale * (1.0 / at.clamp(1e-7, 1.0 - 1e-7) - 1.0).ln()).clamp(-PI, PI)
}

impl Hair {
    fn seen(&self, wo: Vec3) -> Seen {
        let sin = wo.x.clamp(-1.0, 1.0);
        let cos = (1.0 - sin * sin).max(0.0).sqrt().max(LEAST_COS);
        let phi = angle(wo);
        // The normal is at a quarter of a turn.
        let offset = -wo.y / wo.y.hypot(wo.z).max(f32::MIN_POSITIVE);
        let offset = offset.clamp(-1.0, 1.0);
        let index = self.index;
        let index_across = (index * index - sin * sin).max(0.0).sqrt() / cos;
        let sin_within = (offset / index_across.max(f32::MIN_POSITIVE)).clamp(-1.0, 1.0);
        let cos_across = (1.0 - sin_within * sin_within).sqrt();
        let sin_along = sin / index;
        let cos_along = (1.0 - sin_along * sin_along).max(LEAST_COS * LEAST_COS).sqrt();
        let depth = 2.0 * cos_across / cos_along;
        let through = (-self.absorption * depth).exp();
        let mirrored = fresnel::dielectric(cos * (1.0 - offset * offset).max(0.0).sqrt(), 1.0 / index);
        let first = Vec3::splat((1.0 - mirrored) * (1.0 - mirrored)) * through;
        let second = first * through * mirrored;
        let rest = second * through * mirrored / (1.0 - through * mirrored).max(Vec3::splat(1e-6));
        Seen {
            sin,
            cos,
            phi,
            gamma: offset.asin(),
            gamma_within: sin_within.asin(),
            shares: [Vec3::splat(mirrored), first, second, rest],
        }
    }

    /// Sine and cosine of the view after the tilt of the scales, for a term; the rest is not tilted.
    fn tilted(&self, seen: &Seen, term: usize) -> [f32; 2] {
        let by = match term {
            0 => 2.0 * self.tilt,
            1 => -self.tilt,
            2 => -4.0 * self.tilt,
            _ => 0.0,
        };
        let (sin, cos) = by.sin_cos();
        [seen.sin * cos - seen.cos * sin, (seen.cos * cos + seen.sin * sin).abs()]
    }

    /// Density of the angle along the fibre, per projected solid angle.
    fn along(&self, [sin_i, cos_i]: [f32; 2], [sin_o, cos_o]: [f32; 2]) -> f32 {
        let v = self.variance;
        let (a, b) = (cos_i * cos_o / v, sin_i * sin_o / v);
        if v <= 0.1 {
            (log_bessel(a) - b - 1.0 / v + 2.0_f32.ln() + (0.5 / v).ln()).exp()
        } else {
            (log_bessel(a) - b).exp() / ((1.0 / v).sinh() * 2.0 * v)
        }
    }

    /// Where light of a term leaves, around the fibre, relative to the view.
    fn turn(term: usize, seen: &Seen) -> f32 {
        let p = term as f32;
        2.0 * p * seen.gamma_within - 2.0 * seen.gamma + p * PI
    }

    /// Parts of a lobe: terms with their shares of light.
    fn parts<'a>(&self, seen: &'a Seen) -> impl Iterator<Item = (usize, Vec3)> + 'a {
        let terms = if self.term < 2 { self.term..self.term + 1 } else { 2..4 };
        terms.map(|term| (term, seen.shares[term]))
    }

    /// Of TRT and further terms: the share of samples of the first.
    fn share_of_first(&self, seen: &Seen) -> f32 {
        if self.term < 2 {
            return 1.0;
        }
        let [first, rest] = [seen.shares[2], seen.shares[3]].map(|share| share.element_sum());
        if first + rest > 0.0 { first / (first + rest) } else { 1.0 }
    }

    /// Share of light that is scattered.
    pub(super) fn albedo(&self, wo: Vec3) -> Vec3 {
        let seen = self.seen(wo);
        self.parts(&seen).map(|(_, share)| share).sum()
    }

    /// Value and density of the unit `wi`.
    pub(super) fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let seen = self.seen(wo);
        let sin = wi.x.clamp(-1.0, 1.0);
        let to = [sin, (1.0 - sin * sin).max(0.0).sqrt()];
        let phi = angle(wi) - seen.phi;
        let of_first = self.share_of_first(&seen);
        let (mut value, mut pdf) = (Vec3::ZERO, 0.0);
        for (term, share) in self.parts(&seen) {
            let around = match term {
                3 => 1.0 / TAU,
                _ => logistic(wrapped(phi - Self::turn(term, &seen)), self.scale),
            };
            let density = self.along(to, self.tilted(&seen, term)) * around;
            value += share * density;
            pdf += density * if term == 3 { 1.0 - of_first } else { of_first };
        }
        (value, pdf)
    }

    /// A unit direction.
    pub(super) fn sample(&self, wo: Vec3, [a, b, c]: [f32; 3]) -> Vec3 {
        let seen = self.seen(wo);
        let of_first = self.share_of_first(&seen);
        let (term, c) = if c < of_first {
            (self.term, c / of_first)
        } else {
            (3, (c - of_first) / (1.0 - of_first).max(f32::MIN_POSITIVE))
        };
        let [sin_o, cos_o] = self.tilted(&seen, term);
        let v = self.variance;
        let least = a.max(1e-5);
        let cos = (1.0 + v * (least + (1.0 - least) * (-2.0 / v).exp()).ln()).clamp(-1.0, 1.0);
        let sin = (1.0 - cos * cos).max(0.0).sqrt() * (TAU * b).cos();
        let sin_i = (sin * cos_o - cos * sin_o).clamp(-1.0, 1.0);
        let cos_i = (1.0 - sin_i * sin_i).max(0.0).sqrt();
        let turn = match term {
            3 => TAU * c,
            _ => Self::turn(term, &seen) + sample_logistic(c, self.scale),
        };
        let (up, side) = (seen.phi + turn).sin_cos();
        Vec3::new(sin_i, cos_i * side, cos_i * up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn terms(absorption: f32, variance: f32, scale: f32) -> [Hair; 3] {
        let of = |term| Hair {
            term,
            absorption: Vec3::splat(absorption),
            variance: variance * [1.0, 0.25, 4.0][term],
            scale,
            index: 1.55,
            tilt: 0.05,
        };
        [0, 1, 2].map(of)
    }

    fn views() -> [Vec3; 4] {
        let of = |sin: f32, offset: f32| {
            let cos = (1.0 - sin * sin).sqrt();
            Vec3::new(sin, -offset * cos, (1.0 - offset * offset).sqrt() * cos)
        };
        [of(0.0, 0.0), of(0.4, 0.6), of(-0.7, -0.8), of(0.2, 0.95)]
    }

    /// Even steps over the sphere: directions and solid angles.
    fn sphere(steps: usize) -> impl Iterator<Item = (Vec3, f64)> {
        let solid = 2.0 * std::f64::consts::TAU / (2 * steps * steps) as f64;
        (0..steps).flat_map(move |i| {
            (0..2 * steps).map(move |j| {
                let x = (2 * i + 1) as f32 / steps as f32 - 1.0;
                let (up, side) = (PI * (j as f32 + 0.5) / steps as f32).sin_cos();
                let cos = (1.0 - x * x).sqrt();
                (Vec3::new(x, cos * side, cos * up), solid)
            })
        })
    }

    #[test]
    fn no_light_is_lost_without_absorption() {
        for (variance, scale) in [(0.02, 0.1), (0.1, 0.3), (0.4, 0.6)] {
            for wo in views() {
                let terms = terms(0.0, variance, scale);
                let all: Vec3 = terms.iter().map(|hair| hair.albedo(wo)).sum();
                assert!((all - 1.0).abs().max_element() < 1e-4, "shares: {all}");
                let sum: f64 = sphere(300)
                    .map(|(wi, solid)| {
                        let value: f32 = terms.iter().map(|hair| hair.eval_pdf(wo, wi).0.x).sum();
                        f64::from(value) * solid
                    })
                    .sum();
                assert!((sum - 1.0).abs() < 0.01, "{variance} {scale} {wo}: {sum}");
            }
        }
    }

    #[test]
    fn densities_are_those_of_samples() {
        for wo in views() {
            for hair in terms(0.3, 0.1, 0.3) {
                let sum: f64 = sphere(300).map(|(wi, d)| f64::from(hair.eval_pdf(wo, wi).1) * d).sum();
                assert!((sum - 1.0).abs() < 0.01, "{hair:?} {wo}: {sum}");
                // The mean of any function over samples is its integral under the density.
                let test = |w: Vec3| f64::from(w.x * w.x + 0.5 * w.y + 0.3 * w.z * w.x);
                let expected: f64 =
                    sphere(300).map(|(wi, d)| test(wi) * f64::from(hair.eval_pdf(wo, wi).1) * d).sum();
                let count = 40_000;
                let step = |i: u32, by: f64| (f64::from(i) * by).fract() as f32;
                let sampled: f64 = (0..count)
                    .map(|i| {
                        let u = [step(i, 0.819_172_513), step(i, 0.671_043_606_7), step(i, 0.549_700_478)];
                        test(hair.sample(wo, u))
                    })
                    .sum::<f64>()
                    / f64::from(count);
                assert!((sampled - expected).abs() < 0.01, "{hair:?} {wo}: {sampled}, {expected}");
            }
        }
    }

    #[test]
    fn a_mirror_turns_around_the_normal() {
        // A narrow first term: light goes to the mirror image of the view.
        let hair = Hair { tilt: 0.0, ..terms(0.0, 1e-4, 0.01)[0] };
        for wo in views() {
            let wi = hair.sample(wo, [0.999, 0.25, 0.5]);
            let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
            assert!((wi - mirrored).length() < 0.05, "{wo} to {wi}, not {mirrored}");
        }
    }
}
