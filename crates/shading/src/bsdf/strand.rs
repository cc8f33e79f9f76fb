// SPDX-License-Identifier: GPL-3.0-or-later
//! A strand of hair by two lobes: light that it reflects, and light that it lets through. Each is a product of a distribution of
//! angles along the strand and one around it. Along it, and around it beyond, the distribution is Cauchy's, cut off and normalised,
//! because that is sampled in closed form; around it on this side it is a cosine of half the angle.
//! Source: \[HR12\] for the product and its sampling; numbers by pictures of Cycles' node Hair BSDF. Values contain the cosine, and have no
//! horizon. Not reciprocal: angles are cut off by the view. Invariant: all light leaves again.
//! Space: x along the strand to its tip, z the outward normal. Tests: `tests`.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3;

/// Narrowest distributions.
const NARROWEST: f32 = 1e-3;
/// Directions nearer to the strand's axis count as that near.
const LEAST_COS: f32 = 1e-4;

/// One of the lobes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strand {
    /// Whether it is light that goes through.
    pub(super) through: bool,
    /// Widths along and around.
    pub(super) widths: [f32; 2],
    /// Rotation of the lobe towards the root, radians.
    pub(super) offset: f32,
}

/// The angle along the strand, of which only half is between the directions, is spread over this range around the offset.
struct Along {
    /// Angle of the view to the plane across the strand.
    view: f32,
    width: f32,
    offset: f32,
    /// Where the distribution begins and ends, as angles of its inverse.
    ends: [f32; 2],
}

impl Along {
    fn density(&self, sin: f32) -> f32 {
        let cos = (1.0 - sin * sin).max(0.0).sqrt().max(LEAST_COS);
        let half = 0.5 * (sin.clamp(-1.0, 1.0).asin() + self.view) - self.offset;
        let [low, high] = self.ends;
        self.width / (2.0 * (half * half + self.width * self.width) * (high - low) * cos)
    }

    fn sample(&self, u: f32) -> f32 {
        let [low, high] = self.ends;
        let half = self.width * (low + u * (high - low)).tan();
        (2.0 * (half + self.offset) - self.view).clamp(-FRAC_PI_2, FRAC_PI_2)
    }
}

/// To [-pi, pi].
fn wrapped(angle: f32) -> f32 {
    angle - TAU * (angle / TAU).round()
}

impl Strand {
    fn along(&self, wo: Vec3) -> Along {
        let view = wo.x.clamp(-1.0, 1.0).asin();
        let (width, offset) = (self.widths[0].max(NARROWEST), -self.offset);
        let end = |side: f32| ((0.5 * (side * FRAC_PI_2 + view) - offset) / width).atan();
        Along { view, width, offset, ends: [end(-1.0), end(1.0)] }
    }

    /// Density of the angle around the strand, from that of the view.
    fn around(&self, turn: f32) -> f32 {
        let width = self.widths[1].max(NARROWEST);
        let turn = wrapped(turn).abs();
        let beyond = PI - turn;
        match self.through {
            true if beyond < FRAC_PI_2 => {
                width / (2.0 * (FRAC_PI_2 / width).atan() * (beyond * beyond + width * width))
            }
            false if turn < PI * width => 0.25 * (0.5 * turn / width).cos() / width,
            _ => 0.0,
        }
    }

    fn sample_around(&self, u: f32) -> f32 {
        let (width, u) = (self.widths[1].max(NARROWEST), 2.0 * u - 1.0);
        if self.through {
            PI + width * (u * (FRAC_PI_2 / width).atan()).tan()
        } else {
            2.0 * width * u.asin()
        }
    }

    /// Value times the cosine, which is the density.
    pub(super) fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (f32, f32) {
        let turn = wi.y.atan2(wi.z) - wo.y.atan2(wo.z);
        let density = self.along(wo).density(wi.x) * self.around(turn);
        (density, density)
    }

