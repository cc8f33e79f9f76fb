// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights of the program as lights of the scene: those without extent as they are, others as lamps with a mesh.
//! Source: ANARI 1.1, KHR_LIGHT_*. Radiance counts before power, power before intensity. Units: radiometric.
//! Space: that of the light's group on one side, world on the other. Tests: tests/lights.rs.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3;
use gnurt::scene::{Affine, ConeEdge, Light, MaterialId, Mesh};

use crate::area_light::{AreaLight, Distribution, Side};
use crate::ffi_array::Array;
use crate::object::{Object, Snapshot};
use crate::transforms::{linear, point};
use crate::types;

/// Segments of a ring.
const SEGMENTS: u32 = 96;

/// Radiance from all around.
pub(crate) struct Sky {
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    /// From the uppermost row to the lowest one, linear.
    pub(crate) texels: Vec<[f32; 3]>,
    /// Directions of the picture's middle and of its upper side; unit, perpendicular, world.
    pub(crate) middle: Vec3,
    pub(crate) up: Vec3,
    pub(crate) visible: bool,
}

/// A light of the program in the scene.
pub(crate) enum Made {
    /// One without extent.
    Small(Light),
    /// One with a mesh in world space.
    AreaLight { mesh: Mesh, area_light: AreaLight, visible: bool },
    /// One around everything.
    Sky(Sky),
}

struct Reader<'a> {
    now: &'a Snapshot,
    to_world: &'a Affine,
}

impl Reader<'_> {
    fn vector(&self, name: &str, default: [f32; 3]) -> Vec3 {
        Vec3::from(self.now.vec3(name).unwrap_or(default))
    }

    fn position(&self) -> Vec3 {
        point(self.to_world, self.vector("position", [0.0; 3]))
    }

    fn direction(&self, name: &str, default: [f32; 3]) -> Result<Vec3, String> {
        let direction = linear(self.to_world) * self.vector(name, default);
        direction.try_normalize().ok_or_else(|| format!("parameter '{name}': without length"))
    }

    fn color(&self) -> Vec3 {
        self.vector("color", [1.0; 3]).max(Vec3::ZERO)
    }

    /// Half angles at which the cone ends, and at which it is full.
    fn cone(&self) -> [f32; 2] {
        let opening = self.now.f32("openingAngle").unwrap_or(PI).clamp(0.0, TAU);
        let falloff = self.now.f32("falloffAngle").unwrap_or(0.1).max(0.0);
        let outer = opening / 2.0;
        [outer, (outer - falloff).max(0.0)]
    }

    /// Radiance of an area that shines to one side of `sides`, within `solid_angle` weighted by the cosine.
    fn radiance(&self, area: f32, weighted_solid_angle: f32, sides: f32) -> f32 {
        if let Some(radiance) = self.now.f32("radiance") {
            return radiance;
        }
        if let Some(power) = self.now.f32("power") {
            return power / (area * weighted_solid_angle * sides);
        }
        self.now.f32("intensity").unwrap_or(1.0) / area
    }

    /// Intensity of a point that shines within `solid_angle`.
    fn intensity(&self, solid_angle: f32) -> f32 {
        let power = self.now.f32("power").map(|power| power / solid_angle);
        power.unwrap_or_else(|| self.now.f32("intensity").unwrap_or(1.0))
    }

    fn distribution(&self, axis: Vec3, first: Vec3) -> Option<Distribution> {
        let list = self.now.object("intensityDistribution", types::ARRAY1D);
        let array = list.or_else(|| self.now.object("intensityDistribution", types::ARRAY2D))?;
        let array = Array::of(array)?;
        let values: Vec<f32> = array.colors()?.into_iter().map(|value| value[0]).collect();
        let width = if list.is_some() { values.len() } else { array.dims[0] as usize };
        let first = (first - axis * axis.dot(first)).try_normalize();
        Some(Distribution { values, width, first: first.unwrap_or_else(|| axis.any_orthonormal_vector()) })
    }

    fn visible(&self) -> bool {
        self.now.bool("visible").unwrap_or(true)
    }
}

