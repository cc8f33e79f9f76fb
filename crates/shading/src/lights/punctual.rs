// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights that no scattered ray meets: from a point to all sides, from a point into a cone, from infinitely far away.
//! Source: glTF KHR_lights_punctual (the falloff between the spot's cones is the one recommended there).
//! Units: intensity in W·sr⁻¹, irradiance in W·m⁻². Random numbers choose directions to the discs of directional lights, nothing else.
//! Tests: `tests`, and the closed forms of crates/render/tests/lights.rs.

use glam::Vec3;

use crate::batch::Vec3s;
use crate::sampling::Basis;
use crate::sampling::warp::concentric_disk;
use crate::shader::{LightBatch, LightShader};

/// Least cosine to the axis of a wide disc, for its outermost points stand for very much light.
const LEAST_COSINE: f32 = 1e-2;

/// From a point to all sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// World space.
    pub position: Vec3,
    /// Radiant intensity.
    pub intensity: Vec3,
}

/// From a point into a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    pub(super) position: Vec3,
    pub(super) axis: Vec3,
    pub(super) intensity: Vec3,
    pub(super) cos_outer: f32,
    /// One over the difference of the cones' cosines.
    scale: f32,
}

/// From infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    pub(super) towards: Vec3,
    pub(super) irradiance: Vec3,
    /// Of half of the angle that it covers.
    sin_half: f32,
}

impl SpotLight {
    /// `direction` is where it points, any length but zero; half angles in radians. `None` if the direction
    /// is zero.
    #[must_use]
    pub fn new(
        position: Vec3,
        direction: Vec3,
        intensity: Vec3,
        inner_angle: f32,
        outer_angle: f32,
    ) -> Option<Self> {
        let axis = direction.try_normalize()?;
        let (cos_inner, cos_outer) = (inner_angle.cos(), outer_angle.cos());
        // Cones that coincide have a sharp edge.
        let scale = 1.0 / (cos_inner - cos_outer).max(1e-4);
        Some(Self { position, axis, intensity, cos_outer, scale })
    }

    /// Share of the intensity at this cosine to the axis.
    pub(super) fn falloff(&self, cos: f32) -> f32 {
        let share = ((cos - self.cos_outer) * self.scale).clamp(0.0, 1.0);
        share * share
    }
}

impl DirectionalLight {
    /// `direction` is where its light goes, any length but zero; `irradiance` that of a surface facing it; `angle` what its disc
    /// covers, radians, from 0 to pi.
    #[must_use]
    pub fn new(direction: Vec3, irradiance: Vec3, angle: f32) -> Option<Self> {
        let sin_half = if angle > 0.0 { (0.5 * angle.min(std::f32::consts::PI)).sin() } else { 0.0 };
        Some(Self { towards: -direction.try_normalize()?, irradiance, sin_half })
    }

    /// The unit direction to a point of its disc by two numbers in [0, 1), and the irradiance that it stands for: points are
    /// uniform over the disc as a surface that faces it sees that.
    pub(super) fn sample(&self, u: [f32; 2]) -> (Vec3, Vec3) {
        if self.sin_half <= 0.0 {
            return (self.towards, self.irradiance);
        }
        let across = concentric_disk(u) * self.sin_half;
        let cos = (1.0 - across.length_squared()).max(0.0).sqrt();
        let dir = Basis::around(self.towards).to_world(across.extend(cos)).normalize();
        (dir, self.irradiance_along(dir))
    }

    /// The irradiance that a point of its disc in this unit direction stands for.
    pub(super) fn irradiance_along(&self, dir: Vec3) -> Vec3 {
        if self.sin_half <= 0.0 {
            self.irradiance
        } else {
            self.irradiance / self.towards.dot(dir).max(LEAST_COSINE)
        }
    }
}

/// Fills `out` from a point whose intensity depends on the direction away from it.
fn from_point(position: Vec3, intensity: impl Fn(Vec3) -> Vec3, p: &Vec3s, out: &mut LightBatch) {
    for i in 0..p.len() {
        let offset = position - p.get(i);
        let dist = offset.length();
        // A point at the light's position is unlit: it has no direction.
        if dist > 0.0 && dist.is_finite() {
            let dir = offset / dist;
            out.dir.set(i, dir);
            out.dist[i] = dist;
            out.radiance.set(i, intensity(-dir) / (dist * dist));
        }
    }
}

