// SPDX-License-Identifier: GPL-3.0-or-later
//! Shapes of a mesh at moments of an open shutter, kept as attributes of it, so that they follow its vertices.
//! Names: `gnurt:vertices:K` and `gnurt:normals:K`, K from 0. Tests: `tests/test_pictures.py::test_meshes_bend`.

use std::sync::Arc;

use gnurt::scene::{Mesh, Rate};

/// The meshes of all moments, two at least.
pub(crate) fn of(mesh: &Mesh) -> Result<Vec<Arc<Mesh>>, String> {
    let found = |what: &str, k: usize| {
        let name = format!("gnurt:{what}:{k}");
        let attribute = mesh.attributes.iter().find(|attribute| attribute.name == name)?;
        let is_sound = (attribute.rate, attribute.components) == (Rate::Vertex, 3);
        is_sound.then(|| attribute.data.as_chunks::<3>().0.to_vec())
    };
    let mut keys = Vec::new();
    while let Some(positions) = found("vertices", keys.len()) {
        let normals = found("normals", keys.len()).unwrap_or_default();
        if normals.is_empty() != mesh.normals.is_empty() {
            return Err(format!("motion: mesh '{}' has normals at some moments only", mesh.name));
        }
        let tangents = if normals.is_empty() { mesh.tangents.clone() } else { Vec::new() };
        keys.push(Arc::new(Mesh { positions, normals, tangents, ..mesh.clone() }));
    }
    if keys.len() < 2 {
        return Err(format!("motion: mesh '{}' has no moments; give add_mesh(moments=...)", mesh.name));
    }
    Ok(keys)
}
