// SPDX-License-Identifier: GPL-3.0-or-later
//! The unit sphere as the unit square, by an octahedron: only arithmetic that rounds alike on all computers.
//! Source: \[MSS\*10\] (octahedral normal vectors); the ratio of areas follows from the distance of its faces.
//! Tests: `tests`.

use glam::Vec3;

use crate::real::{Real, Vector};

/// The point of the square, in [0, 1], for a unit direction; of one or of many.
#[inline(always)]
pub fn square_of<R: Real>(dir: Vector<R>) -> [R; 2] {
    let (zero, one) = (dir.x.all(0.0), dir.x.all(1.0));
    let p = dir.over(dir.abs().sum());
    let (x, y) = (p.x.size(), p.y.size());
    let below = zero.above(p.z);
    let (x, y) = (R::pick(below, one - y, x), R::pick(below, one - x, y));
    let (x, y) = (R::pick(zero.above(p.x), -x, x), R::pick(zero.above(p.y), -y, y));
    [(x * 0.5 + one.all(0.5)).within(0.0, 1.0), (y * 0.5 + one.all(0.5)).within(0.0, 1.0)]
}

/// The unit direction for a point of the square.
#[must_use]
pub fn direction_of([u, v]: [f32; 2]) -> Vec3 {
    let (x, y) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let (x, y) = if z < 0.0 {
        ((1.0 - y.abs()) * 1.0_f32.copysign(x), (1.0 - x.abs()) * 1.0_f32.copysign(y))
    } else {
        (x, y)
    };
    Vec3::new(x, y, z).normalize_or(Vec3::Z)
}

/// Solid angle over area of the square at a unit direction.
#[must_use]
pub fn stretch(dir: Vec3) -> f32 {
    // The point of the octahedron is `dir / sum`, its distance 1 / sum; faces are sqrt(1/3) away.
    let sum = dir.abs().element_sum();
    4.0 * sum * sum * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::{sample_pair, uniform_sphere};

    #[test]
    fn directions_come_back() {
        for sample in 0..4096 {
            let dir = uniform_sphere(sample_pair(0, SampleKey { pixel: 0, sample, branch: 0 }, 0, 0));
            let square = square_of(Vector::from(dir));
            assert!(square.iter().all(|x: &f32| (0.0..=1.0).contains(x)), "{square:?}");
            assert!((direction_of(square) - dir).length() < 1e-5, "{dir}: {}", direction_of(square));
        }
        let (mut sum, n) = (0.0_f64, 400_u32);
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let square = [i, j].map(|k| (k as f32 + 0.5) / n as f32);
            let dir = direction_of(square);
            assert!((dir.length() - 1.0).abs() < 1e-6, "{square:?} leads to a unit direction");
            sum += f64::from(stretch(dir)) / f64::from(n * n);
        }
        assert!((sum - 4.0 * std::f64::consts::PI).abs() < 1e-3, "the whole square is the sphere: {sum}");
        for dir in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z] {
            assert_eq!(direction_of(square_of(Vector::from(dir))), dir);
        }
    }
}
