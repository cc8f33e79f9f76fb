// SPDX-License-Identifier: GPL-3.0-or-later
//! Phase functions: the directions of light that a medium scatters.
//! Source: \[HG41\]; sampled as in \[PJH23\] section 11.3. Two lobes, for media that scatter back, too.
//! Conventions: `cos` is between the directions in which light travels before and after: 1 = straight on.
//! Invariants: the integral over all directions is 1, and it is the density of `sample`, for one or sixteen.
//! Tests: `tests`.

use std::f32::consts::PI;

use glam::Vec3;

use crate::real::{Real, Vector};
use crate::sampling::{frame_around, sin_cos_of_fraction};

/// Mean cosines nearer to 0 than this count as 0.
const EVEN: f32 = 1e-3;

/// Two lobes of Henyey and Greenstein for each point.
#[derive(Clone, Copy, Debug)]
pub struct Phase<R> {
    /// Mean cosines of both lobes, in (-1, 1).
    pub anisotropy: [R; 2],
    /// Share of the second lobe.
    pub second_share: R,
}

impl<R: Real> Phase<R> {
    /// Density per solid angle of light that is turned by the angle of this cosine.
    #[inline(always)]
    pub fn value(&self, cos: R) -> R {
        let [first, second] = self.anisotropy.map(
            #[inline(always)]
            |g| lobe(g, cos),
        );
        first + (second - first) * self.second_share
    }

    /// A unit direction for light that travels along the unit direction `along`, and its density.
    #[inline(always)]
    pub fn sample(&self, along: Vector<R>, [choice, x, y]: [R; 3]) -> (Vector<R>, R) {
        let [first, second] = self.anisotropy;
        let one = x.all(1.0);
        let g = R::pick(self.second_share.above(choice), second, first);
        let even = x.all(EVEN).above(g.size());
        let divisor = R::pick(even, one, g);
        let s = (one - g * g) / (one - g + g * x * 2.0);
        let cos = R::pick(even, one - x * 2.0, (one + g * g - s * s) / (divisor * 2.0)).within(-1.0, 1.0);
        let sin = (one - cos * cos).or_more(x.all(0.0)).root();
        let (up, right) = sin_cos_of_fraction(y);
        let [tangent, bitangent] = frame_around(along);
        let dir = tangent * (sin * right) + bitangent * (sin * up) + along * cos;
        let dir = dir.normalize();
        (dir, self.value(along.dot(dir)))
    }
}

impl Phase<f32> {
    /// The same of one point.
    #[must_use]
    pub fn value_of(&self, before: Vec3, after: Vec3) -> f32 {
        self.value(before.dot(after))
    }
}

