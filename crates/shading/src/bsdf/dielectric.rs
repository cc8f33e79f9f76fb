// SPDX-License-Identifier: GPL-3.0-or-later
//! Smooth boundaries of glass: Snell's law, and panes with all reflections between their two faces summed.
//! Source: [PJH23] sections 9.3 (Fresnel, Snell) and 9.5.1 (thin panes). Space: a frame with z = the
//! microfacet's normal.
//! Tests: `tests`.

use crate::real::{Real, Vector};

/// Reflectance of a pane whose faces each reflect `once`: all orders of reflection between them.
#[inline(always)]
pub(super) fn pane<R: Real>(once: R) -> R {
    once * 2.0 / (once + once.all(1.0))
}

/// `wo`, at the cosine `cos` > 0 to the unit normal `h` on its side, refracted; the points at which it is,
/// and not all mirrored.
#[inline(always)]
pub(super) fn refract<R: Real>(wo: Vector<R>, h: Vector<R>, eta: R) -> (Vector<R>, R::Mask) {
    let cos = wo.dot(h);
    let cos2_beyond = (eta * eta * (cos * cos).rest()).rest();
    let beyond = cos2_beyond.or_more(cos.all(0.0)).root();
    (h * (eta * cos - beyond) - wo * eta, cos2_beyond.above_all(0.0))
}

#[cfg(test)]
mod tests {
    use super::super::fresnel;
    use super::*;
    use glam::Vec3;

    #[test]
    fn refraction_follows_snell() {
        let through = |w: Vec3, eta: f32| -> Option<Vec3> {
            let (wi, some) = refract(w.into(), Vec3::Z.into(), eta);
            some.then(|| wi.into())
        };
        let wo = Vec3::new(-0.6, 0.0, 0.8);
        let inside = through(wo, 1.0 / 1.5).expect("light enters");
        assert!((inside.x - 0.6 / 1.5).abs() < 1e-6 && inside.z < 0.0, "sines are as the indices: {inside}");
        // From inside, the frame is flipped.
        let over = Vec3::new(1.0, 1.0, -1.0);
        let back = through(inside * over, 1.5).expect("light leaves") * over;
        assert!((back - wo).length() < 1e-6, "and back as it came: {back}");
        assert_eq!(through(wo, 2.0), None, "total reflection");
    }

    #[test]
    fn panes_sum_all_orders() {
        // r + t² r + t² r³ + ...
        let r = fresnel::dielectric(0.8_f32, 1.0 / 1.5);
        let series = r + (1.0 - r).powi(2) * r / (1.0 - r * r);
        assert!((pane(r) - series).abs() < 1e-6, "{} is {series}", pane(r));
    }
}
