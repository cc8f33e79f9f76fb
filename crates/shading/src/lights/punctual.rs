// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights that no scattered ray meets: from a point to all sides or into a cone, from infinitely far away.
//! Source: glTF KHR_lights_punctual and [PJH23] section 12.1.2 (the two ways to fade between a spot's cones). Original: rays and points of
//! lights with a radius. Units: intensity in W·sr⁻¹, irradiance in W·m⁻². Random numbers choose points of discs, nothing else.
//! Tests: `tests`, and the closed forms of crates/render/tests/lights.rs.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use gnurt_image::srgb::luminance;

use super::disc::{ConeAt, DiscAt, Seen};
use crate::batch::Vec3s;
use crate::sampling::warp::concentric_disk;
use crate::sampling::{Basis, uniform_sphere};
use crate::shader::{LightBatch, LightShader};

/// Least cosine to the axis of a wide disc, for its outermost points stand for very much light.
const LEAST_COSINE: f32 = 1e-2;

/// From a point, to all sides or into a cone. With a radius its light comes from a disc around that point, which faces the lit one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// World space.
    pub position: Vec3,
    /// Radiant intensity, inside of the inner cone if there is one.
    pub intensity: Vec3,
    /// Of the disc; 0 = a point.
    pub radius: f32,
    /// Where its light ends.
    pub cone: Option<Cone>,
}

/// The directions into which a spot shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    pub(super) axis: Vec3,
    pub(super) cos_outer: f32,
    /// One over the difference of the cones' cosines.
    scale: f32,
    edge: ConeEdge,
}

/// How light fades from the inner cone, where the share of the way between the cones' cosines is 1, to the outer one, where it is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ConeEdge {
    /// By the square of that share, as glTF recommends.
    #[default]
    Squared,
    /// By its smooth step 3x² - 2x³, as in pbrt and Blender.
    Smooth,
}

/// From infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    pub(super) towards: Vec3,
    pub(super) irradiance: Vec3,
    /// Of half of the angle that it covers.
    sin_half: f32,
}

impl Cone {
    /// `direction` is where it points, any length but zero; half angles in radians. `None` if the direction
    /// is zero.
    #[must_use]
    pub fn new(direction: Vec3, inner_angle: f32, outer_angle: f32, edge: ConeEdge) -> Option<Self> {
        let axis = direction.try_normalize()?;
        let (cos_inner, cos_outer) = (inner_angle.cos(), outer_angle.cos());
        // Cones that coincide have a sharp edge.
        let scale = 1.0 / (cos_inner - cos_outer).max(1e-4);
        Some(Self { axis, cos_outer, scale, edge })
    }

    /// As choices see it.
    fn at(&self) -> ConeAt<f32> {
        ConeAt {
            axis: self.axis.into(),
            cos_outer: self.cos_outer,
            scale: self.scale,
            smooth: f32::from(u8::from(self.edge == ConeEdge::Smooth)),
        }
    }
}

impl PointLight {
    /// A light without a radius that shines to all sides.
    #[must_use]
    pub fn new(position: Vec3, intensity: Vec3) -> Self {
        Self { position, intensity, radius: 0.0, cone: None }
    }

    /// The intensity in this unit direction away from it.
    pub(super) fn intensity_along(&self, away: Vec3) -> Vec3 {
        let cone = self.at().cone;
        self.intensity * cone.falloff(cone.axis.dot(away.into()))
    }

    /// As choices see it.
    pub(super) fn at(&self) -> DiscAt<f32> {
        DiscAt {
            position: self.position.into(),
            radius: self.radius,
            cone: self.cone.as_ref().map_or(ConeAt::EVERYWHERE, Cone::at),
        }
    }

    /// Its light at `p` from a point of its disc by two numbers in [0, 1): the unit direction, the distance, and the irradiance of a surface
    /// that faces it, over the density of the point. `None` where it has no direction: at the light itself.
    pub(super) fn seen_from(&self, p: Vec3, u: [f32; 2]) -> Option<(Vec3, f32, Vec3)> {
        let Seen { dir, dist, share, there } = self.at().seen_from(p.into(), u);
        there.then(|| (dir.into(), dist, self.intensity * share))
    }

