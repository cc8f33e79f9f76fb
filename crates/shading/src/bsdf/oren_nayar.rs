// SPDX-License-Identifier: GPL-3.0-or-later
//! Rough diffuse surfaces, dusty ones: Oren's and Nayar's model as Fujii's fit, with all bounces between the facets.
//! Source: [PKH25] (EON), which mends [ON94]. Space: the shading frame. `roughness` is in [0, 1]; 0 is Lambert's reflector.
//! Proof: `tests` of `bsdf`.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

const C1: f32 = 0.5 - 2.0 / (3.0 * PI);
const C2: f32 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

pub(super) fn eval(albedo: Vec3, roughness: f32, wo: Vec3, wi: Vec3) -> Vec3 {
    if wi.z <= 0.0 {
        return Vec3::ZERO;
    }
    let s = wo.dot(wi) - wo.z * wi.z;
    let s_over_t = if s > 0.0 { s / wo.z.max(wi.z) } else { s };
    let a = 1.0 / (1.0 + C1 * roughness);
    let once = albedo * (a * (1.0 + roughness * s_over_t));
    let average = a * (1.0 + C2 * roughness);
    let lost = (1.0 - average).max(1e-7);
    let lobe = (1.0 - white_once(roughness, wo.z)) * (1.0 - white_once(roughness, wi.z)) / lost;
    (once + more(albedo, average) * lobe).max(Vec3::ZERO) * (FRAC_1_PI * wi.z)
}

pub(super) fn albedo(albedo: Vec3, roughness: f32, wo: Vec3) -> Vec3 {
    let once = white_once(roughness, wo.z);
    let average = (1.0 + C2 * roughness) / (1.0 + C1 * roughness);
    albedo * once + more(albedo, average) * (1.0 - once)
}

/// Colour of all bounces but the first.
fn more(albedo: Vec3, average: f32) -> Vec3 {
    albedo * albedo * average / (Vec3::ONE - albedo * (1.0 - average))
}

/// Albedo after one bounce of a white surface seen at the cosine `cos`: the integral in closed form.
fn white_once(roughness: f32, cos: f32) -> f32 {
    let cos = cos.clamp(0.0, 1.0);
    let sin = (1.0 - cos * cos).sqrt();
    // (sin / cos) (1 - sin³) without the cancellation: 1 - sin = cos² / (1 + sin).
    let tail = sin * cos * (1.0 + sin + sin * sin) / (1.0 + sin);
    let g = sin * (cos.acos() - sin * cos) + 2.0 / 3.0 * (tail - sin);
    (1.0 + roughness * FRAC_1_PI * g) / (1.0 + C1 * roughness)
}
