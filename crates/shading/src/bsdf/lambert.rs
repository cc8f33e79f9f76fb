// SPDX-License-Identifier: GPL-3.0-or-later
//! Lambert's reflector: alike to all sides. Source: [Lam60]. Space: the shading frame.
//! Proof: `tests::white_keeps_all_light`.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::BsdfSample;
use crate::sampling::cosine_hemisphere;

pub(super) fn eval(albedo: Vec3, wo: Vec3, wi: Vec3) -> Vec3 {
    if wo.z > 0.0 && wi.z > 0.0 { albedo * (wi.z * FRAC_1_PI) } else { Vec3::ZERO }
}

pub(super) fn pdf(wo: Vec3, wi: Vec3) -> f32 {
    if wo.z > 0.0 && wi.z > 0.0 { wi.z * FRAC_1_PI } else { 0.0 }
}

pub(super) fn sample(albedo: Vec3, wo: Vec3, u: [f32; 2]) -> Option<BsdfSample> {
    let wi = cosine_hemisphere(u);
    let pdf = pdf(wo, wi);
    (pdf > 0.0).then_some(BsdfSample { wi, weight: albedo, pdf, delta: false, transmitted: false })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::sample_pair;

    #[test]
    fn white_keeps_all_light() {
        let wo = Vec3::new(0.6, 0.0, 0.8);
        const N: u32 = 4096;
        let samples = (0..N).filter_map(|sample| {
            let u = sample_pair(0, SampleKey { pixel: 7, sample, branch: 0 }, 0, 0);
            sample_of(wo, u)
        });
        let (mut sum, mut through) = (Vec3::ZERO, 0.0);
        for s in samples {
            sum += s.weight / N as f32;
            through += eval(Vec3::ONE, wo, s.wi).x / s.pdf / N as f32;
        }
        assert!((sum - Vec3::ONE).length() < 1e-5, "all of it: {sum}");
        assert!((through - 1.0).abs() < 1e-4, "eval over pdf is the weight: {through}");
    }

    fn sample_of(wo: Vec3, u: [f32; 2]) -> Option<BsdfSample> {
        sample(Vec3::ONE, wo, u)
    }
}
