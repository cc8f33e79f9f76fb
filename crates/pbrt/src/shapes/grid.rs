// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces over texture coordinates as grids of triangles. Tests: `tests/shapes.rs`.

use gnurt_scene::Mesh;

/// A grid of places with texture coordinates: `columns` by `rows` cells, triangles counter-clockwise where v grows to the left of u.
pub(super) fn grid(columns: u32, rows: u32, at: impl Fn(f64, f64) -> ([f64; 3], [f64; 3])) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            let (position, normal) = at(u, v);
            mesh.positions.push(position.map(|x| x as f32));
            mesh.normals.push(normal.map(|x| x as f32));
            mesh.texcoords.push([u as f32, v as f32]);
        }
    }
    let corner = |i: u32, j: u32| j * (columns + 1) + i;
    for j in 0..rows {
        for i in 0..columns {
            let [a, b] = [corner(i, j), corner(i + 1, j)];
            let [c, d] = [corner(i + 1, j + 1), corner(i, j + 1)];
            mesh.indices.push([a, b, c]);
            mesh.indices.push([a, c, d]);
        }
    }
    mesh
}
