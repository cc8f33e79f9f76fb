// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres that emit outwards: what one brings about, and directions to it, from one point or sixteen.
//! Source: [PJH23] section 6.2.4 (the cone in which a sphere is seen). Space: world.
//! A place on a sphere is its normal, as a point of the square of `octahedron`.
//! Invariant: the same bits for one point as for sixteen. Tests: `tests`, `light_set_tests`.

use std::f32::consts::FRAC_1_PI;

use super::light_estimates::Aim;
use crate::real::{Real, Vector};
use crate::sampling::octahedron::square_of;
use crate::sampling::{frame_around, sin_cos_of_fraction};

/// A sphere, as [`Shape`](super::shape::Shape).
#[derive(Clone, Copy)]
pub(super) struct SphereAt<R: Real> {
    pub(super) center: Vector<R>,
    pub(super) radius: R,
    /// The brightest intensity: radiance times the area of its disc.
    pub(super) power: R,
}

/// A sphere from a point.
struct Seen<R: Real> {
    /// To the centre.
    offset: Vector<R>,
    distance2: R,
    distance: R,
    /// One less the cosine of half the angle in which it is seen.
    width: R,
    /// The points outside; others see none of its light.
    outside: R::Mask,
}

impl<R: Real> SphereAt<R> {
    #[inline(always)]
    fn seen(&self, p: Vector<R>) -> Seen<R> {
        let one = p.x.all(1.0);
        let offset = self.center - p;
        let distance2 = offset.length_squared();
        let radius2 = self.radius * self.radius;
        let sine2 = radius2 / distance2;
        let width = sine2 / (one + (one - sine2).or_more(one.all(0.0)).root());
        Seen { offset, distance2, distance: distance2.root(), width, outside: distance2.above(radius2) }
    }

    /// The irradiance of surfaces at `p` if nothing is between, by brightness; a guess where the horizon of `normal` cuts the sphere.
    /// Exactly 0 where there is none. Points without normals have no horizon.
    #[inline(always)]
    pub(super) fn contribution(&self, p: Vector<R>, normal: Option<Vector<R>>) -> R {
        let zero = p.x.all(0.0);
        let Seen { offset, distance2, distance, outside, .. } = self.seen(p);
        let (mut lit, mut contribution) = (outside, self.power / distance2);
        if let Some(normal) = normal {
            let height = normal.dot(offset);
            let highest = height + self.radius;
            // As the height where the horizon touches the sphere from below, and nothing where it does from above.
            let in_part = highest * highest / (self.radius * 4.0);
            let above = R::pick(height.above(self.radius), height, in_part);
            contribution = contribution * (above / distance);
            lit = lit & highest.above(zero);
        }
        let sound = contribution.or_more(zero.all(f32::MIN_POSITIVE));
        let contribution = R::pick(contribution.is_number(), sound, zero.all(f32::MAX.sqrt()));
        R::pick(lit, contribution, zero)
    }

    /// A point of it for two numbers in [0, 1), uniform by the solid angle in which it is seen from `p`. It is short of the
    /// sphere by its rounding error.
    #[inline(always)]
    pub(super) fn aim(&self, p: Vector<R>, u: [R; 2]) -> Aim<R> {
        let (zero, one) = (p.x.all(0.0), p.x.all(1.0));
        let seen = self.seen(p);
        let less = u[0] * seen.width;
        let sine2 = less * (one.all(2.0) - less);
        let along = seen.offset.over(seen.distance);
        let [side, up] = frame_around(along);
        let (sin, cos) = sin_cos_of_fraction(u[1]);
        let around = (side * cos + up * sin) * sine2.root();
        let dir = along * (one - less) + around;
        let half = (self.radius * self.radius - seen.distance2 * sine2).or_more(zero).root();
        let at = dir * (seen.distance * (one - less) - half);
        let normal = (at - seen.offset).normalize();
        // On the sphere, and off it.
        let reach = self.center.abs().max(p.abs()).max_element() + self.radius;
        let offset = seen.offset + normal * (self.radius + reach * (16.0 * f32::EPSILON));
        let dist = offset.length_squared().root();
        let density = R::pick(seen.outside, one / seen.width * (0.5 * FRAC_1_PI), zero);
        Aim { position: square_of(normal), dir: offset.over(dist), dist, density }
    }

