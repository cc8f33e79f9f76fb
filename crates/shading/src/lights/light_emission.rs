// SPDX-License-Identifier: GPL-3.0-or-later
//! Starts of light paths: a light chosen by power, a position on it, a direction.
//! Source: [PJH23] sections 12.1 to 12.6 (emission of each kind of light); environments from a disk before
//! the bounding sphere of the lit scene. Space: world. Units: power in W per channel, densities per area and
//! per solid angle.
//! Invariant: the mean of `radiance_over_pdf` is the power of all lights (for distant lights, the power that
//! the bounding sphere receives). Tests: `light_set_tests`.

use std::f32::consts::PI;

use glam::Vec3;

use super::light_parts::{LightId, LightKind};
use super::light_set::LightSet;
use crate::point::SurfacePoint;
use crate::sampling::warp::concentric_disk;
use crate::sampling::{Basis, cosine_hemisphere};

/// The first edge of a path from a light.
#[derive(Clone, Copy, Debug)]
pub struct LightRay {
    /// Where it starts: on a surface, at a point light, or before the scene.
    pub point: SurfacePoint,
    /// Whether `point` lies on a surface: light leaves it by the cosine to `normal`.
    pub is_surface: bool,
    /// Unit; the direction itself where there is no surface.
    pub normal: Vec3,
    /// Unit, where it goes.
    pub dir: Vec3,
    /// The distance from `point` at which its light begins: what it meets before that is dark, and ends it.
    pub begin: f32,
    /// The power that it carries: the exit radiance, times the cosine at a surface, over all densities.
    pub radiance_over_pdf: Vec3,
    /// Emission along `dir`: radiance; intensity of lights without extent; irradiance of directional ones.
    pub emitted: Vec3,
    /// Density of the start, the choice of the light included: per area; for point lights the probability of the choice.
    pub pdf_pos: f32,
    /// Density of the direction per solid angle; 1 for directional lights.
    pub pdf_dir: f32,
    /// The kind of light.
    pub kind: LightKind,
    /// Which light.
    pub light: LightId,
}

/// A point that lies on no surface.
fn free_point(p: Vec3, dir: Vec3) -> SurfacePoint {
    SurfacePoint { p, error: 0.0, ng: dir, ns: dir, lift: Vec3::ZERO }
}

impl LightSet {
    /// Starts a path at a light: `u_choice` chooses it by power, `u_pos` the position, `u_dir` the direction,
    /// all in [0, 1). `None` if there is no emission there.
    #[must_use]
    pub fn emit(&self, u_choice: f32, u_pos: [f32; 2], u_dir: [f32; 2]) -> Option<LightRay> {
        let choice = self.power()?.sample(u_choice);
        let light = LightId(choice.index as u32);
        let kind = self.kind(light);
        let ray = match kind {
            LightKind::Shape(i) => self.emit_shape(i, choice.probability, u_pos, u_dir),
            LightKind::Point(i) => {
                let point = &self.parts.points[i as usize];
                let dir = point.any_direction(u_dir);
                let (start, begin) = point.ray_along(dir, u_pos);
                let (intensity, pdf_dir) = (point.intensity_along(dir), 1.0 / point.solid_angle());
                Some(LightRay { begin, ..from_point(start, dir, intensity, choice.probability, pdf_dir) })
            }
            LightKind::Directional(i) => {
                let directional = &self.parts.directionals[i as usize];
                let (towards, irradiance) = directional.sample(u_dir);
                Some(self.emit_from_far(-towards, irradiance, choice.probability, 1.0, u_pos))
            }
            LightKind::Environment => {
                let environment = self.parts.environment.as_ref()?;
                let (towards, pdf_dir) = environment.sample_any(u_dir);
                Some(self.emit_from_far(
                    -towards,
                    environment.radiance(towards),
                    choice.probability,
                    pdf_dir,
                    u_pos,
                ))
            }
        }?;
        let ray = LightRay { kind, light, ..ray };
        (ray.radiance_over_pdf.is_finite() && ray.radiance_over_pdf != Vec3::ZERO).then_some(ray)
    }

    /// Density per area with which [`emit`](Self::emit) starts at a point of an emissive shape.
    #[must_use]
    pub fn pdf_emit_position(&self, shape: u32) -> f32 {
        match (self.power(), &self.parts.shapes) {
            (Some(power), Some(lights)) => {
                power.probability(shape as usize) / lights.shapes[shape as usize].area()
            }
            _ => 0.0,
        }
    }

    fn emit_shape(&self, index: u32, chosen: f32, u_pos: [f32; 2], u_dir: [f32; 2]) -> Option<LightRay> {
        let lights = self.parts.shapes.as_ref()?;
        let shape = &lights.shapes[index as usize];
        let place = shape.place(u_pos);
        let (p, normal, area) = (shape.point(place), shape.normal_at(place), shape.area());
        let local = cosine_hemisphere(u_dir);
        let dir = Basis::around(normal).to_world(local).normalize();
        let emitted = lights.radiance(index as usize, place, -dir, 1.0);
        Some(LightRay {
            point: SurfacePoint {
                p,
                error: shape.rounding(Vec3::ZERO),
                ng: normal,
                ns: normal,
                lift: Vec3::ZERO,
            },
            is_surface: true,
            normal,
            dir,
            begin: 0.0,
            // The cosine is the density's times pi.
            radiance_over_pdf: emitted * (PI * area / chosen),
            emitted,
            pdf_pos: chosen / area,
            pdf_dir: local.z / PI,
            kind: LightKind::Shape(index),
            light: LightId(index),
        })
    }

    /// Light that goes along `dir`, from a disk before the ball around the scene.
    fn emit_from_far(
        &self,
        dir: Vec3,
        emitted: Vec3,
        chosen: f32,
        pdf_dir: f32,
        u_pos: [f32; 2],
    ) -> LightRay {
        let (centre, radius) = self.ball;
        let on_disk = concentric_disk(u_pos) * radius;
        let p = centre - dir * radius + Basis::around(dir).to_world(on_disk.extend(0.0));
        let pdf_pos = chosen / (PI * radius * radius);
        LightRay {
            point: free_point(p, dir),
            is_surface: false,
            normal: dir,
            dir,
            begin: 0.0,
            radiance_over_pdf: emitted / (pdf_pos * pdf_dir),
            emitted,
            pdf_pos,
            pdf_dir,
            kind: LightKind::Environment,
            light: LightId(0),
        }
    }
}

fn from_point(p: Vec3, dir: Vec3, intensity: Vec3, chosen: f32, pdf_dir: f32) -> LightRay {
    LightRay {
        point: free_point(p, dir),
        is_surface: false,
        normal: dir,
        dir,
        begin: 0.0,
        radiance_over_pdf: intensity / (chosen * pdf_dir),
        emitted: intensity,
        pdf_pos: chosen,
        pdf_dir,
        kind: LightKind::Point(0),
        light: LightId(0),
    }
}
