// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes whose materials are chosen, where they are, and points on them.
//! Space: world, at the time when the shutter opens. Tests: crates/render/tests/caustics.rs.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;
use gnurt_scene::{Mesh, Primitives, RayMask};
use gnurt_shading::sampling::{Distribution, triangle, uniform_sphere};

use super::World;
use super::instance::InstanceSlot;

/// A mesh in an instance.
#[derive(Clone, Debug)]
pub(crate) struct PlacedMesh {
    pub(crate) leaf_id: u32,
    pub(crate) geom_id: u32,
    pub(crate) inst_id: u32,
    pub(crate) material: u32,
    /// About: stretches count by their mean.
    pub(crate) area: f32,
    /// A ball around it.
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
    /// Its primitives by their areas in the object.
    primitives: Arc<Distribution>,
}

/// A point of a mesh: primitive, barycentric weights, position and normal, outwards.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshPoint {
    pub(crate) prim_id: u32,
    pub(crate) uv: [f32; 2],
    pub(crate) p: Vec3,
    pub(crate) normal: Vec3,
}

impl World {
    /// All meshes of triangles and spheres that scattered rays meet and whose material is one of some.
    pub(crate) fn meshes_of(&self, is_one: impl Fn(usize) -> bool) -> Vec<PlacedMesh> {
        let mut found = Vec::new();
        let mut known: HashMap<*const Mesh, Option<Arc<Distribution>>> = HashMap::new();
        for (inst_id, slot) in (0..).zip(self.instances.iter()) {
            let Some(placed) = InstanceSlot::placed(slot) else { continue };
            if !placed.mask.meets(RayMask::OTHER) || !placed.object.has_material(&is_one) {
                continue;
            }
            let first = self.tree.first_leaf(inst_id);
            let leaves = placed.object.members.as_ref().map_or(1, |members| members.tree.leaf_count());
            for leaf in 0..leaves {
                let (object, at) = (placed.leaf(leaf).0, placed.leaf_at(leaf, 0.0));
                let meshes = (0..).zip(object.meshes.iter());
                for (geom_id, mesh) in meshes.filter(|(_, mesh)| is_one(mesh.material.index())) {
                    let primitives = known.entry(Arc::as_ptr(mesh)).or_insert_with(|| by_area(mesh)).clone();
                    let Some(primitives) = primitives else { continue };
                    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
                    for &p in &mesh.positions {
                        let p = at.point(p.into());
                        (low, high) = (low.min(p), high.max(p));
                    }
                    let stretch = at.linear.determinant().abs().cbrt();
                    let most = match &mesh.primitives {
                        Primitives::Spheres(radii) => radii.iter().fold(0.0_f32, |most, &r| most.max(r)),
                        _ => 0.0,
                    };
                    let placed_mesh = PlacedMesh {
                        leaf_id: first + leaf,
                        geom_id,
                        inst_id,
                        material: mesh.material.0,
                        area: primitives.total() as f32 * stretch * stretch,
                        center: 0.5 * (low + high),
                        radius: 0.5 * (high - low).length() + most * stretch,
                        primitives,
                    };
                    if placed_mesh.area > 0.0 && placed_mesh.radius.is_finite() {
                        found.push(placed_mesh);
                    }
                }
            }
        }
        found
    }

    /// A point on a mesh by three numbers in [0, 1).
    pub(crate) fn point_on(&self, mesh: &PlacedMesh, [choice, x, y]: [f32; 3]) -> Option<MeshPoint> {
        let prim = mesh.primitives.sample(choice).index;
        let (instance, leaf) = self.surface_points().instance(mesh.leaf_id);
        let object = instance.leaf(leaf).0;
        let of = &*object.meshes[mesh.geom_id as usize];
        let at = instance.leaf_at(leaf, 0.0);
        let corner = |vertex: usize| of.positions.get(vertex).map(|&p| Vec3::from(p));
        let (p, normal, uv) = match &of.primitives {
            Primitives::Spheres(radii) => {
                let out = uniform_sphere([x, y]);
                (corner(prim)? + out * radii[prim], out, [0.0; 2])
            }
            _ => {
                let [a, b, c] = of.corners(prim)?.map(corner);
                let (a, b, c) = (a?, b? - a?, c? - a?);
                let uv = triangle([x, y]);
                (a + b * uv[0] + c * uv[1], b.cross(c), uv)
            }
        };
        let normal = (at.normals * normal).try_normalize()?;
        Some(MeshPoint { prim_id: prim as u32, uv, p: at.point(p), normal })
    }
}

/// Primitives by their areas; `None` if they have none.
fn by_area(mesh: &Mesh) -> Option<Arc<Distribution>> {
    let area = |prim: usize| -> f64 {
        let Some(corners) = mesh.corners(prim) else { return 0.0 };
        let [a, b, c] = corners.map(|vertex| mesh.positions.get(vertex).map_or(Vec3::ZERO, |&p| p.into()));
        f64::from(0.5 * (b - a).cross(c - a).length())
    };
    let areas: Vec<f64> = match &mesh.primitives {
        Primitives::Curves(_) => return None,
        Primitives::Spheres(radii) => {
            radii.iter().map(|&r| 4.0 * std::f64::consts::PI * f64::from(r).powi(2)).collect()
        }
        Primitives::Triangles => (0..mesh.indices.len()).map(area).collect(),
    };
    Distribution::new(areas).map(Arc::new)
}