    /// Density per solid angle at `p` of the point that lies along the unit `dir`, `dist` away; 0 from inside, and of the inside.
    #[inline(always)]
    pub(super) fn density(&self, p: Vector<R>, dir: Vector<R>, dist: R) -> R {
        let (zero, seen) = (p.x.all(0.0), self.seen(p));
        // Past the middle, by more than rounding.
        let past = dist - seen.offset.dot(dir);
        let inside = past.above(self.radius * 0.01 + seen.distance * (32.0 * f32::EPSILON));
        R::pick(seen.outside & !inside, zero.all(0.5 * FRAC_1_PI) / seen.width, zero)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::octahedron::direction_of;
    use crate::sampling::sample_pair;

    /// Points are on the sphere, on the side of the viewer, and all of that side is covered evenly by angle.
    #[test]
    fn points_are_uniform_by_solid_angle() {
        const N: u32 = 1 << 14;
        let p = Vec3::new(0.3, -1.0, 2.0);
        for (center, radius) in [
            (Vec3::new(1.0, 2.0, 3.0), 0.5),
            (Vec3::new(0.3, -1.0, 0.9), 1.05),
            (Vec3::new(90.0, 5.0, 2.0), 0.1),
        ] {
            let sphere = SphereAt { center: center.into(), radius, power: 1.0 };
            let offset = center - p;
            let sine2 = f64::from(radius * radius / offset.length_squared());
            let angle = std::f64::consts::TAU * (1.0 - (1.0 - sine2).sqrt());
            let (mut cosines, mut mean) = (0.0_f64, Vec3::ZERO);
            for sample in 0..N {
                let u = sample_pair(0, SampleKey { pixel: 1, sample, branch: 0 }, 0, 0);
                let Aim { position, dir, dist, density } = sphere.aim(p.into(), u);
                let dir = Vec3::from(dir);
                let on = p + dir * dist - center;
                assert!((on.length() / radius - 1.0).abs() < 3e-3, "{center}: {}", on.length());
                assert!(on.length() >= radius, "{center}: not short of it");
                assert!(on.dot(dir) <= 0.05 * radius, "{center}: the near side");
                assert!((direction_of(position) - on.normalize()).length() < 2e-3, "{center}: its place");
                assert!((f64::from(density) * angle - 1.0).abs() < 1e-4, "{center}: density {density}");
                assert_eq!(density, sphere.density(p.into(), dir.into(), dist), "{center}");
                cosines += f64::from(dir.dot(offset.normalize())) / f64::from(N);
                mean += dir / N as f32;
            }
            let expected = 0.5 * (1.0 + (1.0 - sine2).sqrt());
            assert!((cosines - expected).abs() < 2e-4, "{center}: mean cosine {cosines}, not {expected}");
            assert!(mean.normalize().dot(offset.normalize()) > 1.0 - 1e-4, "{center}: all around");
        }
    }

    #[test]
    fn inside_there_is_no_light() {
        let sphere = SphereAt { center: Vector::from(Vec3::X), radius: 2.0, power: 1.0 };
        let origin = Vector::from(Vec3::ZERO);
        assert_eq!(sphere.contribution(origin, None), 0.0);
        assert_eq!(sphere.aim(origin, [0.3, 0.6]).density, 0.0);
        assert_eq!(sphere.density(origin, Vector::from(Vec3::Z), 1.0), 0.0);
        // The far side is seen from inside, through a near side that is not there.
        let outside = Vector::from(Vec3::new(-3.0, 0.0, 0.0));
        assert!(sphere.density(outside, Vector::from(Vec3::X), 2.0) > 0.0);
        assert_eq!(sphere.density(outside, Vector::from(Vec3::X), 6.0), 0.0);
    }

    #[test]
    fn contributions_end_at_the_horizon() {
        let sphere = SphereAt { center: Vector::from(Vec3::ZERO), radius: 0.5, power: 3.0 };
        let at = |height: f32| {
            sphere.contribution(Vector::from(Vec3::new(4.0, 0.0, -height)), Some(Vector::from(Vec3::Z)))
        };
        assert!(
            (at(2.0) - 3.0 / 20.0 * 2.0 / 20.0_f32.sqrt()).abs() < 1e-6,
            "whole: intensity, cosine and distance"
        );
        assert!((at(0.5001) / at(0.4999) - 1.0).abs() < 1e-3, "without a step where the horizon touches it");
        assert!(at(0.0) > 0.0 && at(-0.49) > 0.0 && at(-0.49) < 1e-3 * at(0.0));
        assert_eq!(at(-0.501), 0.0);
    }
}
