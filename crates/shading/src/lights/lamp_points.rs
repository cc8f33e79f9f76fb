// SPDX-License-Identifier: GPL-3.0-or-later
//! Points of lamps, chosen without a point that they light: the ends of paths that are searched for as a whole.
//! Source: [PJH23] section 12.6 (areas); original. Space: world. Environments and lights of plugins have none.
//! Tests: crates/render/tests/caustics.rs.

use glam::Vec3;
use gnurt_image::srgb::luminance;

use super::light_parts::{LightId, LightKind};
use super::light_set::LightSet;

/// Where a lamp is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// A point.
    At(Vec3),
    /// So far away that only the unit direction to it counts.
    Towards(Vec3),
}

/// A point of a lamp.
#[derive(Clone, Copy, Debug)]
pub struct LampPoint {
    /// Which lamp.
    pub light: LightId,
    /// Where.
    pub place: Place,
    /// Whether no scattered ray could meet it.
    pub delta: bool,
    /// Its place on a shape.
    on_shape: [f32; 2],
}

impl LightSet {
    /// A point of a lamp by two numbers in [0, 1), uniform by area; of a light with a radius a point of a ball.
    #[must_use]
    pub fn lamp_point(&self, light: LightId, u: [f32; 2]) -> Option<LampPoint> {
        let (mut on_shape, mut delta) = ([0.0; 2], true);
        let place = match self.kind(light) {
            LightKind::Shape(i) => {
                let shape = &self.parts.shapes.as_ref()?.shapes[i as usize];
                (on_shape, delta) = (shape.place(u), false);
                Place::At(shape.nearest_image(Vec3::ZERO, on_shape))
            }
            LightKind::Point(i) => Place::At(self.parts.points[i as usize].any_point(u)),
            LightKind::Directional(i) => Place::Towards(self.parts.directionals[i as usize].sample(u).0),
            LightKind::Environment => return None,
        };
        Some(LampPoint { light, place, delta, on_shape })
    }

    /// The intensity of a point of a lamp towards a place that sees it in the unit direction `dir`, `dist` away, W·sr⁻¹. Of a
    /// shape: radiance times projected area, over the density of the point. Of a lamp without a position: the irradiance of
    /// a surface that faces it.
    #[must_use]
    pub fn intensity(&self, from: &LampPoint, dir: Vec3, dist: f32) -> Vec3 {
        match self.kind(from.light) {
            LightKind::Shape(i) => {
                let Some(lights) = &self.parts.shapes else { return Vec3::ZERO };
                let shape = &lights.shapes[i as usize];
                let cos = -shape.normal_at(from.on_shape).dot(dir);
                if cos <= 0.0 {
                    return Vec3::ZERO;
                }
                lights.radiance(i as usize, from.on_shape, dir, dist) * (cos * shape.area())
            }
            LightKind::Point(i) => {
                let Place::At(place) = from.place else { return Vec3::ZERO };
                self.parts.points[i as usize].intensity_of_point(place - dir * dist, dir)
            }
            LightKind::Directional(i) => self.parts.directionals[i as usize].irradiance_along(-dir),
            LightKind::Environment => Vec3::ZERO,
        }
    }

    /// About the brightness of a lamp along its axis, in the unit of [`intensity`](Self::intensity).
    #[must_use]
    pub fn brightness(&self, light: LightId) -> f32 {
        let bright = |color: Vec3| luminance(color.into());
        match self.kind(light) {
            LightKind::Shape(i) => {
                self.parts.shapes.as_ref().map_or(0.0, |lights| lights.shapes[i as usize].power)
            }
            LightKind::Point(i) => bright(self.parts.points[i as usize].intensity),
            LightKind::Directional(i) => bright(self.parts.directionals[i as usize].irradiance),
            LightKind::Environment => 0.0,
        }
    }

    /// The area of an emissive shape as it is seen along the unit direction `dir`, if all of it faced that as its point `p` does: one over
    /// the density of [`lamp_point`](Self::lamp_point) per area across. `None` for other lights.
    #[must_use]
    pub fn area_across(&self, light: LightId, p: Vec3, dir: Vec3) -> Option<f32> {
        let shape = self.parts.shapes.as_ref()?.shapes.get(light.0 as usize)?;
        let normal = shape.place_of(p).map_or(shape.normal, |place| shape.normal_at(place));
        Some(shape.area() * normal.dot(dir).abs())
    }

    /// Area and middle of an emissive shape.
    #[must_use]
    pub fn extent(&self, shape: u32) -> Option<(f32, Vec3)> {
        let shape = self.parts.shapes.as_ref()?.shapes.get(shape as usize)?;
        Some((shape.area(), (shape.p[0] + shape.p[1] + shape.p[2]) / 3.0))
    }

    /// The names of hits on emissive shapes, by light: leaf, mesh, primitive.
    #[must_use]
    pub fn shape_ids(&self) -> &[[u32; 3]] {
        &self.parts.shape_ids
    }
}
