// SPDX-License-Identifier: GPL-3.0-or-later
//! PLY, binary little endian: all geometry in one mesh. Colours are floats, linear, as they are here.
//! Source: G. Turk, The PLY polygon file format, 1994. Tests: `tests/save.rs`.

use std::path::Path;

use super::files::{leave_out, write};
use super::losses;
use super::world;
use crate::io::{Error, Warnings};
use crate::mesh::Mesh;
use crate::scene::Scene;

pub(in crate::io) fn save(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<(), Error> {
    let used = || world::world_meshes(scene).map(|(id, transformed)| (scene.mesh(id), transformed));
    let has = |full: fn(&Mesh) -> bool| used().any(|(mesh, _)| full(mesh));
    let normals = has(|m| !m.normals.is_empty());
    let texcoords = has(|m| !m.texcoords.is_empty());
    let colors = has(|m| !m.colors.is_empty());

    let vertices: usize = used().map(|(m, _)| m.positions.len()).sum();
    let triangles: usize = used().map(|(m, _)| m.indices.len()).sum();
    if vertices > i32::MAX as usize {
        return Err(Error::io(path, format!("{vertices} vertices"), "PLY holds at most 2^31 - 1"));
    }
    let mut properties = vec!["x", "y", "z"];
    properties.extend(normals.then_some(["nx", "ny", "nz"]).iter().flatten());
    properties.extend(texcoords.then_some(["u", "v"]).iter().flatten());
    properties.extend(colors.then_some(["red", "green", "blue", "alpha"]).iter().flatten());
    let properties: String = properties.iter().map(|name| format!("property float {name}\n")).collect();
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {vertices}\n{properties}\
         element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n",
        gnurt_image::SOFTWARE
    )
    .into_bytes();

    for (mesh, transformed) in used() {
        let mut normal = world::normals(mesh, transformed);
        for (i, position) in world::positions(mesh, transformed).enumerate() {
            put(&mut bytes, &position);
            if normals {
                put(&mut bytes, &normal.next().unwrap_or([0.0; 3]));
            }
            if texcoords {
                put(&mut bytes, mesh.texcoords.get(i).unwrap_or(&[0.0; 2]));
            }
            if colors {
                put(&mut bytes, mesh.colors.get(i).unwrap_or(&[1.0; 4]));
            }
        }
    }
    let mut base = 0;
    for (mesh, transformed) in used() {
        for triangle in world::triangles(mesh, transformed) {
            bytes.push(3);
            triangle.iter().for_each(|i| bytes.extend((base + i).to_le_bytes()));
        }
        base += mesh.positions.len() as u32;
    }
    losses::of_texcoords(scene, path, warnings);
    leave_out(scene.cameras().len(), "camera", path, warnings);
    leave_out(scene.lights().len(), "light", path, warnings);
    leave_out(scene.materials().len(), "material", path, warnings);
    write(path, &bytes)
}

fn put(bytes: &mut Vec<u8>, floats: &[f32]) {
    floats.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
}
