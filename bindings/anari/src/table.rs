// SPDX-License-Identifier: GPL-3.0-or-later
//! The table of targets of rays: for each instance of the world its surface, part and placement, and so the attributes of each point.
//! Space: world where nothing else is said. Tests: tests/attributes.rs.

use std::sync::Arc;

use glam::Vec3;
use gnurt::scene::Affine;

use crate::area_light::AreaLight;
use crate::attribute::{Attribute, Color, FREE, NOTHING, Point};
use crate::geometry::{Geometry, Spot};
use crate::material::Material;
use crate::transforms::{linear, point};
use crate::volume::Volume;

/// No placement.
pub(crate) const ONCE: u32 = u32::MAX;

/// The content of an instance of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Target {
    /// A part of a surface; `placement` is [`ONCE`] where the part is there once.
    Surface { surface: u32, instance: u32, part: u32, placement: u32 },
    /// A lamp.
    AreaLight(u32),
}

/// A geometry with a material.
pub(crate) struct Surface {
    pub(crate) geometry: Arc<Geometry>,
    pub(crate) material: Arc<Material>,
    pub(crate) id: u32,
}

/// An instance of the program.
pub(crate) struct Instance {
    pub(crate) world_from_object: Affine,
    pub(crate) object_from_world: Affine,
    /// Those that it has in place of the geometry's.
    pub(crate) attributes: [Option<Color>; FREE],
    pub(crate) id: u32,
}

/// All targets of rays: surfaces, lamps and volumes.
#[derive(Default)]
pub(crate) struct Table {
    /// By instance of the world.
    pub(crate) targets: Vec<Target>,
    pub(crate) surfaces: Vec<Surface>,
    pub(crate) instances: Vec<Instance>,
    pub(crate) area_lights: Vec<AreaLight>,
    pub(crate) volumes: Vec<Volume>,
    /// Whether some surface has holes.
    pub(crate) has_holes: bool,
    /// Whether the camera sees the light from all around.
    pub(crate) shows_sky: bool,
}

/// A point of a surface.
pub(crate) struct At<'t> {
    pub(crate) surface: &'t Surface,
    pub(crate) instance: &'t Instance,
    pub(crate) spot: Spot,
    position: Vec3,
    /// Unit shading normal.
    normal: Vec3,
}

impl Table {
    /// The point of a triangle of an instance of the world, by the weights of its second and third corner; `None` for lamps.
    pub(crate) fn at(&self, instance: u32, triangle: u32, uv: [f32; 2], p: Vec3, n: Vec3) -> Option<At<'_>> {
        let Target::Surface { surface, instance, part, placement } = *self.targets.get(instance as usize)?
        else {
            return None;
        };
        let (surface, instance) = (&self.surfaces[surface as usize], &self.instances[instance as usize]);
        let here = surface.geometry.parts.get(part as usize)?;
        let placed = here.placements.as_ref().and_then(|all| all.get(placement as usize));
        let spot = Spot {
            part,
            triangle,
            weights: [1.0 - uv[0] - uv[1], uv[0], uv[1]],
            primitive: here.primitive(triangle, placed.map_or(0, |placed| placed.primitive)),
            ends: placed.map_or([0; 2], |placed| placed.ends),
            position: point(&instance.object_from_world, p).to_array(),
        };
        Some(At { surface, instance, spot, position: p, normal: n })
    }

    /// The same by the point alone, which lies on the triangle.
    pub(crate) fn at_position(&self, instance: u32, triangle: u32, p: Vec3, n: Vec3) -> Option<At<'_>> {
        let mut at = self.at(instance, triangle, [0.0; 2], p, n)?;
        let part = &at.surface.geometry.parts[at.spot.part as usize];
        if part.placements.is_none()
            && let Some(corners) = part.mesh().corners(triangle as usize)
        {
            let [a, b, c] = corners.map(|vertex| Vec3::from(part.mesh().positions[vertex]));
            let p = Vec3::from(at.spot.position);
            // Along a piece of a curve, values change with the second weight.
            at.spot.weights =
                if part.mesh().has_triangles() { weights([a, b, c], p) } else { along([a, b], p) };
        }
        Some(at)
    }

    /// The lamp that an instance of the world shows.
    pub(crate) fn area_light(&self, instance: u32) -> Option<&AreaLight> {
        match self.targets.get(instance as usize)? {
            Target::AreaLight(area_light) => self.area_lights.get(*area_light as usize),
            Target::Surface { .. } => None,
        }
    }
}

