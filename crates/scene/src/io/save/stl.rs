// SPDX-License-Identifier: GPL-3.0-or-later
//! STL, binary: all triangles in world space.
//! Source: 3D Systems, StereoLithography Interface Specification, 1989. Tests: `tests/solids.rs`.

use std::path::Path;

use glam::Vec3;

use super::files::{leave_out, write};
use super::world;
use crate::io::{Error, Warnings};
use crate::mesh::Mesh;
use crate::scene::Scene;

pub(in crate::io) fn save(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<(), Error> {
    let used = || world::world_meshes(scene).map(|(id, transformed)| (scene.mesh(id), transformed));
    let count: usize = used().map(|(mesh, _)| mesh.indices.len()).sum();
    let Ok(count) = u32::try_from(count) else {
        return Err(Error::io(path, format!("{count} triangles"), "STL holds at most 2^32 - 1"));
    };
    let mut bytes = vec![b' '; 80];
    // A header that begins with `solid` would be taken for a text.
    let header = format!("binary STL, {}", gnurt_image::SOFTWARE);
    bytes.iter_mut().zip(header.bytes()).for_each(|(to, byte)| *to = byte);
    bytes.extend(count.to_le_bytes());
    for (mesh, transformed) in used() {
        let positions: Vec<[f32; 3]> = world::positions(mesh, transformed).collect();
        for triangle in world::triangles(mesh, transformed) {
            let corners = triangle.map(|i| Vec3::from(positions[i as usize]));
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            for vector in [normal, corners[0], corners[1], corners[2]] {
                vector.to_array().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
            }
            bytes.extend([0; 2]);
        }
    }
    let has = |full: fn(&Mesh) -> bool| scene.meshes().iter().filter(|mesh| full(mesh)).count();
    leave_out(has(|mesh| !mesh.normals.is_empty()), "mesh's normals", path, warnings);
    leave_out(has(|mesh| !mesh.texcoords.is_empty()), "mesh's texture coordinates", path, warnings);
    leave_out(has(|mesh| !mesh.colors.is_empty()), "mesh's colours", path, warnings);
    leave_out(scene.cameras().len(), "camera", path, warnings);
    leave_out(scene.lights().len(), "light", path, warnings);
    leave_out(scene.materials().len(), "material", path, warnings);
    write(path, &bytes)
}
