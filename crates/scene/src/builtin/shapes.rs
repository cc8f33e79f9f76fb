// SPDX-License-Identifier: GPL-3.0-or-later
//! Shapes that scenes are made of.
//! Space: object, +Y up; normals point outwards, triangles run counter-clockwise seen from outside.
//! Tests: `tests::normals_agree_with_winding`.

use std::f32::consts::{PI, TAU};

use crate::affine::Affine;
use crate::id::MaterialId;
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Rotates a profile `(radius, height)`, from bottom to top, around the y axis. Texture coordinates run
/// around and up.
pub(super) fn lathe(profile: &[[f32; 2]], segments: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let last = profile.len() - 1;
    for (i, &[r, y]) in profile.iter().enumerate() {
        let (below, above) = (profile[i.saturating_sub(1)], profile[(i + 1).min(last)]);
        let [dr, dy] = [above[0] - below[0], above[1] - below[1]];
        for j in 0..=segments {
            let u = j as f32 / segments as f32;
            let (s, c) = (u * TAU).sin_cos();
            mesh.positions.push([r * s, y, r * c]);
            mesh.normals.push([dy * s, -dr, dy * c]);
            mesh.texcoords.push([u, i as f32 / last as f32]);
        }
    }
    let vertex = |i: usize, j: u32| i as u32 * (segments + 1) + j;
    for i in 0..last {
        for j in 0..segments {
            let [a, b, c, d] = [vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)];
            // At the axis a quad has only one triangle.
            if profile[i][0] > 0.0 {
                mesh.indices.push([a, b, c]);
            }
            if profile[i + 1][0] > 0.0 {
                mesh.indices.push([a, c, d]);
            }
        }
    }
    mesh
}

/// A sphere around the origin.
pub(crate) fn sphere(radius: f32, rings: u32) -> Mesh {
    let ring = |i: u32| {
        let (s, c) = (PI * i as f32 / rings as f32).sin_cos();
        // The poles lie exactly on the axis.
        [if i == 0 || i == rings { 0.0 } else { radius * s }, -radius * c]
    };
    let mut mesh = lathe(&(0..=rings).map(ring).collect::<Vec<_>>(), 2 * rings);
    mesh.normals.clone_from(&mesh.positions);
    mesh
}

/// A parallelogram; its normal is `u x v`. Texture coordinates run along `u` and `v`.
pub(super) fn quad(corner: [f32; 3], u: [f32; 3], v: [f32; 3]) -> Mesh {
    let add = |a: [f32; 3], b: [f32; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    Mesh {
        positions: vec![corner, add(corner, u), add(add(corner, u), v), add(corner, v)],
        texcoords: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// An upright block over a ground rectangle, whose corners run counter-clockwise seen from above.
pub(super) fn block(ground: [[f32; 2]; 4], height: f32) -> Mesh {
    let corner = |k: usize, y: f32| [ground[k % 4][0], y, ground[k % 4][1]];
    let face = |corners: [[f32; 3]; 4]| Mesh {
        positions: corners.to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let mut mesh = face([0, 1, 2, 3].map(|k| corner(k, height)));
    for k in 0..4 {
        append(
            &mut mesh,
            &face([corner(k, 0.0), corner(k + 1, 0.0), corner(k + 1, height), corner(k, height)]),
        );
    }
    mesh
}

/// Appends a mesh that has the same optional arrays.
pub(super) fn append(to: &mut Mesh, from: &Mesh) {
    let base = to.positions.len() as u32;
    to.positions.extend(&from.positions);
    to.normals.extend(&from.normals);
    to.texcoords.extend(&from.texcoords);
    to.colors.extend(&from.colors);
    to.indices.extend(from.indices.iter().map(|t| t.map(|i| base + i)));
}

/// The mesh under a transform that neither shears nor stretches unevenly.
pub(super) fn transformed(mut mesh: Mesh, transform: Affine) -> Mesh {
    for p in &mut mesh.positions {
        *p = transform.point(p.map(f64::from)).map(|x| x as f32);
    }
    for n in &mut mesh.normals {
        *n = transform.vector(n.map(f64::from)).map(|x| x as f32);
    }
    mesh
}

/// The mesh moved.
pub(super) fn moved(mesh: Mesh, by: [f32; 3]) -> Mesh {
    transformed(mesh, Affine::translation(by.map(f64::from)))
}

/// Adds an object of one mesh and an instance of it at the origin.
pub(super) fn show(scene: &mut Scene, name: &str, mesh: Mesh, material: MaterialId) {
    let mesh = scene.add_mesh(Mesh { name: name.to_owned(), material, ..mesh });
    let object = scene.add_object_of(name, vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_agree_with_winding() {
        let cone = lathe(&[[1.0, 0.0], [0.5, 1.0], [0.0, 2.0]], 8);
        for (name, mesh) in [("sphere", sphere(2.0, 6)), ("cone", cone)] {
            for triangle in &mesh.indices {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
                let normal =
                    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                for &i in triangle {
                    let n = mesh.normals[i as usize];
                    let cosine: f32 = (0..3).map(|k| n[k] * normal[k]).sum();
                    assert!(cosine > 0.0, "{name}: {triangle:?} turns away from its normals");
                }
            }
        }
        let block = block([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]], 1.0);
        let volume: f32 = block
            .indices
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| block.positions[i as usize]);
                let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
                (0..3).map(|k| a[k] * cross[k]).sum::<f32>() / 6.0
            })
            .sum();
        assert!(
            volume > 0.6,
            "all faces of a block look outwards (its floor lies in the origin's plane): {volume}"
        );
    }
}