/// The solid angle of a cone, its edge counted by half: of the full cone.
fn solid_angle([outer, inner]: [f32; 2]) -> f32 {
    let of = |half: f32| TAU * (1.0 - half.cos());
    ((of(outer) + of(inner)) / 2.0).max(1e-6)
}

/// The light of an object in a group that stands at `to_world`; an error in words where it means nothing.
pub(crate) fn light(object: &Object, to_world: &Affine, material: MaterialId) -> Result<Made, String> {
    let now = object.committed();
    let read = Reader { now: &now, to_world };
    let made = match object.subtype.as_str() {
        "directional" => {
            let half = now.f32("angularDiameter").unwrap_or(0.0) / 2.0;
            let disc =
                now.f32("radiance").map(|radiance| radiance * PI * half.sin().powi(2)).filter(|_| half > 0.0);
            let irradiance = disc.unwrap_or_else(|| now.f32("irradiance").unwrap_or(1.0)).max(0.0);
            let direction = read.direction("direction", [0.0, 0.0, -1.0])?.to_array();
            Made::Small(Light::Directional {
                direction,
                irradiance: (read.color() * irradiance).to_array(),
                angle: 2.0 * half,
            })
        }
        "point" => ball(&read, material),
        "spot" => {
            let [outer, inner] = read.cone();
            let intensity = read.color() * read.intensity(solid_angle([outer, inner]));
            Made::Small(Light::Spot {
                position: read.position().to_array(),
                direction: read.direction("direction", [0.0, 0.0, -1.0])?.to_array(),
                intensity: intensity.max(Vec3::ZERO).to_array(),
                inner_angle: inner.min(outer - 1e-4).max(0.0),
                outer_angle: outer.max(2e-4),
                edge: ConeEdge::default(),
                radius: 0.0,
            })
        }
        "quad" => quad(&read, material)?,
        "ring" => ring(&read, material)?,
        "hdri" => Made::Sky(sky(&read)?),
        other => return Err(format!("subtype '{other}': unsupported")),
    };
    Ok(made)
}

fn ball(read: &Reader, material: MaterialId) -> Made {
    let (position, radius) = (read.position(), read.now.f32("radius").unwrap_or(0.0));
    let disc = PI * radius * radius;
    if disc <= 0.0 || disc.is_nan() {
        let intensity = read.color() * read.intensity(2.0 * TAU);
        let intensity = intensity.max(Vec3::ZERO).to_array();
        return Made::Small(Light::Point { position: position.to_array(), intensity, radius: 0.0 });
    }
    // Seen from everywhere as a disc; its surface is four of them.
    let radiance = match (read.now.f32("radiance"), read.now.f32("power")) {
        (Some(radiance), _) => radiance,
        (None, Some(power)) => power / (4.0 * disc * PI),
        _ => read.now.f32("intensity").unwrap_or(1.0) / disc,
    };
    let unit = crate::geometry::sphere();
    let positions = unit.positions.iter().map(|&p| (position + Vec3::from(p) * radius).to_array()).collect();
    let mesh = Mesh { positions, indices: unit.indices.clone(), material, ..Mesh::default() };
    let area_light = area_light(read.color() * radiance, Side::Front, Vec3::Z);
    Made::AreaLight { mesh, area_light, visible: read.visible() }
}

fn area_light(radiance: Vec3, side: Side, axis: Vec3) -> AreaLight {
    AreaLight { radiance: radiance.max(Vec3::ZERO), side, axis, cone: None, distribution: None }
}

fn quad(read: &Reader, material: MaterialId) -> Result<Made, String> {
    let edge = |name, default| linear(read.to_world) * read.vector(name, default);
    let (position, e1, e2) =
        (read.position(), edge("edge1", [1.0, 0.0, 0.0]), edge("edge2", [0.0, 1.0, 0.0]));
    let normal = e1.cross(e2);
    let area = normal.length();
    let axis = normal.try_normalize().ok_or("parameters 'edge1' and 'edge2': without area")?;
    let (side, sides) = match read.now.text("side") {
        Some("back") => (Side::Back, 1.0),
        Some("both") => (Side::Both, 2.0),
        _ => (Side::Front, 1.0),
    };
    let radiance = read.color() * read.radiance(area, PI, sides);
    let corners = [position, position + e1, position + e1 + e2, position + e2];
    let mesh = Mesh {
        positions: corners.map(|p| p.to_array()).to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    };
    let axis = if side == Side::Back { -axis } else { axis };
    let distribution = read.distribution(axis, e1);
    let area_light = AreaLight { distribution, ..area_light(radiance, side, axis) };
    Ok(Made::AreaLight { mesh, area_light, visible: read.visible() })
}

