// SPDX-License-Identifier: GPL-3.0-or-later
//! Share of light that a smooth boundary mirrors.
//! Source: [PJH23] section 9.3 (Fresnel's equations for dielectrics and conductors), [Sch94] (approximation).
//! Space: `cos` is that of the angle to the normal on the side that light comes from.
//! Proof: `tests`.

use glam::Vec3;

/// Share of unpolarised light that is mirrored; `cos` of the angle to the normal on the side that light comes from,
/// `eta` = index there over index beyond.
pub(crate) fn dielectric(cos: f32, eta: f32) -> f32 {
    let cos = cos.clamp(0.0, 1.0);
    let sin2_beyond = eta * eta * (1.0 - cos * cos);
    if sin2_beyond >= 1.0 {
        return 1.0;
    }
    let beyond = (1.0 - sin2_beyond).sqrt();
    let parallel = (cos - eta * beyond) / (cos + eta * beyond);
    let perpendicular = (eta * cos - beyond) / (eta * cos + beyond);
    (0.5 * (parallel * parallel + perpendicular * perpendicular)).min(1.0)
}

/// Share that a boundary mirrors at normal incidence; `ior` = index of one side over that of the other.
pub(crate) fn normal_reflectance(ior: f32) -> f32 {
    let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
    if f0.is_finite() { f0.min(1.0) } else { 1.0 }
}

/// How far Schlick's approximation has risen from the reflectance at normal incidence (0) to that at grazing (1).
pub(crate) fn schlick_rise(cos: f32) -> f32 {
    let m = 1.0 - cos.clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// Schlick's approximation averaged over a cosine-weighted hemisphere.
pub(crate) fn schlick_average(f0: Vec3, f90: f32) -> Vec3 {
    f0 * (20.0 / 21.0) + Vec3::splat(f90 / 21.0)
}

/// A metal's reflectance from its complex index `eta + i k`, per channel, seen from vacuum.
pub(crate) fn conductor(cos: f32, eta: Vec3, k: Vec3) -> Vec3 {
    let cos = cos.clamp(0.0, 1.0);
    let (cos2, sin2) = (cos * cos, 1.0 - cos * cos);
    let (eta2, k2) = (eta * eta, k * k);
    let t0 = eta2 - k2 - Vec3::splat(sin2);
    let a2_plus_b2 = (t0 * t0 + 4.0 * eta2 * k2).map(f32::sqrt);
    let t1 = a2_plus_b2 + Vec3::splat(cos2);
    let t2 = (0.5 * (a2_plus_b2 + t0)).max(Vec3::ZERO).map(f32::sqrt) * (2.0 * cos);
    let perpendicular = (t1 - t2) / (t1 + t2).max(Vec3::splat(f32::MIN_POSITIVE));
    let t3 = a2_plus_b2 * cos2 + Vec3::splat(sin2 * sin2);
    let t4 = t2 * sin2;
    let parallel = perpendicular * (t3 - t4) / (t3 + t4).max(Vec3::splat(f32::MIN_POSITIVE));
    (0.5 * (parallel + perpendicular)).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dielectrics_have_their_closed_forms() {
        let normal = ((1.5_f32 - 1.0) / (1.5 + 1.0)).powi(2);
        assert!((dielectric(1.0, 1.0 / 1.5) - normal).abs() < 1e-6, "at normal incidence from outside");
        assert!((dielectric(1.0, 1.5) - normal).abs() < 1e-6, "and from inside");
        assert_eq!(dielectric(0.0, 1.0 / 1.5), 1.0, "all at grazing incidence");
        assert_eq!(dielectric(0.5, 1.5), 1.0, "total inside reflection beyond the critical angle");
        assert!(dielectric(0.3, 1.0) < 1e-6, "no boundary, no reflection");
        // Brewster's angle: parallel light is not mirrored, so half of the perpendicular share is left.
        let cos = (1.0 / (1.0 + 1.5_f32 * 1.5)).sqrt();
        let perpendicular = ((1.0 - 2.25_f32) / (1.0 + 2.25)).powi(2);
        assert!((dielectric(cos, 1.0 / 1.5) - 0.5 * perpendicular).abs() < 1e-6, "at Brewster's angle");
    }

    #[test]
    fn conductors_without_absorption_are_dielectrics() {
        for cos in [0.05, 0.3, 0.7, 1.0] {
            let metal = conductor(cos, Vec3::splat(1.5), Vec3::ZERO).x;
            assert!((metal - dielectric(cos, 1.0 / 1.5)).abs() < 1e-5, "cos {cos}: {metal}");
        }
        let (eta, k) = (0.2_f32, 3.9_f32);
        let wanted = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
        let found = conductor(1.0, Vec3::splat(eta), Vec3::splat(k)).x;
        assert!((found - wanted).abs() < 1e-5, "the closed form at normal incidence");
    }

    #[test]
    fn schlick_averages_as_it_integrates() {
        let n = 4000;
        let sum: f32 = (0..n)
            .map(|i| (i as f32 + 0.5) / n as f32)
            .map(|cos| 2.0 * cos * (0.04 + 0.96 * schlick_rise(cos)) / n as f32)
            .sum();
        assert!((sum - schlick_average(Vec3::splat(0.04), 1.0).x).abs() < 1e-4, "{sum}");
    }
}
