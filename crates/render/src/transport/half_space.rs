// SPDX-License-Identifier: GPL-3.0-or-later
//! Directions and distances of walks below a surface that lead back to it: those of light in a half space.
//! Source: [KD14] (Dwivedi's sampling), with the plain densities in the choice [MHD16]. Deep in a half space light decreases
//! with the depth, by a diffusion length; a walk that is drawn towards the surface in this proportion leaves with nearly
//! the same weight, wherever it was.
//! Conventions: `cos` is between a direction and the normal of the plane, outwards; lengths are mean free paths.
//! Tests: `tests`.

use std::f32::consts::TAU;

use glam::Vec3;
use gnurt_shading::sampling::Basis;

/// A half space whose scattering is even, by channel.
#[derive(Clone, Copy)]
pub(super) struct HalfSpace {
    /// Its normal, outwards.
    normal: Vec3,
    /// Mean free paths over diffusion lengths, in (0, 1).
    decrease: Vec3,
    /// What makes the densities of cosines integrate to 1.
    scale: Vec3,
}

impl HalfSpace {
    /// That of scattering with these albedos, in [0, 1].
    pub(super) fn new(normal: Vec3, albedo: Vec3) -> Self {
        let decrease = Vec3::from(albedo.to_array().map(decrease));
        let scale = Vec3::from(decrease.to_array().map(|k| 0.5 * k / k.atanh()));
        Self { normal, decrease, scale }
    }

    /// A direction by the density of one channel.
    pub(super) fn sample(&self, channel: usize, [x, y]: [f32; 2]) -> Vec3 {
        let k = self.decrease[channel];
        let cos = ((1.0 - (1.0 + k) * ((1.0 - k) / (1.0 + k)).powf(x)) / k).clamp(-1.0, 1.0);
        let sin = (1.0 - cos * cos).sqrt();
        let (up, right) = (TAU * y).sin_cos();
        Basis::around(self.normal).to_world(Vec3::new(right * sin, up * sin, cos)).normalize()
    }

    /// The densities of a direction, per solid angle.
    pub(super) fn density(&self, dir: Vec3) -> Vec3 {
        self.scale / (TAU * self.stretch(dir))
    }

    /// The factors of the extinction along a direction in the choice of distances.
    pub(super) fn stretch(&self, dir: Vec3) -> Vec3 {
        Vec3::ONE - self.decrease * self.normal.dot(dir)
    }
}

/// The mean free path over the diffusion length, `k`: the solution of `albedo * atanh(k) = k`, to a thousandth between
/// albedos of 0.3 and 0.999. Walks are right with any.
fn decrease(albedo: f32) -> f32 {
    let albedo = albedo.clamp(0.2, 0.9999);
    // From above, where the function is convex.
    let mut y = (1.0 / albedo).min(1.25 * (3.0 / albedo - 3.0).sqrt());
    for _ in 0..4 {
        let tanh = y.tanh();
        y -= (albedo * y - tanh) / (albedo - 1.0 + tanh * tanh);
    }
    y.tanh().clamp(0.01, 0.9999)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_diffusion_are_those_of_the_equation() {
        for albedo in [0.3_f64, 0.5, 0.7, 0.9, 0.95, 0.99, 0.995, 0.999] {
            // By bisection in doubles.
            let (mut low, mut high) = (1e-6_f64, 1.0 - 1e-12);
            for _ in 0..200 {
                let k = 0.5 * (low + high);
                if albedo * k.atanh() > k {
                    high = k;
                } else {
                    low = k;
                }
            }
            let found = f64::from(decrease(albedo as f32));
            assert!((found - low).abs() < 1e-3, "{albedo}: {found}, not {low}");
        }
        for albedo in [-1.0, 0.0, 1e-3, 0.25, 0.9999, 1.0, 2.0] {
            assert!((0.01..=0.9999).contains(&decrease(albedo)), "{albedo}: {}", decrease(albedo));
        }
    }

    #[test]
    fn directions_have_their_density() {
        const PARTS: usize = 20;
        let normal = Vec3::new(0.6, 0.0, 0.8);
        let space = HalfSpace::new(normal, Vec3::new(0.2, 0.9, 1.0));
        for channel in 0..3 {
            let mut found = [0.0; PARTS];
            for i in 0..20_000 {
                let u = [(i as f32 + 0.5) / 20_000.0, (i % 7) as f32 / 7.0];
                let dir = space.sample(channel, u);
                let part = ((normal.dot(dir) + 1.0) * 0.5 * PARTS as f32) as usize;
                // The density turns each part's count into its solid angle, for any density.
                found[part.min(PARTS - 1)] += 1.0 / (20_000.0 * space.density(dir)[channel]);
            }
            for (part, area) in found.into_iter().enumerate() {
                let expected = 2.0 * TAU / PARTS as f32;
                assert!(
                    (area - expected).abs() < 0.02 * expected,
                    "{channel}, {part}: {area} for {expected}"
                );
            }
        }
    }
}