    /// About how bright it makes a surface at `p` that faces `ns` (zero: all sides); above zero wherever any of its disc is seen.
    pub(super) fn estimate(&self, p: Vec3, ns: Vec3) -> f32 {
        self.at().contribution(self.power(), p.into(), (ns != Vec3::ZERO).then(|| ns.into()))
    }

    /// The brightness of its intensity.
    pub(super) fn power(&self) -> f32 {
        luminance(self.intensity.into())
    }

    /// The solid angle into which it shines.
    pub(super) fn solid_angle(&self) -> f32 {
        self.cone.map_or(2.0 * TAU, |cone| TAU * (1.0 - cone.cos_outer).max(f32::MIN_POSITIVE))
    }

    /// A direction of its light, uniform, by two numbers in [0, 1).
    pub(super) fn any_direction(&self, u: [f32; 2]) -> Vec3 {
        let Some(cone) = &self.cone else { return uniform_sphere(u) };
        let cos = 1.0 - u[0] * (1.0 - cone.cos_outer);
        let (sin, azimuth) = ((1.0 - cos * cos).max(0.0).sqrt(), TAU * u[1]);
        let local = Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
        Basis::around(cone.axis).to_world(local).normalize()
    }

    /// A ray of its light along `dir` by two numbers in [0, 1): where it passes the light nearest, and how far from there it begins.
    /// A disc that faces a near place sends it no ray that passes far from the middle. Where b is the distance at which a ray passes, it
    /// reaches places at distances D with D b <= r √(D² - b²).
    pub(super) fn ray_along(&self, dir: Vec3, u: [f32; 2]) -> (Vec3, f32) {
        if self.radius <= 0.0 {
            return (self.position, 0.0);
        }
        let on_disc = concentric_disk(u) * self.radius;
        let b2 = on_disc.length_squared();
        let begin = b2 / (self.radius * self.radius - b2).max(0.0).sqrt();
        (self.position + Basis::around(dir).to_world(on_disc.extend(0.0)), begin)
    }

    /// A point of a ball around it by two numbers in [0, 1). Seen from afar, from any side, such points are spread evenly over a disc:
    /// they are three coordinates of points on the unit sphere of four dimensions, by Archimedes' theorem.
    pub(super) fn any_point(&self, u: [f32; 2]) -> Vec3 {
        if self.radius <= 0.0 {
            return self.position;
        }
        // The third number is made of the last digits of the first.
        let turn = (u[0] * 1021.618).fract();
        let across = Vec2::from_angle(TAU * u[1]) * (1.0 - u[0]).max(0.0).sqrt();
        self.position + self.radius * across.extend(u[0].sqrt() * (TAU * turn).cos())
    }

