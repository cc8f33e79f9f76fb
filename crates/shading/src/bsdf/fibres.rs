// SPDX-License-Identifier: GPL-3.0-or-later
//! Sheen of a layer of fibres that scatter light among them, as a cosine lobe that is linearly transformed by
//! the view.
//! Source: [ZBC22]; its three numbers by a fit of their tables, by Stephen Hill, as MaterialX specifies it.
//! Differs: no more than all light is reflected; if microfacets of low roughness would exceed that at grazing
//! views, the fit is limited. It is not reciprocal: the transform is the view's. Space: the shading frame.
//! Tests: `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

/// Smallest roughness: lobes of smaller ones are too thin to sample.
const SMOOTHEST: f32 = 0.02;

/// The transform from directions to those of a cosine lobe, `[[a, 0, b], [0, a, 0], [0, 0, 1]]` in a frame
/// with the view above x, and the share of light that comes back.
struct Transform {
    a: f32,
    b: f32,
    sent: f32,
}

impl Transform {
    fn of(roughness: f32, cos: f32) -> Self {
        let (x, y) = (cos.clamp(0.0, 1.0), roughness.clamp(SMOOTHEST, 1.0));
        let a = (2.581_26 * x + 0.813_703 * y) * y / (1.0 + 0.310_327 * x * x + 2.609_94 * x * y);
        let b = (1.0 - x).sqrt() * (y - 1.0) * y * y * y
            / (0.000_025_405_3 + 1.712_28 * x - 1.715_06 * x * y + 1.341_74 * y * y);
        let inverse = (0.037_942_4 + 1.322_27 * y + y * y) / (y * (0.020_660_7 + 1.584_91 * y));
        let mean = y * (-0.193_854 + y * (-1.148_85 + y * (1.793_2 - 0.959_43 * y * y))) / (0.046_391 + y);
        let floor =
            y * (0.000_654_023 + (-0.020_781_8 + 0.119_681 * y) * y) / (1.262_64 + y * (-1.920_21 + y));
        let q = (x - mean) * inverse;
        let sent = (-0.5 * q * q).exp() * inverse * 0.398_942_3 + floor;
        Self { a, b, sent: sent.clamp(0.0, 1.0) }
    }
}

/// The axes of a frame with `wo` above the first one.
fn axes(wo: Vec3) -> [f32; 2] {
    let across = wo.x.hypot(wo.y);
    if across > 0.0 { [wo.x / across, wo.y / across] } else { [1.0, 0.0] }
}

/// Value times the cosine, and density.
pub(super) fn eval_pdf(roughness: f32, wo: Vec3, wi: Vec3) -> (f32, f32) {
    if wi.z <= 0.0 {
        return (0.0, 0.0);
    }
    let (Transform { a, b, sent }, [x, y]) = (Transform::of(roughness, wo.z), axes(wo));
    let (along, aside) = (x * wi.x + y * wi.y, x * wi.y - y * wi.x);
    let plain = Vec3::new(a * along + b * wi.z, a * aside, wi.z);
    let change = a / plain.length_squared();
    let density = change * change * wi.z * FRAC_1_PI;
    (sent * density, density)
}

/// The direction that one drawn by the cosine becomes.
pub(super) fn sample(roughness: f32, wo: Vec3, cosine: Vec3) -> Vec3 {
    let (Transform { a, b, .. }, [x, y]) = (Transform::of(roughness, wo.z), axes(wo));
    let (along, aside) = (cosine.x - b * cosine.z, cosine.y);
    Vec3::new(x * along - y * aside, y * along + x * aside, a * cosine.z).normalize()
}

/// Share of light that comes back, seen at the cosine `cos`.
pub(super) fn albedo(roughness: f32, cos: f32) -> f32 {
    Transform::of(roughness, cos).sent
}
