// SPDX-License-Identifier: GPL-3.0-or-later
//! Maps from the unit square to directions and points, area-preserving and continuous, and frames to put them in.
//! Source: [SC97] (concentric disk), Malley's method (cosine hemisphere), [Hei19] (triangle), [DBC*17] (frame).
//! Tests: `tests::{hemisphere_follows_the_cosine, triangle_is_uniform, basis_is_orthonormal}`.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::warp_lanes::{concentric_disk_of, cosine_hemisphere_of};

/// A right-handed frame around a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// Unit, perpendicular to the others.
    pub tangent: Vec3,
    /// `normal x tangent`.
    pub bitangent: Vec3,
    /// The vector that it was made around.
    pub normal: Vec3,
}

impl Basis {
    /// Any frame whose third axis is `normal` (unit).
    #[must_use]
    pub fn around(normal: Vec3) -> Self {
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        Self { tangent, bitangent, normal }
    }

    /// The frame around `normal` whose first axis comes closest to `along`; any frame if `along` is zero.
    #[must_use]
    pub fn along(normal: Vec3, along: Vec3) -> Self {
        let flat = along - normal * normal.dot(along);
        let length = flat.length();
        if length > 1e-6 * along.length() && length.is_finite() {
            let tangent = flat / length;
            Self { tangent, bitangent: normal.cross(tangent), normal }
        } else {
            Self::around(normal)
        }
    }

    /// From the frame's coordinates to the world's.
    #[must_use]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }

    /// From the world's coordinates to the frame's.
    #[must_use]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.tangent.dot(v), self.bitangent.dot(v), self.normal.dot(v))
    }
}

/// A direction around +z with density cos / pi per solid angle.
#[must_use]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    cosine_hemisphere_of(u).into()
}

/// A direction to any side, uniform by solid angle.
#[must_use]
pub fn uniform_sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, z).normalize()
}

/// A point of the unit disk, uniform by area.
pub fn concentric_disk(u: [f32; 2]) -> Vec2 {
    concentric_disk_of(u).into()
}

#[cfg(test)]
mod tests {
    use super::super::triangle;
    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::sample_pair;

    fn pairs(n: u32) -> impl Iterator<Item = [f32; 2]> {
        (0..n).map(|sample| sample_pair(0, SampleKey { pixel: 3, sample, branch: 0 }, 0, 0))
    }

    /// Chi-square over 16 x 16 cells of equal probability: rings of cos² and sectors.
    #[test]
    fn hemisphere_follows_the_cosine() {
        const N: u32 = 1 << 16;
        let mut counts = [0.0_f64; 256];
        for u in pairs(N) {
            let d = cosine_hemisphere(u);
            assert!((d.length() - 1.0).abs() < 1e-5 && d.z >= 0.0, "unit and up: {d}");
            let ring = (d.z * d.z * 16.0).min(15.0) as usize;
            let sector = ((d.y.atan2(d.x) / (2.0 * PI) + 0.5) * 16.0).min(15.0) as usize;
            counts[16 * ring + sector] += 1.0;
        }
        let expected = f64::from(N) / 256.0;
        let chi_square: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
        // 255 degrees of freedom: 330 is exceeded by random numbers once in a thousand runs, by stratified ones never.
        assert!(chi_square < 330.0, "chi-square {chi_square}");
    }

    #[test]
    fn triangle_is_uniform() {
        const N: u32 = 1 << 14;
        let mut statistics = [0.0_f64; 5];
        for u in pairs(N) {
            let [a, b] = triangle(u).map(f64::from);
            assert!(a >= 0.0 && b >= 0.0 && a + b <= 1.0 + 1e-6, "inside: {a}, {b}");
            for (statistic, value) in statistics.iter_mut().zip([a, b, a * a, b * b, a * b]) {
                *statistic += value / f64::from(N);
            }
        }
        // Moments of the uniform density over a triangle: 1/3, 1/3, 1/6, 1/6, 1/12.
        for (statistic, exact) in
            statistics.iter().zip([1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 12.0])
        {
            assert!((statistic - exact).abs() < 1e-3, "{statistic} instead of {exact}");
        }
    }

    #[test]
    fn basis_is_orthonormal() {
        for n in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::new(0.6, -0.48, 0.64)] {
            for basis in [Basis::around(n), Basis::along(n, Vec3::new(1.0, 2.0, 3.0)), Basis::along(n, n)] {
                let v = Vec3::new(0.3, -0.7, 0.2);
                assert!((basis.to_local(basis.to_world(v)) - v).length() < 1e-6, "there and back around {n}");
                assert!((basis.to_world(Vec3::Z) - n).length() < 1e-6, "z is the normal");
                assert!((basis.tangent.cross(basis.bitangent) - n).length() < 1e-5, "right-handed");
            }
        }
    }
}
