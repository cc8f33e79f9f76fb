// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres as triangles, for formats without spheres: lamps and balls are not lost. Large clouds of points are.
//! Tests: `tests/save.rs::spheres_become_triangles`.

use crate::builtin::shapes;
use crate::id::MeshId;
use crate::mesh::Mesh;
use crate::primitives::Primitives;
use crate::scene::Scene;

/// Rings of a sphere's triangles.
const RINGS: u32 = 16;
/// Meshes of more spheres are left out.
const MOST: usize = 1024;

/// The scene with triangles in place of spheres; `None` if it has no mesh of few spheres.
pub(in crate::io) fn with_triangles(scene: &Scene) -> Option<Scene> {
    let few = |mesh: &Mesh| match &mesh.primitives {
        Primitives::Spheres(radii) => (1..=MOST).contains(&radii.len()),
        _ => false,
    };
    scene.meshes().iter().any(|mesh| few(mesh)).then(|| {
        let mut changed = scene.clone();
        for (i, mesh) in scene.meshes().iter().enumerate().filter(|(_, mesh)| few(mesh)) {
            *changed.edit_mesh(MeshId(i as u32)) = triangles(mesh);
        }
        changed
    })
}

fn triangles(mesh: &Mesh) -> Mesh {
    let Primitives::Spheres(radii) = &mesh.primitives else { return mesh.clone() };
    let ball = shapes::sphere(1.0, RINGS);
    let mut all = Mesh { name: mesh.name.clone(), material: mesh.material, ..Mesh::default() };
    for (k, (center, &radius)) in mesh.positions.iter().zip(radii).enumerate() {
        let first = all.positions.len() as u32;
        all.positions
            .extend(ball.positions.iter().map(|p| std::array::from_fn(|i| center[i] + radius * p[i])));
        all.normals.extend(&ball.normals);
        match mesh.texcoords.get(k) {
            Some(&uv) => all.texcoords.extend(ball.positions.iter().map(|_| uv)),
            None => all.texcoords.extend(&ball.texcoords),
        }
        if let Some(&color) = mesh.colors.get(k) {
            all.colors.extend(ball.positions.iter().map(|_| color));
        }
        all.indices.extend(ball.indices.iter().map(|triangle| triangle.map(|i| first + i)));
    }
    all
}
