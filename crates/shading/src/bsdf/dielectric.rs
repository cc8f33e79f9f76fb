// SPDX-License-Identifier: GPL-3.0-or-later
//! Smooth glass: Fresnel's shares mirrored and refracted.
//! Source: [PJH23] sections 9.3 (Fresnel, Snell) and 9.5.1 (thin panes: all reflections between the two faces summed).
//! Space: the shading frame. Radiance is not scaled by the square of the index: see `bsdf`.
//! Proof: `tests::refraction_follows_snell`, `tests` of `bsdf`.

use glam::Vec3;

use super::{BsdfSample, fresnel};

/// Smooth glass as one side of it is met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction on the side that rays come from over the index beyond, > 0.
    pub eta: f32,
    /// Tint of what is mirrored, in [0, 1].
    pub reflectance: Vec3,
    /// Tint of what goes through, in [0, 1].
    pub transmittance: Vec3,
    /// Whether it is a pane so thin that what enters leaves at the same place, unbent.
    pub thin: bool,
}

impl Dielectric {
    /// What is mirrored and what goes through, each with its share of the light; `None` where that is nothing.
    pub(crate) fn branches(&self, wo: Vec3) -> [Option<BsdfSample>; 2] {
        let (share, through) = if self.thin {
            let once = fresnel::dielectric(wo.z, self.eta.min(1.0 / self.eta));
            (pane(once), Some(-wo))
        } else {
            (fresnel::dielectric(wo.z, self.eta), refract(wo, self.eta))
        };
        let branch = |wi, weight: Vec3, transmitted| {
            (weight != Vec3::ZERO).then_some(BsdfSample {
                wi,
                weight,
                pdf: f32::INFINITY,
                delta: true,
                transmitted,
            })
        };
        let mirrored = branch(Vec3::new(-wo.x, -wo.y, wo.z), self.reflectance * share, false);
        [mirrored, through.and_then(|wi| branch(wi, self.transmittance * (1.0 - share), true))]
    }

    pub(super) fn sample(&self, wo: Vec3, u: f32) -> Option<BsdfSample> {
        match self.branches(wo) {
            [Some(mirrored), Some(through)] => {
                let [a, b] = [mirrored, through].map(|s| s.weight.element_sum());
                let share = a / (a + b);
                if u < share {
                    Some(BsdfSample { weight: mirrored.weight / share, ..mirrored })
                } else {
                    Some(BsdfSample { weight: through.weight / (1.0 - share), ..through })
                }
            }
            [a, b] => a.or(b),
        }
    }

    pub(super) fn albedo(&self, wo: Vec3) -> Vec3 {
        self.branches(wo).iter().flatten().map(|s| s.weight).sum()
    }
}

/// What a pane mirrors whose faces each mirror `once`: all orders of reflection between them.
pub(super) fn pane(once: f32) -> f32 {
    2.0 * once / (1.0 + once)
}

/// `w` (z > 0) refracted at the plane z = 0; `None` if all is mirrored.
pub(super) fn refract(w: Vec3, eta: f32) -> Option<Vec3> {
    let cos2_beyond = 1.0 - eta * eta * (1.0 - w.z * w.z);
    (cos2_beyond > 0.0).then(|| Vec3::new(-eta * w.x, -eta * w.y, -cos2_beyond.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_follows_snell() {
        let wo = Vec3::new(-0.6, 0.0, 0.8);
        let inside = refract(wo, 1.0 / 1.5).expect("light enters");
        assert!((inside.x - 0.6 / 1.5).abs() < 1e-6 && inside.z < 0.0, "sines are as the indices: {inside}");
        // Seen from inside, the frame is turned over.
        let over = Vec3::new(1.0, 1.0, -1.0);
        let back = refract(inside * over, 1.5).expect("light leaves") * over;
        assert!((back - wo).length() < 1e-6, "and back as it came: {back}");
        assert_eq!(refract(wo, 2.0), None, "total reflection");
    }

    #[test]
    fn panes_keep_all_light_and_do_not_bend_it() {
        let pane =
            Dielectric { eta: 1.0 / 1.5, reflectance: Vec3::ONE, transmittance: Vec3::ONE, thin: true };
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let [mirrored, through] = pane.branches(wo).map(|s| s.expect("both happen"));
        assert!((mirrored.weight + through.weight - Vec3::ONE).length() < 1e-6, "nothing is lost");
        assert_eq!(through.wi, -wo, "straight on");
        // The sum of all orders: r + t² r + t² r³ + ...
        let r = fresnel::dielectric(0.8, 1.0 / 1.5);
        let series = r + (1.0 - r).powi(2) * r / (1.0 - r * r);
        assert!((mirrored.weight.x - series).abs() < 1e-6, "{} is {series}", mirrored.weight.x);
    }
}