fn ring(read: &Reader, material: MaterialId) -> Result<Made, String> {
    let axis = read.direction("direction", [0.0, 0.0, -1.0])?;
    let cone = read.cone();
    let outer = read.now.f32("radius").unwrap_or(0.0);
    let inner = read.now.f32("innerRadius").unwrap_or(0.0).clamp(0.0, outer.max(0.0));
    let position = read.position();
    let area = PI * (outer * outer - inner * inner);
    if area <= 0.0 || area.is_nan() {
        let intensity = (read.color() * read.intensity(solid_angle(cone))).max(Vec3::ZERO).to_array();
        let (position, direction) = (position.to_array(), axis.to_array());
        let [outer_angle, inner_angle] = cone.map(|angle| angle.min(FRAC_PI_2));
        let inner_angle = inner_angle.min(outer_angle - 1e-4).max(0.0);
        return Ok(Made::Small(Light::Spot {
            position,
            direction,
            intensity,
            inner_angle,
            outer_angle,
            edge: ConeEdge::default(),
            radius: 0.0,
        }));
    }
    let within = PI * cone[0].min(FRAC_PI_2).sin().powi(2);
    let radiance = read.color() * read.radiance(area, within.max(1e-6), 1.0);
    let first = linear(read.to_world) * read.vector("c0", [1.0, 0.0, 0.0]);
    let (x, y) = axis.any_orthonormal_pair();
    let mut mesh = Mesh { material, ..Mesh::default() };
    for k in 0..SEGMENTS {
        let (sin, cos) = (k as f32 / SEGMENTS as f32 * TAU).sin_cos();
        let out = x * cos + y * sin;
        mesh.positions.extend([position + out * inner, position + out * outer].map(|p| p.to_array()));
        let [a, b] = [2 * k, 2 * ((k + 1) % SEGMENTS)];
        mesh.indices.push([a, a + 1, b + 1]);
        if inner > 0.0 {
            mesh.indices.push([a, b + 1, b]);
        }
    }
    let distribution = read.distribution(axis, first);
    // A whole hemisphere has no edge.
    let cone = (cone[0] < FRAC_PI_2 || cone[1] < FRAC_PI_2 - 0.1).then_some(cone);
    let area_light = AreaLight { cone, distribution, ..area_light(radiance, Side::Front, axis) };
    Ok(Made::AreaLight { mesh, area_light, visible: read.visible() })
}

fn sky(read: &Reader) -> Result<Sky, String> {
    let array = read.now.object("radiance", types::ARRAY2D).and_then(|array| Array::of(array));
    let array = array.ok_or("parameter 'radiance': missing")?;
    let scale = read.color() * read.now.f32("scale").unwrap_or(1.0).max(0.0);
    let values =
        array.colors().filter(|values| !values.is_empty()).ok_or("parameter 'radiance': no texels")?;
    let texels =
        values.into_iter().map(|[r, g, b, _]| (Vec3::new(r, g, b) * scale).max(Vec3::ZERO).to_array());
    let size = [array.dims[0], array.dims[1]].map(u32::try_from);
    let [Ok(width), Ok(height)] = size else { return Err("parameter 'radiance': too large".into()) };
    let middle = read.direction("direction", [1.0, 0.0, 0.0])?;
    let up = read.direction("up", [0.0, 0.0, 1.0])?;
    let up =
        (up - middle * middle.dot(up)).try_normalize().unwrap_or_else(|| middle.any_orthonormal_vector());
    Ok(Sky { size: [width, height], texels: texels.collect(), middle, up, visible: read.visible() })
}
