// SPDX-License-Identifier: GPL-3.0-or-later
//! Points on a triangle, uniform by the solid angle in which it is seen: near a large lamp they vary less in brightness than
//! points uniform by area.
//! Source: [Arv95] as in [PJH23] section 6.5.4. Space: corners relative to the viewer. Tests: `tests`.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use crate::real::{Real, Vector};
use crate::sampling::sin_cos_of_fraction;

/// Solid angles below are sampled by area: that is as good, and exact. So are those near a hemisphere's, seen from a point on
/// the triangle.
const LEAST: f32 = 0.02;
const MOST: f32 = 6.0;
/// A triangle is looked at if the square of the distance to its nearest corner or centre is below its area times this.
const NEAR: f32 = 8.0;

/// The solid angle of a triangle of this area, in the points where samples are to be uniform by that; in others by area.
#[inline(always)]
pub(super) fn wide_angle<R: Real>(corners: [Vector<R>; 3], area: R) -> (R::Mask, R) {
    let centre = (corners[0] + corners[1] + corners[2]).over(area.all(3.0));
    let nearest = centre.length_squared().or_less(corners[0].length_squared());
    let nearest = nearest.or_less(corners[1].length_squared()).or_less(corners[2].length_squared());
    let near = (area * NEAR).above(nearest) & nearest.above_all(0.0);
    if !R::any(near) {
        return (near, area.all(0.0));
    }
    let [a, b, c] = unit(corners);
    // [vOS83]
    let angle = arc(a.dot(b.cross(c)).size(), a.dot(b) + b.dot(c) + c.dot(a) + area.all(1.0)) * 2.0;
    (near & !angle.all(LEAST).above(angle) & angle.all(MOST).above(angle), angle)
}

/// The angle of a point above the x axis, from 0 to pi.
#[inline(always)]
fn arc<R: Real>(y: R, x: R) -> R {
    let across = x.size();
    let tangent = across.or_less(y) / across.or_more(y);
    // Within an eighth of a half circle, where seven terms of Taylor's series are enough for floats.
    let large = tangent.above_all(std::f32::consts::SQRT_2 - 1.0);
    let one = x.all(1.0);
    let t = R::pick(large, (tangent - one) / (tangent + one), tangent);
    let t2 = t * t;
    let series = (t2 * (1.0 / 13.0) + one.all(-1.0 / 11.0)) * t2 + one.all(1.0 / 9.0);
    let series = ((series * t2 + one.all(-1.0 / 7.0)) * t2 + one.all(1.0 / 5.0)) * t2 + one.all(-1.0 / 3.0);
    let angle = t + t * (series * t2);
    let angle = R::pick(large, angle + one.all(FRAC_PI_4), angle);
    let angle = R::pick(y.above(across), one.all(FRAC_PI_2) - angle, angle);
    R::pick(one.all(0.0).above(x), one.all(std::f32::consts::PI) - angle, angle)
}

