// SPDX-License-Identifier: GPL-3.0-or-later
//! Lambert's reflector: alike to all sides. Source: [Lam60]. Space: the shading frame; `cos` is that of the direction
//! light goes to. Proof: `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::BsdfSample;
use crate::sampling::cosine_hemisphere;

pub(super) fn eval(albedo: Vec3, cos: f32) -> Vec3 {
    if cos > 0.0 { albedo * (cos * FRAC_1_PI) } else { Vec3::ZERO }
}

pub(super) fn pdf(cos: f32) -> f32 {
    if cos > 0.0 { cos * FRAC_1_PI } else { 0.0 }
}

pub(super) fn sample(albedo: Vec3, u: [f32; 2]) -> Option<BsdfSample> {
    sample_of(albedo, cosine_hemisphere(u))
}

/// The sample that goes to `wi`, which was chosen by its cosine.
pub(super) fn sample_of(albedo: Vec3, wi: Vec3) -> Option<BsdfSample> {
    let pdf = pdf(wi.z);
    (pdf > 0.0).then_some(BsdfSample { wi, weight: albedo, pdf, delta: false, transmitted: false })
}