    /// The intensity of a point of that ball towards a place at `p` that sees it in the unit direction `dir`: as much light on average as
    /// that place gets from the disc that faces it.
    pub(super) fn intensity_of_point(&self, p: Vec3, dir: Vec3) -> Vec3 {
        let intensity = self.intensity_along(-dir);
        if self.radius <= 0.0 {
            return intensity;
        }
        let distance2 = self.position.distance_squared(p);
        intensity * (distance2 / (distance2 + self.radius * self.radius))
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

impl LightShader for PointLight {
    fn illuminate(&self, p: &Vec3s, _normal: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch) {
        for i in 0..p.len() {
            // Only discs need the numbers.
            let random = random.get(i).copied().unwrap_or([0.5; 2]);
            if let Some((dir, dist, irradiance)) = self.seen_from(p.get(i), random) {
                out.dir.set(i, dir);
                out.dist[i] = dist;
                out.radiance.set(i, irradiance);
            }
        }
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
        let light = PointLight::new(Vec3::new(0.0, 0.0, 4.0), Vec3::splat(32.0));
        assert_eq!(sample_one(&light, Vec3::ZERO), (Vec3::Z, 4.0, Vec3::splat(2.0)), "32 / 4²");
        assert_eq!(sample_one(&light, light.position).2, Vec3::ZERO, "no light at the light itself");
    }

    #[test]
    fn spots_fade_between_their_cones() {
        for (edge, half_way) in [(ConeEdge::Squared, 0.25), (ConeEdge::Smooth, 0.5)] {
            let cone = Cone::new(-Vec3::Z, 0.3, 0.6, edge);
            let light = PointLight { cone, ..PointLight::new(Vec3::Z, Vec3::ONE) };
            let at = |angle: f32| {
                let p = Vec3::Z + Vec3::new(angle.sin(), 0.0, -angle.cos());
                sample_one(&light, p).2.x
            };
            assert!((at(0.2) - 1.0).abs() < 1e-5, "full inside");
            assert_eq!(at(0.61), 0.0, "dark outside");
            let middle = ((0.3_f32.cos() + 0.6_f32.cos()) / 2.0).acos();
            assert!((at(middle) - half_way).abs() < 1e-4, "{edge:?}: half way between the cosines");
        }
        assert!(Cone::new(Vec3::ZERO, 0.3, 0.6, ConeEdge::Squared).is_none(), "it must point somewhere");
    }

    /// Light on surfaces that face the light, beside the closed form of a disc: by its own points, by those of the ball, by its rays.
    /// Estimates are above zero where there is light.
    #[test]
    fn discs_face_who_sees_them() {
        const N: u32 = 128;
        let light = PointLight { radius: 0.5, ..PointLight::new(Vec3::new(0.2, -0.1, 0.3), Vec3::ONE) };
        let numbers =
            || (0..N).flat_map(|i| (0..N).map(move |j| [i, j].map(|k| (k as f32 + 0.5) / N as f32)));
        let mean = |of: &dyn Fn([f32; 2]) -> f32| numbers().map(of).sum::<f32>() / (N * N) as f32;
        for distance in [0.3_f32, 1.0, 4.0] {
            let towards = Vec3::new(2.0, -1.0, 0.5).normalize();
            let p = light.position - towards * distance;
            let seen = |u| light.seen_from(p, u).expect("it is elsewhere");
            let facing = 1.0 / (distance * distance + 0.25);
            let by_disc = mean(&|u| seen(u).2.x * seen(u).0.dot(towards));
            assert!((by_disc / facing - 1.0).abs() < 3e-3, "{distance}: {by_disc}, not {facing}");
            let by_ball = mean(&|u| {
                let offset = light.any_point(u) - p;
                let dir = offset.normalize();
                light.intensity_of_point(p, dir).x * dir.dot(towards) / offset.length_squared()
            });
            assert!(
                distance < 0.5 || (by_ball / facing - 1.0).abs() < 0.03,
                "{distance}: {by_ball}, not {facing}"
            );
            // Rays along the axis, moved to all sides, that reach the place beyond where they begin.
            let reached = mean(&|u| {
                let (start, begin) = light.ray_along(-towards, u);
                // The place which sees this ray's light is as far from the middle as `p` is.
                let along = (distance * distance - start.distance_squared(light.position)).max(0.0).sqrt();
                f32::from(u8::from(along >= begin))
            });
            // As seen from there, the radius is r D / √(D² + r²).
            let expected = distance * distance / (distance * distance + 0.25);
            assert!((reached - expected).abs() < 0.02, "{distance}: {reached}, not {expected}");
            for tilt in 0..40 {
                let turned = Basis::around(towards).to_world(Vec3::new(
                    (0.1 * tilt as f32).sin(),
                    0.0,
                    (0.1 * tilt as f32).cos(),
                ));
                let lit = numbers()
                    .step_by(37)
                    .map(|u| seen(u).0.dot(turned).max(0.0) * seen(u).2.x)
                    .fold(0.0, f32::max);
                let estimate = light.estimate(p, turned);
                assert!(
                    lit <= 0.0 || estimate > 0.0,
                    "{distance}, {tilt}: {lit} but an estimate of {estimate}"
                );
            }
        }
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
