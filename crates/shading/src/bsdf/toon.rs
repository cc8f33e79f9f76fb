// SPDX-License-Identifier: GPL-3.0-or-later
//! Toon shading: a cone of even light around the normal or the mirror image, with a border in which the light falls linearly.
//! Cone and border are angles. The value contains the cosine: a light counts alike anywhere in the cone.
//! The cone is as bright as if it were full to the end of its border, so the border loses light, as do mirror images whose cone is
//! partly below the surface. Cones end at a right angle. Not reciprocal; paths from lights take it as if it were.
//! Source: Blender's manual, and pictures of its node Toon BSDF.
//! Space: the shading frame. Tests: `tests`, and those of `bsdf`.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3;

use crate::sampling::frame_around;

/// Narrowest cone, radians.
const NARROWEST: f32 = 1e-3;

/// Rings that the share of light above the surface is summed over.
const RINGS: usize = 32;

/// A cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Toon {
    /// Angle from the axis to the start of the border, and width of that; radians.
    size: f32,
    border: f32,
    /// Angle from the axis to the end of the cone.
    end: f32,
}

impl Toon {
    /// By the angle of the full light and the width of the border, radians.
    pub(super) fn new(size: f32, border: f32) -> Self {
        let size = size.clamp(NARROWEST, FRAC_PI_2);
        let border = border.clamp(0.0, FRAC_PI_2);
        Self { size, border, end: (size + border).min(FRAC_PI_2) }
    }

    /// Share of the full light at an angle to the axis.
    fn share(self, angle: f32) -> f32 {
        match angle {
            angle if angle > self.end => 0.0,
            angle if angle <= self.size => 1.0,
            // Such angles exist only within a border.
            angle => (1.0 - (angle - self.size) / self.border).max(0.0),
        }
    }

    /// One minus the cosine of the end, precise for narrow cones.
    fn height(self) -> f32 {
        let half = (0.5 * self.end).sin();
        2.0 * half * half
    }

    /// Value times the cosine, and density.
    pub(super) fn eval_pdf(self, axis: Vec3, wi: Vec3) -> (f32, f32) {
        // By the chord, which is precise near the axis.
        let angle = 2.0 * (0.5 * (wi - axis).length()).min(1.0).asin();
        if angle > self.end {
            return (0.0, 0.0);
        }
        let density = 1.0 / (TAU * self.height());
        (if wi.z > 0.0 { self.share(angle) * density } else { 0.0 }, density)
    }

    /// A direction of the cone, which may be below the surface.
    pub(super) fn sample(self, axis: Vec3, u: [f32; 2]) -> Vec3 {
        let [x, y] = frame_around(axis.into());
        let below = u[1] * self.height();
        let sin = (below * (2.0 - below)).max(0.0).sqrt();
        let (s, c) = (TAU * u[0]).sin_cos();
        (Vec3::from(x) * (sin * c) + Vec3::from(y) * (sin * s) + axis * (1.0 - below)).normalize()
    }

    /// Share of light that leaves, for an axis at the cosine `cos` to the normal.
    pub(super) fn albedo(self, cos: f32) -> f32 {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let step = self.height() / RINGS as f32;
        let ring = |i: usize| {
            // Rings of equal areas.
            let x = 1.0 - (i as f32 + 0.5) * step;
            let y = (1.0 - x * x).max(0.0).sqrt();
            // The part of the ring above the surface.
            let horizon = (-cos * x / (sin * y).max(1e-6)).clamp(-1.0, 1.0);
            self.share(x.clamp(-1.0, 1.0).acos()) * horizon.acos() / PI
        };
        (0..RINGS).map(ring).sum::<f32>() / RINGS as f32
    }
}

/// The axis of a cone around the normal, or around the mirror image of the view.
pub(super) fn axis(is_glossy: bool, wo: Vec3) -> Vec3 {
    if is_glossy { Vec3::new(-wo.x, -wo.y, wo.z) } else { Vec3::Z }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_falls_linearly() {
        let [size, border] = [30.0_f32, 20.0].map(f32::to_radians);
        let toon = Toon::new(size, border);
        let at = |degrees: f32| {
            let (s, c) = degrees.to_radians().sin_cos();
            toon.eval_pdf(Vec3::Z, Vec3::new(s, 0.0, c)).0
        };
        let full = 1.0 / (TAU * (1.0 - (size + border).cos()));
        for (degrees, share) in
            [(0.0, 1.0), (29.9, 1.0), (35.0, 0.75), (45.0, 0.25), (50.1, 0.0), (-40.0, 0.5)]
        {
            assert!((at(degrees) / full - share).abs() < 1e-3, "{degrees}: {}", at(degrees) / full);
        }
    }

    /// Even steps over the sphere: directions and solid angles.
    fn sphere() -> impl Iterator<Item = (Vec3, f64)> {
        let (rings, sectors) = (1000, 400);
        let size = 2.0 * f64::from(TAU) / f64::from(rings * sectors);
        (0..rings).flat_map(move |i| {
            let z = 1.0 - (2 * i + 1) as f32 / rings as f32;
            let r = (1.0 - z * z).sqrt();
            (0..sectors).map(move |j| {
                let (s, c) = ((j as f32 + 0.5) / sectors as f32 * TAU).sin_cos();
                (Vec3::new(r * c, r * s, z), size)
            })
        })
    }

    #[test]
    fn light_and_densities_are_those_of_samples() {
        for (size, border) in [(0.6, 0.0), (0.5, 0.4), (1.2, 0.8)] {
            let toon = Toon::new(size, border);
            for angle in [0.0_f32, 0.6, 1.3] {
                let axis = axis(true, Vec3::new(-angle.sin(), 0.0, angle.cos()));
                let (mut light, mut all, mut expected) = (0.0, 0.0, 0.0);
                let test = |w: Vec3| f64::from(w.x * w.x + 0.5 * w.y + 0.3 * w.z * w.x);
                for (wi, size) in sphere() {
                    let (value, density) = toon.eval_pdf(axis, wi);
                    light += f64::from(value) * size;
                    all += f64::from(density) * size;
                    expected += test(wi) * f64::from(density) * size;
                }
                assert!((all - 1.0).abs() < 0.01, "{toon:?} {angle}: {all}");
                let albedo = f64::from(toon.albedo(axis.z));
                assert!((light - albedo).abs() < 0.01, "{toon:?} {angle}: {light}, said {albedo}");
                let count = 40_000;
                let step = |i: u32, by: f64| (f64::from(i) * by).fract() as f32;
                let sampled = (0..count)
                    .map(|i| test(toon.sample(axis, [step(i, 0.754_877_666), step(i, 0.569_840_291)])))
                    .sum::<f64>()
                    / f64::from(count);
                assert!((sampled - expected).abs() < 0.01, "{toon:?} {angle}: {sampled}, {expected}");
            }
        }
    }

    #[test]
    fn a_cone_without_a_border_keeps_all_light() {
        assert!((Toon::new(0.7, 0.0).albedo(1.0) - 1.0).abs() < 1e-5);
        let half = Toon::new(0.5, 0.0).albedo(0.0);
        assert!((half - 0.5).abs() < 1e-3, "half of the cone is below: {half}");
    }
}
