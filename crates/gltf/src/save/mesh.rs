// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes in glTF's words, with what bends them.
//! Source: glTF 2.0 section 3.7. A mesh that bends is written as nothing bends it, with its morph targets and
//! joints. Tests: `tests/save.rs`.

use serde_json::{Map, Value, json};

use super::buffer::Buffer;
use gnurt_scene::animation::{Animation, Body};
use gnurt_scene::id::MeshId;
use gnurt_scene::mesh::Mesh;
use gnurt_scene::motion::Motion;
use gnurt_scene::{Object, Scene};

/// The bodies of an animation by their meshes.
pub(super) fn body(animation: Option<&Animation>, mesh: MeshId) -> Option<&Body> {
    animation?.bodies.iter().find(|body| body.mesh == mesh)
}

/// The meshes of an object that have triangles: glTF allows none without.
pub(super) fn shown_meshes<'a>(
    scene: &'a Scene,
    object: &'a Object,
) -> impl Iterator<Item = (&'a Mesh, Option<&'a Body>)> {
    let with_body = |&id: &MeshId| match body(scene.animation(), id) {
        Some(body) => (&*body.base, Some(body)),
        None => (scene.mesh(id), None),
    };
    object.meshes.iter().map(with_body).filter(|(mesh, _)| !mesh.indices.is_empty())
}

/// An object's mesh, of a primitive for each of its meshes.
pub(super) fn mesh(scene: &Scene, object: &Object, buffer: &mut Buffer) -> Value {
    let mut weights = None;
    let primitives = shown_meshes(scene, object).map(|(mesh, body)| {
        weights = weights.or(body.and_then(|body| body.weights));
        primitive(mesh, body, buffer)
    });
    let mut mesh = json!({ "name": object.name, "primitives": primitives.collect::<Vec<_>>() });
    if let Some(set) = weights.and_then(|set| scene.animation()?.weights.get(set as usize)) {
        mesh["weights"] = json!(set);
    }
    if object.motion != Motion::Auto {
        mesh["extras"] = json!({ "gnurt_motion": object.motion.to_string() });
    }
    mesh
}

fn primitive(mesh: &Mesh, body: Option<&Body>, buffer: &mut Buffer) -> Value {
    let mut attributes = Map::new();
    attributes.insert("POSITION".into(), buffer.add_positions(&mesh.positions).into());
    if !mesh.normals.is_empty() {
        attributes.insert("NORMAL".into(), buffer.add_floats("VEC3", &unit_normals(mesh)).into());
    }
    if !mesh.texcoords.is_empty() {
        let down: Vec<_> = mesh.texcoords.iter().map(|[u, v]| [*u, 1.0 - v]).collect();
        attributes.insert("TEXCOORD_0".into(), buffer.add_floats("VEC2", &down).into());
    }
    let second: Vec<_> = mesh.second_texcoords().chunks_exact(2).map(|uv| [uv[0], 1.0 - uv[1]]).collect();
    if !second.is_empty() {
        attributes.insert("TEXCOORD_1".into(), buffer.add_floats("VEC2", &second).into());
    }
    if !mesh.tangents.is_empty() && !mesh.normals.is_empty() {
        let unit: Vec<_> = mesh.tangents.iter().map(unit_tangent).collect();
        attributes.insert("TANGENT".into(), buffer.add_floats("VEC4", &unit).into());
    }
    if !mesh.colors.is_empty() {
        attributes.insert("COLOR_0".into(), buffer.add_floats("VEC4", &mesh.colors).into());
    }
    if let Some(body) = body {
        put_joints(mesh, body, &mut attributes, buffer);
    }
    let indices = buffer.add_indices(&mesh.indices);
    let attributes = Value::Object(attributes);
    buffer.mark_attributes(&attributes);
    let mut made = json!({ "attributes": attributes, "indices": indices, "material": mesh.material.0 });
    if let Some(body) = body.filter(|body| !body.morphs.is_empty()) {
        let count = mesh.positions.len();
        let targets = body.morphs.iter().map(|morph| {
            // A target has positions, even if it moves none.
            let mut target = json!({ "POSITION": buffer.add_positions(&morph.positions.to_vec(count)) });
            for (name, deltas) in [("NORMAL", &morph.normals), ("TANGENT", &morph.tangents)] {
                if !deltas.is_empty() {
                    target[name] = buffer.add_floats("VEC3", &deltas.to_vec(count)).into();
                }
            }
            buffer.mark_attributes(&target);
            target
        });
        made["targets"] = targets.collect();
    }
    made
}

/// Four joints of each vertex after the other, in as many sets as the vertex with the most needs.
fn put_joints(mesh: &Mesh, body: &Body, attributes: &mut Map<String, Value>, buffer: &mut Buffer) {
    let Some(influences) = &body.influences else { return };
    let count = mesh.positions.len();
    let most = (0..count).map(|vertex| influences.of(vertex).len()).max().unwrap_or(0);
    for set in 0..most.div_ceil(4).max(1) {
        let at =
            |vertex: usize, k: usize| influences.of(vertex).get(4 * set + k).copied().unwrap_or((0, 0.0));
        let joints: Vec<[u16; 4]> = (0..count).map(|v| [0, 1, 2, 3].map(|k| at(v, k).0 as u16)).collect();
        let weights: Vec<[f32; 4]> = (0..count)
            .map(|v| {
                let sum: f32 = influences.of(v).iter().map(|(_, weight)| weight).sum();
                [0, 1, 2, 3].map(|k| at(v, k).1 / sum.max(f32::MIN_POSITIVE))
            })
            .collect();
        attributes.insert(format!("JOINTS_{set}"), buffer.add_joints(&joints).into());
        attributes.insert(format!("WEIGHTS_{set}"), buffer.add_floats("VEC4", &weights).into());
    }
}

/// As glTF requires: unit. A vertex without one gets that of its first triangle.
fn unit_normals(mesh: &Mesh) -> Vec<[f32; 3]> {
    let unit = |v: glam::Vec3| v.try_normalize();
    let mut normals: Vec<_> = mesh.normals.iter().map(|&normal| unit(normal.into())).collect();
    if normals.iter().any(Option::is_none) {
        for triangle in &mesh.indices {
            let [a, b, c] = triangle.map(|i| glam::Vec3::from(mesh.positions[i as usize]));
            for &vertex in triangle {
                let normal = &mut normals[vertex as usize];
                *normal = normal.or_else(|| unit((b - a).cross(c - a)));
            }
        }
    }
    normals.into_iter().map(|normal| normal.unwrap_or(glam::Vec3::Z).to_array()).collect()
}

/// As glTF requires: unit, and the fourth number 1 or -1. A zero tangent stays zero.
fn unit_tangent(&[x, y, z, side]: &[f32; 4]) -> [f32; 4] {
    let [x, y, z] = glam::Vec3::new(x, y, z).normalize_or_zero().to_array();
    [x, y, z, 1.0_f32.copysign(side)]
}
