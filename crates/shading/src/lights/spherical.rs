// SPDX-License-Identifier: GPL-3.0-or-later
//! Points on a triangle, uniform by the solid angle in which it is seen: near a large lamp they vary less in brightness than
//! points uniform by area.
//! Source: [Arv95] as in [PJH23] section 6.5.4. Space: corners relative to the viewer. Tests: `tests`.

use std::f32::consts::PI;

use glam::Vec3;

/// Solid angles below are sampled by area: that is as good, and exact. So are those near a hemisphere's, seen from a point on
/// the triangle.
const LEAST: f32 = 0.02;
const MOST: f32 = 6.0;
/// A triangle is looked at if the square of the distance to its nearest corner or centre is below its area times this.
const NEAR: f32 = 8.0;

/// The solid angle of a triangle of this area, where its points are to be uniform by that; `None` where by area.
pub(super) fn wide_angle(corners: [Vec3; 3], area: f32) -> Option<f32> {
    let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
    let nearest =
        corners.iter().fold(centre.length_squared(), |least, corner| least.min(corner.length_squared()));
    if nearest >= NEAR * area {
        return None;
    }
    let [a, b, c] = corners.map(Vec3::normalize);
    // [vOS83]
    let angle = 2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
    (LEAST..MOST).contains(&angle).then_some(angle)
}

/// Barycentric weights of the second and third corner for two numbers in [0, 1).
pub(super) fn sample(corners: [Vec3; 3], u: [f32; 2]) -> [f32; 2] {
    let [a, b, c] = corners.map(Vec3::normalize);
    // Normals of the planes through the edges, and the angles between these planes.
    let [ab, bc, ca] = [a.cross(b), b.cross(c), c.cross(a)].map(Vec3::normalize_or_zero);
    let angle = |from: Vec3, to: Vec3| (-from.dot(to)).clamp(-1.0, 1.0).acos();
    let [alpha, beta, gamma] = [angle(ab, ca), angle(bc, ab), angle(ca, bc)];
    // A part of the triangle, with the same angle at a.
    let part = PI + u[0] * (alpha + beta + gamma - PI);
    let ((sin, cos), (sin_alpha, cos_alpha)) = (part.sin_cos(), alpha.sin_cos());
    let sin_phi = sin * cos_alpha - cos * sin_alpha;
    let cos_phi = cos * cos_alpha + sin * sin_alpha;
    let (k1, k2) = (cos_phi + cos_alpha, sin_phi - sin_alpha * a.dot(b));
    let cos_b =
        (k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / ((k2 * sin_phi + k1 * cos_phi) * sin_alpha);
    let cos_b = if cos_b.is_finite() { cos_b.clamp(-1.0, 1.0) } else { 1.0 };
    let beside = |v: Vec3, along: Vec3| (v - along * v.dot(along)).normalize_or_zero();
    let third = cos_b * a + (1.0 - cos_b * cos_b).max(0.0).sqrt() * beside(c, a);
    // A point between b and the part's third corner.
    let cos_theta = 1.0 - u[1] * (1.0 - third.dot(b));
    let dir = cos_theta * b + (1.0 - cos_theta * cos_theta).max(0.0).sqrt() * beside(third, b);
    // Where that direction meets the triangle.
    let (e1, e2) = (corners[1] - corners[0], corners[2] - corners[0]);
    let s1 = dir.cross(e2);
    let divisor = s1.dot(e1);
    let (s, scale) = (-corners[0], 1.0 / divisor);
    let weights = [s.dot(s1) * scale, dir.dot(s.cross(e1)) * scale];
    if !weights.iter().all(|weight| weight.is_finite()) {
        return [1.0 / 3.0; 2];
    }
    // Inside, whatever the rounding.
    let [b1, b2] = weights.map(|weight| weight.clamp(0.0, 1.0));
    let sum = (b1 + b2).max(1.0);
    [b1 / sum, b2 / sum]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::sample_pair;

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
            let found = wide_angle(corners, area(corners)).expect("it is wide");
            let expected = by_quadrature(corners);
            assert!((f64::from(found) / expected - 1.0).abs() < 2e-3, "{corners:?}: {found}, not {expected}");
        }
        let far = triangles()[0].map(|corner| corner + Vec3::Z * 20.0);
        assert_eq!(wide_angle(far, area(far)), None, "small ones are sampled by area");
        let edge_on = [Vec3::X, 2.0 * Vec3::X, Vec3::new(1.0, 1.0, 0.0)];
        assert_eq!(wide_angle(edge_on, area(edge_on)), None, "and those seen from the side");
    }

    /// Means over samples are integrals over the solid angle: of the area density, which is 1 over the area, and of a direction.
    #[test]
    fn points_are_uniform_by_solid_angle() {
        for corners in triangles() {
            let angle = wide_angle(corners, area(corners)).expect("it is wide");
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a).normalize();
            const N: u32 = 1 << 15;
            let (mut total, mut means) = (0.0_f64, [0.0_f64; 2]);
            for sample in 0..N {
                let u = sample_pair(0, SampleKey { pixel: 1, sample, branch: 0 }, 0, 0);
                let [b1, b2] = super::sample(corners, u);
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
