// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes unfolded into world space, for formats without instances.
//! Normals are transformed by the inverse transpose; if an instance mirrors, triangles are reversed, so that
//! the geometric normal stays on its side.

use crate::affine::Affine;
use crate::id::MeshId;
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Every mesh of every visible instance that can be placed, those of objects in objects too.
pub(super) fn world_meshes(scene: &Scene) -> impl Iterator<Item = (MeshId, Affine)> + '_ {
    let transformed = scene.occurrences().filter(|found| found.world_from_object.inverse().is_some());
    transformed.flat_map(|found| found.object.meshes.iter().map(move |&mesh| (mesh, found.world_from_object)))
}

pub(super) fn positions(mesh: &Mesh, world_from_object: Affine) -> impl Iterator<Item = [f32; 3]> + '_ {
    mesh.positions.iter().map(move |p| world_from_object.point(p.map(f64::from)).map(|x| x as f32))
}

pub(super) fn normals(mesh: &Mesh, world_from_object: Affine) -> impl Iterator<Item = [f32; 3]> + '_ {
    let object_from_world = world_from_object.inverse().unwrap_or_default();
    mesh.normals.iter().map(move |n| {
        let [a, b, c, _] = object_from_world.columns;
        let n = n.map(f64::from);
        let dot = |column: [f64; 3]| (0..3).map(|k| column[k] * n[k]).sum::<f64>();
        let v = [dot(a), dot(b), dot(c)];
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 { v.map(|x| (x / length) as f32) } else { [0.0; 3] }
    })
}

pub(super) fn triangles(mesh: &Mesh, world_from_object: Affine) -> impl Iterator<Item = [u32; 3]> + '_ {
    let mirrors = world_from_object.determinant() < 0.0;
    mesh.indices.iter().map(move |&[a, b, c]| if mirrors { [a, c, b] } else { [a, b, c] })
}
