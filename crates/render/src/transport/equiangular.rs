// SPDX-License-Identifier: GPL-3.0-or-later
//! Distances along a ray by the angle at which a point is seen from it: where a lamp is near, its light on a medium changes
//! faster than the medium's density.
//! Source: [KF12], section 4. Space: world; parameters of the ray, whose direction is a unit vector.
//! Invariant: `density` integrates to 1 over the span. Tests: `tests`, crates/render/tests/media.rs.

use glam::Vec3;

/// Closest distance of a ray from the point, as a share of the point's distance from the origin.
const LEAST: f32 = 1e-3;

/// A point near a ray, and a stretch of that ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Equiangular {
    /// Where the ray is closest to the point, and how close; the latter has a lower bound.
    middle: f32,
    height: f32,
    /// Angle between the normal of the ray and the beginning of the stretch, and the angle of the stretch.
    first: f32,
    angle: f32,
}

impl Equiangular {
    /// `None` if the stretch is seen at no angle, or comes no nearer than `most`. Its end may be infinite.
    pub(super) fn new(
        (org, dir): (Vec3, Vec3),
        point: Vec3,
        [begin, end]: [f32; 2],
        most: f32,
    ) -> Option<Self> {
        let offset = point - org;
        let middle = offset.dot(dir);
        let height = (offset - dir * middle).length().max(LEAST * offset.length());
        if distance(middle, height, [begin, end]) >= most {
            return None;
        }
        let [first, last] = [begin, end].map(|t| ((t - middle) / height).atan());
        let angle = last - first;
        (height > 0.0 && angle > 0.0 && middle.is_finite()).then_some(Self { middle, height, first, angle })
    }

    /// How close a stretch of the ray comes to the point.
    pub(super) fn closest(&self, span: [f32; 2]) -> f32 {
        distance(self.middle, self.height, span)
    }

    /// A parameter of the ray.
    pub(super) fn sample(&self, u: f32) -> f32 {
        self.middle + self.height * (self.first + self.angle * u).tan()
    }

    /// Density per length of the parameter `t` of the stretch.
    pub(super) fn density(&self, t: f32) -> f32 {
        let away = (t - self.middle) / self.height;
        1.0 / (self.angle * self.height * (1.0 + away * away))
    }
}

/// How close a stretch of a ray comes to a point.
fn distance(middle: f32, height: f32, [begin, end]: [f32; 2]) -> f32 {
    let along = middle.clamp(begin, end) - middle;
    (along * along + height * height).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_follow_the_density() {
        let ray = (Vec3::new(1.0, 0.0, -2.0), Vec3::new(0.6, 0.0, 0.8));
        for (point, span) in [
            (Vec3::new(2.0, 0.3, 1.0), [0.0, 6.0]),
            (Vec3::new(-4.0, 1.0, 1.0), [0.5, 2.0]),
            (Vec3::new(2.0, 0.5, 1.0), [0.0, f32::INFINITY]),
            // On the ray itself.
            (ray.0 + ray.1 * 2.0, [0.0, 3.0]),
        ] {
            let found = Equiangular::new(ray, point, span, f32::INFINITY).expect("an angle");
            let far = span[1].min(1e3);
            // The share of samples before a parameter is the integral of the density up to there.
            for k in 1..20 {
                let u = k as f32 / 20.0;
                let t = found.sample(u);
                assert!(t >= span[0] && t <= far, "{t} of {span:?}");
                let steps = 20_000;
                let width = (t - span[0]) / steps as f32;
                let integral: f64 = (0..steps)
                    .map(|i| f64::from(found.density(span[0] + (i as f32 + 0.5) * width)) * f64::from(width))
                    .sum();
                assert!((integral - f64::from(u)).abs() < 2e-3, "{point} {u}: {integral}");
            }
        }
        let beside = Equiangular::new((Vec3::ZERO, Vec3::X), Vec3::new(2.0, 3.0, 0.0), [6.0, 9.0], 5.5)
            .expect("an angle");
        assert_eq!(beside.closest([6.0, 9.0]), 5.0);
        assert!(Equiangular::new(ray, ray.0, [1.0, 1.0], 9.0).is_none(), "an empty stretch");
        let far = Equiangular::new((Vec3::ZERO, Vec3::X), Vec3::new(2.0, 3.0, 0.0), [6.0, 9.0], 4.5);
        assert!(far.is_none(), "too far");
    }
}