/// Weights of a triangle's corners at a point of its plane.
fn weights([a, b, c]: [Vec3; 3], p: Vec3) -> [f32; 3] {
    let (u, v, w) = (b - a, c - a, p - a);
    let normal = u.cross(v);
    let area = normal.length_squared();
    let (second, third) = (w.cross(v).dot(normal) / area, u.cross(w).dot(normal) / area);
    if second.is_finite() && third.is_finite() {
        [1.0 - second - third, second, third]
    } else {
        [1.0, 0.0, 0.0]
    }
}

/// Weights of a segment's ends at the foot of a point.
fn along([a, b]: [Vec3; 2], p: Vec3) -> [f32; 3] {
    let share = (p - a).dot(b - a) / (b - a).length_squared();
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
    [1.0 - share, share, 0.0]
}

impl At<'_> {
    /// Where an attribute of two numbers grows with the first of them along the surface, and with the second: world space. `None`
    /// where it is constant.
    pub(crate) fn axes(&self, which: Attribute) -> Option<[Vec3; 2]> {
        let part = &self.surface.geometry.parts[self.spot.part as usize];
        if part.placements.is_some() {
            return None;
        }
        let corners = *part.mesh().indices.get(self.spot.triangle as usize)?;
        let mut value = [[0.0; 2]; 3];
        for (k, value) in value.iter_mut().enumerate() {
            let mut weights = [0.0; 3];
            weights[k] = 1.0;
            let Attribute::Free(which) = which else { return None };
            let [u, v, ..] = self.surface.geometry.attribute(which, &Spot { weights, ..self.spot })?;
            *value = [u, v];
        }
        let [a, b, c] = corners.map(|vertex| Vec3::from(part.mesh().positions[vertex as usize]));
        let [[u0, v0], [u1, v1], [u2, v2]] = value;
        let (du1, du2, dv1, dv2) = (u1 - u0, u2 - u0, v1 - v0, v2 - v0);
        let area = du1 * dv2 - du2 * dv1;
        let to_world = linear(&self.instance.world_from_object);
        let (along_u, along_v) =
            (((b - a) * dv2 - (c - a) * dv1) / area, ((c - a) * du1 - (b - a) * du2) / area);
        (along_u.is_finite() && along_v.is_finite()).then(|| [to_world * along_u, to_world * along_v])
    }

    /// The mesh's own tangent, world space, and the side of the bitangent; `None` where it has none.
    pub(crate) fn tangent(&self) -> Option<(Vec3, f32)> {
        let mesh = self.surface.geometry.parts[self.spot.part as usize].mesh();
        let corners = *mesh.indices.get(self.spot.triangle as usize)?;
        let mut sum = Vec3::ZERO;
        let mut side = 1.0;
        for (vertex, weight) in corners.into_iter().zip(self.spot.weights) {
            let [x, y, z, w] = *mesh.tangents.get(vertex as usize)?;
            sum += Vec3::new(x, y, z) * weight;
            side = w;
        }
        Some(((linear(&self.instance.world_from_object) * sum).try_normalize()?, side))
    }
}

impl Point for At<'_> {
    fn attribute(&self, which: Attribute) -> Color {
        let of = |v: Vec3| [v.x, v.y, v.z, 1.0];
        match which {
            Attribute::Free(which) => self.instance.attributes[which]
                .or_else(|| self.surface.geometry.attribute(which, &self.spot))
                .unwrap_or(NOTHING),
            Attribute::WorldPosition => of(self.position),
            Attribute::WorldNormal => of(self.normal),
            Attribute::ObjectPosition => of(Vec3::from(self.spot.position)),
            Attribute::ObjectNormal => {
                let transposed = linear(&self.instance.world_from_object).transpose();
                of((transposed * self.normal).normalize_or_zero())
            }
            Attribute::PrimitiveId => [self.spot.primitive as f32, 0.0, 0.0, 1.0],
        }
    }

    fn primitive(&self) -> u32 {
        self.spot.primitive
    }
}