    /// A unit direction.
    pub(super) fn sample(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let (sin, cos) = self.along(wo).sample(u[0]).sin_cos();
        let (side, up) = (wo.y.atan2(wo.z) + self.sample_around(u[1])).sin_cos();
        Vec3::new(sin, cos * side, cos * up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobes() -> [Strand; 4] {
        let of = |through, widths, offset| Strand { through, widths, offset };
        [
            of(false, [0.2, 1.0], 0.0),
            of(false, [0.4, 0.3], 0.2),
            of(true, [0.2, 0.5], 0.0),
            of(true, [0.5, 1.0], -0.3),
        ]
    }

    /// A direction by the angles along and around.
    fn toward(along: f32, around: f32) -> Vec3 {
        let ([sin, cos], [side, up]) = ([along.sin(), along.cos()], [around.sin(), around.cos()]);
        Vec3::new(sin, cos * side, cos * up)
    }

    fn views() -> [Vec3; 4] {
        [toward(0.0, 0.0), toward(0.5, 0.3), toward(-0.9, -1.0), toward(0.1, 1.4)]
    }

    /// Even steps over the sphere: directions and solid angles. Fine along the strand, where values have poles at its ends.
    fn sphere() -> impl Iterator<Item = (Vec3, f64)> {
        let (steps, turns) = (800, 400);
        let size = f64::from(PI / steps as f32) * f64::from(TAU / turns as f32);
        (0..steps).flat_map(move |i| {
            let along = ((i as f32 + 0.5) / steps as f32 - 0.5) * PI;
            (0..turns).map(move |j| {
                let around = (j as f32 + 0.5) / turns as f32 * TAU;
                (toward(along, around), size * f64::from(along.cos()))
            })
        })
    }

    #[test]
    fn no_light_is_lost() {
        for lobe in lobes() {
            for wo in views() {
                let sum: f64 = sphere().map(|(wi, size)| f64::from(lobe.eval_pdf(wo, wi).0) * size).sum();
                assert!((sum - 1.0).abs() < 0.01, "{lobe:?} {wo}: {sum}");
            }
        }
    }

    #[test]
    fn densities_are_those_of_samples() {
        let test = |w: Vec3| f64::from(w.x * w.x + 0.5 * w.y + 0.3 * w.z * w.x + 0.2 * w.z);
        for lobe in lobes() {
            for wo in views() {
                let expected: f64 =
                    sphere().map(|(wi, size)| test(wi) * f64::from(lobe.eval_pdf(wo, wi).1) * size).sum();
                let count = 40_000;
                let step = |i: u32, by: f64| (f64::from(i) * by).fract() as f32;
                let sampled = (0..count)
                    .map(|i| test(lobe.sample(wo, [step(i, 0.754_877_666), step(i, 0.569_840_291)])))
                    .sum::<f64>()
                    / f64::from(count);
                assert!((sampled - expected).abs() < 0.01, "{lobe:?} {wo}: {sampled}, {expected}");
            }
        }
    }

    #[test]
    fn values_are_those_of_cycles() {
        // A plane under a sun of 1, read from a picture of the node Hair BSDF: angles of the view and of the light, in degrees.
        for (lobe, [to, po, ti, pi], seen) in [
            (lobes()[0], [0.0, 0.0, 0.0, 60.0], 0.2048),
            (lobes()[0], [40.0, -30.0, -10.0, 20.0], 0.083_55),
            (lobes()[2], [0.0, 0.0, 30.0, 180.0], 0.3188),
            (lobes()[2], [0.0, 0.0, 0.0, 240.0], 0.139_09),
        ] {
            let [to, po, ti, pi] = [to, po, ti, pi].map(f32::to_radians);
            let value = lobe.eval_pdf(toward(to, po), toward(ti, pi)).0;
            assert!((value / seen - 1.0).abs() < 2e-3, "{lobe:?}: {value}, {seen}");
        }
    }
}