#[inline(always)]
fn lobe<R: Real>(g: R, cos: R) -> R {
    let one = g.all(1.0);
    let wide = (one + g * g - g * cos * 2.0).or_more(g.all(1e-12));
    (one - g * g) / (wide * wide.root() * (4.0 * PI))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::lanes::LANES;
    use crate::sampling::sample_pair;
    use gnurt_simd::{Level, Simd, dispatch, f32x16, prelude::*};

    const ALL: [[f32; 3]; 6] = [
        [0.0, 0.0, 0.0],
        [0.7, 0.0, 0.0],
        [-0.5, 0.0, 0.0],
        [0.9, -0.6, 0.3],
        [1e-4, 0.0, 0.0],
        [0.0, 0.8, 1.0],
    ];

    fn of([a, b, second_share]: [f32; 3]) -> Phase<f32> {
        Phase { anisotropy: [a, b], second_share }
    }

    fn numbers(sample: u32) -> [f32; 3] {
        let pair = |purpose| sample_pair(5, SampleKey { pixel: 1, sample, branch: 0 }, 0, purpose);
        let [[choice, _], [x, y]] = [pair(0), pair(1)];
        [choice, x, y]
    }

    #[inline(always)]
    fn in_lanes<S: Simd>(
        simd: S,
        phase: [f32; 3],
        u: &[[f32; 3]; LANES],
        along: Vec3,
    ) -> [(Vec3, f32); LANES] {
        let [a, b, second_share] = phase.map(|x| f32x16::splat(simd, x));
        let phase = Phase { anisotropy: [a, b], second_share };
        let u = [0, 1, 2].map(|k| f32x16::from_fn(simd, |i| u[i][k]));
        let (dir, pdf) = phase.sample(Vector::all(u[0], along), u);
        std::array::from_fn(|i| (dir.get(i), pdf[i]))
    }

    #[test]
    fn all_light_is_scattered_somewhere() {
        for numbers in ALL {
            let (phase, steps) = (of(numbers), 20_000);
            let cosine = |k: i32| (f64::from(k) + 0.5) / f64::from(steps) * 2.0 - 1.0;
            let sum: f64 = (0..steps).map(|k| f64::from(phase.value(cosine(k) as f32))).sum();
            let all = sum * 2.0 / f64::from(steps) * std::f64::consts::TAU;
            assert!((all - 1.0).abs() < 1e-4, "{numbers:?}: {all}");
            let mean: f64 = (0..steps).map(|k| cosine(k) * f64::from(phase.value(cosine(k) as f32))).sum();
            let mean = mean * 2.0 / f64::from(steps) * std::f64::consts::TAU;
            let [a, b, share] = numbers.map(f64::from);
            assert!((mean - (a + (b - a) * share)).abs() < 1e-4, "{numbers:?}: mean cosine {mean}");
        }
    }

    #[test]
    fn light_goes_both_ways_alike() {
        for numbers in ALL {
            for k in 0..100 {
                let [a, b] = [0, 1]
                    .map(|n| crate::sampling::uniform_sphere(sample_pair(n, SampleKey::default(), k, 0)));
                let there_and_back = [of(numbers).value_of(a, b), of(numbers).value_of(-b, -a)];
                assert!((there_and_back[0] - there_and_back[1]).abs() < 1e-6 * there_and_back[0]);
            }
        }
    }

    /// Chi-square over 16 rings and 8 sectors, and the same bits at every level.
    #[test]
    fn samples_follow_the_density_at_every_level() {
        const N: u32 = 1 << 15;
        let along = Vec3::new(0.48, -0.6, 0.64);
        for phase in ALL {
            let mut counts = [0.0_f64; 128];
            let basis = crate::sampling::Basis::around(along);
            for first in (0..N).step_by(LANES) {
                let u: [_; LANES] = std::array::from_fn(|i| numbers(first + i as u32));
                let expected = u.map(|u| of(phase).sample(along.into(), u));
                let levels = if first < 512 { Level::available() } else { vec![] };
                for level in levels {
                    let found = dispatch!(level, simd => in_lanes(simd, phase, &u, along));
                    for ((dir, pdf), (found, of_lanes)) in expected.iter().zip(found) {
                        assert_eq!((Vec3::from(*dir), *pdf), (found, of_lanes), "{phase:?} at {level}");
                    }
                }
                for (dir, pdf) in expected {
                    let dir = Vec3::from(dir);
                    assert!((dir.length() - 1.0).abs() < 1e-5 && pdf > 0.0);
                    let local = basis.to_local(dir);
                    let ring = ((local.z * 0.5 + 0.5) * 16.0).clamp(0.0, 15.0) as usize;
                    let turn = local.y.atan2(local.x) / (2.0 * PI) + 0.5;
                    counts[8 * ring + (turn * 8.0).min(7.0) as usize] += 1.0;
                }
            }
            let mut chi_square = 0.0;
            for (cell, count) in counts.iter().enumerate() {
                let steps = 2000;
                let cosine =
                    |k: i32| ((f64::from(k) + 0.5) / f64::from(steps) + (cell / 8) as f64) / 8.0 - 1.0;
                let mean: f64 = (0..steps).map(|k| f64::from(of(phase).value(cosine(k) as f32))).sum();
                let expected = f64::from(N) * mean / f64::from(steps) / 8.0 * std::f64::consts::TAU / 8.0;
                chi_square += (count - expected).powi(2) / expected.max(1.0);
            }
            assert!(chi_square < 180.0, "{phase:?}: chi-square {chi_square} of 127");
        }
    }
}