/// Barycentric weights of the second and third corner for two numbers in [0, 1), of triangles with this solid angle.
#[inline(always)]
pub(super) fn sample<R: Real>(corners: [Vector<R>; 3], angle: R, u: [R; 2]) -> [R; 2] {
    let (zero, one) = (angle.all(0.0), angle.all(1.0));
    let nothing = Vector::grey(zero);
    let [a, b, c] = unit(corners);
    // Normals of the planes through the edges at a, and the angle between these planes.
    let (ab, ca) = (a.cross(b).normalize_or(nothing), c.cross(a).normalize_or(nothing));
    let (sin_alpha, cos_alpha) = (ab.cross(ca).length_squared().root(), -ab.dot(ca));
    // A part of the triangle, with the same angle at a: its angles add up to half a circle and this.
    let (sin, cos) = sin_cos_of_fraction(u[0] * angle * (1.0 / TAU));
    let sin_phi = cos * sin_alpha - sin * cos_alpha;
    let cos_phi = -(cos * cos_alpha + sin * sin_alpha);
    let (k1, k2) = (cos_phi + cos_alpha, sin_phi - sin_alpha * a.dot(b));
    let cos_b =
        (k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / ((k2 * sin_phi + k1 * cos_phi) * sin_alpha);
    let cos_b = R::pick(cos_b.is_number(), cos_b, one).within(-1.0, 1.0);
    let third = a * cos_b + beside(c, a, nothing) * sine(cos_b);
    // A point between b and the part's third corner.
    let cos_theta = one - u[1] * (one - third.dot(b));
    let dir = b * cos_theta + beside(third, b, nothing) * sine(cos_theta);
    // Where that direction meets the triangle.
    let (e1, e2) = (corners[1] - corners[0], corners[2] - corners[0]);
    let s1 = dir.cross(e2);
    let scale = one / s1.dot(e1);
    let s = -corners[0];
    let weights = [s.dot(s1) * scale, dir.dot(s.cross(e1)) * scale];
    let sound = weights[0].is_number() & weights[1].is_number();
    // Inside, whatever the rounding.
    let middle = angle.all(1.0 / 3.0);
    let b1 = R::pick(sound, weights[0], middle).within(0.0, 1.0);
    let b2 = R::pick(sound, weights[1], middle).within(0.0, 1.0);
    let sum = (b1 + b2).or_more(one);
    [b1 / sum, b2 / sum]
}

// Written out: closures of arrays' `map` become calls.
#[inline(always)]
fn unit<R: Real>([a, b, c]: [Vector<R>; 3]) -> [Vector<R>; 3] {
    [a.normalize(), b.normalize(), c.normalize()]
}

/// The unit vector in the plane of both at a right angle to `along`, which is unit; or `nothing`.
#[inline(always)]
fn beside<R: Real>(v: Vector<R>, along: Vector<R>, nothing: Vector<R>) -> Vector<R> {
    (v - along * v.dot(along)).normalize_or(nothing)
}

#[inline(always)]
fn sine<R: Real>(cosine: R) -> R {
    (cosine.all(1.0) - cosine * cosine).or_more(cosine.all(0.0)).root()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::sample_pair;

    /// The solid angle where samples are uniform by it.
    fn angle_of(corners: [Vec3; 3]) -> Option<f32> {
        let (wide, angle) = wide_angle(corners.map(Vector::from), area(corners));
        wide.then_some(angle)
    }

    #[test]
    fn arcs_are_angles() {
        let mut worst = 0.0_f64;
        for i in 0..=100_000 {
            let angle = f64::from(i) * std::f64::consts::PI / 1e5;
            let (y, x) = (angle.sin() as f32, angle.cos() as f32);
            let expected = f64::from(y.abs()).atan2(f64::from(x));
            worst = worst.max((f64::from(arc(y.abs(), x)) - expected).abs());
        }
        assert!(worst < 4e-7, "{worst}");
        assert_eq!((arc(0.0, 1.0), arc(0.0, -1.0)), (0.0, std::f32::consts::PI));
    }

    /// Triangles of 0.02 to 4 sr, with long and short edges.
    fn triangles() -> [[Vec3; 3]; 4] {
        [
            [Vec3::new(-1.0, -1.0, 1.0), Vec3::new(1.0, -1.0, 1.0), Vec3::new(-1.0, 1.0, 1.0)],
            [Vec3::new(-9.0, -1.0, 0.3), Vec3::new(8.0, -2.0, 0.3), Vec3::new(0.0, 7.0, 0.3)],
            [Vec3::new(0.2, 1.0, 0.6), Vec3::new(0.9, 1.4, 0.7), Vec3::new(0.3, 1.2, 1.6)],
            [Vec3::new(0.1, 0.1, -0.5), Vec3::new(3.0, 0.0, -0.6), Vec3::new(0.0, 0.4, -0.4)],
        ]
    }

    fn area([a, b, c]: [Vec3; 3]) -> f32 {
        0.5 * (b - a).cross(c - a).length()
    }

    /// The integral of cos over distance squared over the area.
    fn by_quadrature([a, b, c]: [Vec3; 3]) -> f64 {
        const STEPS: u32 = 1500;
        let normal = (b - a).cross(c - a).normalize();
        let cell = f64::from(area([a, b, c])) / f64::from(STEPS * STEPS);
        let mut sum = 0.0;
        for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS - i).map(move |j| (i, j))) {
            for third in [1.0, 2.0].into_iter().take(if i + j + 1 < STEPS { 2 } else { 1 }) {
                let [u, v] = [i, j].map(|k| (k as f32 + third / 3.0) / STEPS as f32);
                let at = a + (b - a) * u + (c - a) * v;
                let distance2 = at.length_squared();
                sum += f64::from(normal.dot(at).abs() / (distance2 * distance2.sqrt())) * cell;
            }
        }
        sum
    }

    #[test]
    fn angles_are_integrals() {
        for corners in triangles() {
            let found = angle_of(corners).expect("it is wide");
            let expected = by_quadrature(corners);
            assert!((f64::from(found) / expected - 1.0).abs() < 2e-3, "{corners:?}: {found}, not {expected}");
        }
        let far = triangles()[0].map(|corner| corner + Vec3::Z * 20.0);
        assert_eq!(angle_of(far), None, "small ones are sampled by area");
        let edge_on = [Vec3::X, 2.0 * Vec3::X, Vec3::new(1.0, 1.0, 0.0)];
        assert_eq!(angle_of(edge_on), None, "and those seen from the side");
    }

    /// Means over samples are integrals over the solid angle: of the area density, which is 1 over the area, and of a direction.
    #[test]
    fn points_are_uniform_by_solid_angle() {
        for corners in triangles() {
            let angle = angle_of(corners).expect("it is wide");
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a).normalize();
            const N: u32 = 1 << 15;
            let (mut total, mut means) = (0.0_f64, [0.0_f64; 2]);
            for sample in 0..N {
                let u = sample_pair(0, SampleKey { pixel: 1, sample, branch: 0 }, 0, 0);
                let [b1, b2] = super::sample(corners.map(Vector::from), angle, u);
                assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 + 1e-6, "inside: {b1}, {b2}");
                let at = a + (b - a) * b1 + (c - a) * b2;
                let distance2 = at.length_squared();
                // From solid angle to area.
                let to_area = f64::from(distance2 * distance2.sqrt() / normal.dot(at).abs());
                total += to_area * f64::from(angle) / f64::from(N);
                means[0] += to_area * f64::from(angle * b1) / f64::from(N);
                means[1] += to_area * f64::from(angle * b2) / f64::from(N);
            }
            let area = f64::from(area(corners));
            assert!((total / area - 1.0).abs() < 0.01, "{corners:?}: area {total}, not {area}");
            for mean in means {
                assert!((mean / area * 3.0 - 1.0).abs() < 0.02, "{corners:?}: moment {mean} of {area}");
            }
        }
    }
}
