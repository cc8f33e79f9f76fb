// SPDX-License-Identifier: GPL-3.0-or-later
//! Share of light that a smooth boundary mirrors.
//! Source: [PJH23] section 9.3 (Fresnel's equations for dielectrics and conductors), [Sch94] (approximation).
//! Space: `cos` is that of the angle to the normal on the side that light comes from.
//! Tests: `tests`.

use crate::real::{Real, Vector};

/// Share of unpolarised light that is mirrored; `cos` of the angle to the normal on the side that light comes from,
/// `eta` = index there over index beyond.
#[inline(always)]
pub(crate) fn dielectric<R: Real>(cos: R, eta: R) -> R {
    let cos = cos.within(0.0, 1.0);
    let sin2_beyond = eta * eta * (cos * cos).rest();
    let beyond = sin2_beyond.rest().or_more(cos.all(0.0)).root();
    let parallel = (cos - eta * beyond) / (cos + eta * beyond);
    let perpendicular = (eta * cos - beyond) / (eta * cos + beyond);
    let share = ((parallel * parallel + perpendicular * perpendicular) * 0.5).or_less(cos.all(1.0));
    R::pick(cos.all(1.0).above(sin2_beyond), share, cos.all(1.0))
}

/// Share that a boundary mirrors at normal incidence; `ior` = index of one side over that of the other.
pub(crate) fn normal_reflectance(ior: f32) -> f32 {
    let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
    if f0.is_finite() { f0.min(1.0) } else { 1.0 }
}

/// How far Schlick's approximation has risen from the reflectance at normal incidence (0) to that at grazing (1).
#[inline(always)]
pub(crate) fn schlick_rise<R: Real>(cos: R) -> R {
    let m = cos.within(0.0, 1.0).rest();
    let m2 = m * m;
    m2 * m2 * m
}

/// Schlick's approximation averaged over a cosine-weighted hemisphere.
#[inline(always)]
pub(crate) fn schlick_average<R: Real>(f0: Vector<R>, f90: Vector<R>) -> Vector<R> {
    let one = f0.x.all(1.0);
    f0 * (one * (20.0 / 21.0)) + f90 * (one * (1.0 / 21.0))
}

/// A metal's reflectance in one channel from its complex index `eta + i k`, seen from vacuum.
#[inline(always)]
pub(crate) fn conductor<R: Real>(cos: R, eta: R, k: R) -> R {
    let (zero, least) = (cos.all(0.0), cos.all(f32::MIN_POSITIVE));
    let cos = cos.within(0.0, 1.0);
    let (cos2, sin2) = (cos * cos, (cos * cos).rest());
    let (eta2, k2) = (eta * eta, k * k);
    let t0 = eta2 - k2 - sin2;
    let a2_plus_b2 = (t0 * t0 + eta2 * k2 * 4.0).root();
    let t1 = a2_plus_b2 + cos2;
    let t2 = ((a2_plus_b2 + t0) * 0.5).or_more(zero).root() * (cos * 2.0);
    let perpendicular = (t1 - t2) / (t1 + t2).or_more(least);
    let t3 = a2_plus_b2 * cos2 + sin2 * sin2;
    let t4 = t2 * sin2;
    let parallel = perpendicular * (t3 - t4) / (t3 + t4).or_more(least);
    ((parallel + perpendicular) * 0.5).within(0.0, 1.0)
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
        for cos in [0.05_f32, 0.3, 0.7, 1.0] {
            let metal = conductor(cos, 1.5, 0.0);
            assert!((metal - dielectric(cos, 1.0 / 1.5)).abs() < 1e-5, "cos {cos}: {metal}");
        }
        let (eta, k) = (0.2_f32, 3.9_f32);
        let expected = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
        let found = conductor(1.0, eta, k);
        assert!((found - expected).abs() < 1e-5, "the closed form at normal incidence");
    }

    #[test]
    fn schlick_averages_as_it_integrates() {
        let n = 4000;
        let sum: f32 = (0..n)
            .map(|i| (i as f32 + 0.5) / n as f32)
            .map(|cos: f32| 2.0 * cos * (0.04 + 0.96 * schlick_rise(cos)) / n as f32)
            .sum();
        assert!((sum - schlick_average(Vector::grey(0.04_f32), Vector::grey(1.0)).x).abs() < 1e-4, "{sum}");
    }
}