impl LightShader for PointLight {
    fn illuminate(&self, p: &Vec3s, _normal: &Vec3s, _random: &[[f32; 2]], out: &mut LightBatch) {
        from_point(self.position, |_| self.intensity, p, out);
    }
}

impl LightShader for SpotLight {
    fn illuminate(&self, p: &Vec3s, _normal: &Vec3s, _random: &[[f32; 2]], out: &mut LightBatch) {
        from_point(self.position, |away| self.intensity * self.falloff(away.dot(self.axis)), p, out);
    }
}

impl LightShader for DirectionalLight {
    fn illuminate(&self, p: &Vec3s, _normal: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch) {
        for (i, &random) in random.iter().enumerate().take(p.len()) {
            let (dir, irradiance) = self.sample(random);
            out.dir.set(i, dir);
            out.dist[i] = f32::INFINITY;
            out.radiance.set(i, irradiance);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample_one(light: &dyn LightShader, p: Vec3) -> (Vec3, f32, Vec3) {
        let mut out = LightBatch::default();
        out.reset(1);
        light.illuminate(&Vec3s::splat(1, p), &Vec3s::splat(1, Vec3::Z), &[[0.5; 2]], &mut out);
        (out.dir.get(0), out.dist[0], out.radiance.get(0))
    }

    #[test]
    fn intensity_falls_with_the_square() {
        let light = PointLight { position: Vec3::new(0.0, 0.0, 4.0), intensity: Vec3::splat(32.0) };
        assert_eq!(sample_one(&light, Vec3::ZERO), (Vec3::Z, 4.0, Vec3::splat(2.0)), "32 / 4²");
        assert_eq!(sample_one(&light, light.position).2, Vec3::ZERO, "no light at the light itself");
    }

    #[test]
    fn spots_fade_between_their_cones() {
        let light = SpotLight::new(Vec3::Z, -Vec3::Z, Vec3::ONE, 0.3, 0.6).expect("it points down");
        let at = |angle: f32| {
            let p = Vec3::Z + Vec3::new(angle.sin(), 0.0, -angle.cos());
            sample_one(&light, p).2.x
        };
        assert!((at(0.2) - 1.0).abs() < 1e-5, "full inside");
        assert_eq!(at(0.61), 0.0, "dark outside");
        let middle = ((0.3_f32.cos() + 0.6_f32.cos()) / 2.0).acos();
        assert!((at(middle) - 0.25).abs() < 1e-4, "a quarter half way between the cosines");
        assert!(
            SpotLight::new(Vec3::Z, Vec3::ZERO, Vec3::ONE, 0.3, 0.6).is_none(),
            "it must point somewhere"
        );
    }

    #[test]
    fn directional_lights_are_far() {
        let light = DirectionalLight::new(Vec3::new(0.0, 0.0, -2.0), Vec3::ONE, 0.0).expect("it points down");
        assert_eq!(sample_one(&light, Vec3::ONE), (Vec3::Z, f32::INFINITY, Vec3::ONE), "the same everywhere");
    }

    /// The light that facing and tilted surfaces get from a disc: the irradiance times the cosine, where all of it is above.
    #[test]
    fn discs_bring_their_irradiance() {
        for degrees in [0.5_f32, 30.0, 120.0] {
            let angle = degrees.to_radians();
            let light =
                DirectionalLight::new(Vec3::new(-1.0, 0.0, -1.0), Vec3::ONE, angle).expect("it points down");
            let middle = Vec3::new(1.0, 0.0, 1.0).normalize();
            const N: u32 = 64;
            let mut sum = Vec3::ZERO;
            for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
                let (dir, irradiance) = light.sample([i, j].map(|k| (k as f32 + 0.5) / N as f32));
                assert!(dir.angle_between(middle) < 0.5 * angle + 1e-3, "within the disc");
                sum += dir * irradiance.x / (N * N) as f32;
            }
            assert!((sum - middle).length() < 2e-3, "{degrees} degrees: {sum}");
        }
    }
}
