// SPDX-License-Identifier: GPL-3.0-or-later
//! Phong's lobe around the mirror image: (n + 2) / (2 pi) cos^n of the angle to it.
//! Source: [Pho75]; [LW94] for the factor, by which all light comes back head on, and the sampling. As OSL's `phong` has it: dark at grazing views, where half of the lobe is
//! below the surface.
//! Space: the shading frame. Tests: `tests` of `bsdf`.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use crate::sampling::frame_around;

/// Greatest exponent: floats are too coarse for narrower lobes.
const SHARPEST: f32 = 1e5;

/// The exponent that counts.
pub(super) fn exponent(n: f32) -> f32 {
    n.clamp(0.0, SHARPEST)
}

/// Width of slopes that make a lobe as wide near the mirror image: cos^n around it is about cos^4n around the half vector.
pub(super) fn alpha(n: f32) -> f32 {
    (2.0 / (4.0 * exponent(n) + 2.0)).sqrt()
}

/// Value times the cosine, and density.
pub(super) fn eval_pdf(n: f32, wo: Vec3, wi: Vec3) -> (f32, f32) {
    let image = Vec3::new(-wo.x, -wo.y, wo.z);
    if wi.z <= 0.0 || image.dot(wi) <= 0.0 {
        return (0.0, 0.0);
    }
    // From the sine, which is more precise near the image.
    let sin2 = image.cross(wi).length_squared().min(0.999_999_9);
    let power = (0.5 * n * (-sin2).ln_1p()).exp() / TAU;
    ((n + 2.0) * power * wi.z, (n + 1.0) * power)
}

/// A direction, which may lie below the surface.
pub(super) fn sample(n: f32, wo: Vec3, u: [f32; 2]) -> Vec3 {
    let image = Vec3::new(-wo.x, -wo.y, wo.z);
    let [x, y] = frame_around(image.into());
    let cos = (1.0 - u[1]).powf(1.0 / (n + 1.0));
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = (TAU * u[0]).sin_cos();
    Vec3::from(x) * (sin * c) + Vec3::from(y) * (sin * s) + image * cos
}

/// About the share of light that comes back: cosines within the lobe as if spread by a Gaussian; exact where nothing of it is below the
/// surface.
pub(super) fn albedo(n: f32, cos: f32) -> f32 {
    let mean = cos * (n + 1.0) / (n + 2.0);
    let spread = ((1.0 - cos * cos).max(0.0) / (n + 3.0)).sqrt().max(1e-6);
    let x = mean / spread;
    // The normal distribution's function, about.
    let share = 1.0 / (1.0 + (-1.595_769 * x * (1.0 + 0.044_715 * x * x)).exp());
    let above = mean * share + spread * (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
    (above * (n + 2.0) / (n + 1.0)).clamp(0.0, 1.0)
}
