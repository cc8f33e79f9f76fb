// SPDX-License-Identifier: GPL-3.0-or-later
//! Tangents for normal maps if a file has none: those that bakers of such maps use.
//! Source: MikkTSpace \[Mik08\], by the crate `bevy_mikktspace`. Space: object; coordinates have v upwards.
//! Vertices are not split: one whose triangles disagree on which side v grows (the seam of a mirrored map) has none, and its triangles
//! go by their own coordinates, which have the right side.
//! Invariant: any mesh that `Scene::check` lets pass is safe. Tests: `tests`; tests/gltf.rs.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};

use crate::mesh::Mesh;

/// Bytes that are held for a triangle while tangents are made, about.
pub const BYTES_PER_TRIANGLE: usize = 512;

/// Tangents per vertex, as [`Mesh::tangents`] has them; empty where the mesh has no normals or no texture coordinates.
#[must_use]
pub fn tangents(mesh: &Mesh) -> Vec<[f32; 4]> {
    if mesh.normals.is_empty() || mesh.texcoords.is_empty() || mesh.indices.is_empty() {
        return Vec::new();
    }
    let finite = |p: [f32; 3]| p.map(|x| if x.is_finite() { x } else { 0.0 });
    let reach = mesh.positions.iter().flat_map(|&p| finite(p)).fold(0.0_f32, |most, x| most.max(x.abs()));
    let scale = if reach > 0.0 { 1.0 / reach } else { 1.0 };
    let mut corners = Corners {
        mesh,
        scale,
        sums: vec![[0.0; 3]; mesh.positions.len()],
        sides: vec![Side::None; mesh.positions.len()],
    };
    if generate_tangents(&mut corners).is_err() {
        return Vec::new();
    }
    let Corners { sums, sides, .. } = corners;
    let of = |(sum, side): ([f32; 3], Side)| {
        let length = sum.iter().map(|x| x * x).sum::<f32>().sqrt();
        let [x, y, z] = sum.map(|x| x / length);
        match side {
            Side::One(w) if length > 1e-6 && [x, y, z].iter().all(|x| x.is_finite()) => [x, y, z, w],
            _ => [0.0; 4],
        }
    };
    sums.into_iter().zip(sides).map(of).collect()
}

/// On which side of a vertex v grows.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    None,
    One(f32),
    Both,
}

/// The corners of a mesh's triangles, and the values found for its vertices.
struct Corners<'a> {
    mesh: &'a Mesh,
    /// Brings all coordinates to [-1, 1], so that nothing overflows.
    scale: f32,
    sums: Vec<[f32; 3]>,
    sides: Vec<Side>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.indices[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.indices.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        let p = self.mesh.positions[self.vertex(face, corner)].map(|x| x * self.scale);
        p.map(|x| if x.is_finite() { x } else { 0.0 })
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let n = self.mesh.normals.get(self.vertex(face, corner)).copied().unwrap_or_default();
        let most = n.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        if !(most > 0.0 && most.is_finite() && n.iter().all(|x| x.is_finite())) {
            return [0.0, 0.0, 1.0];
        }
        let n = n.map(|x| x / most);
        let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
        n.map(|x| x / length)
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.mesh.texcoords.get(self.vertex(face, corner)).copied().unwrap_or_default();
        uv.map(|x| if x.is_finite() { x.clamp(-1e6, 1e6) } else { 0.0 })
    }

    fn set_tangent(&mut self, found: Option<TangentSpace>, face: usize, corner: usize) {
        let Some(found) = found else { return };
        let [x, y, z, w] = found.tangent_encoded();
        let vertex = self.vertex(face, corner);
        self.sides[vertex] = match self.sides[vertex] {
            Side::None => Side::One(w),
            Side::One(side) if side == w => Side::One(side),
            Side::One(_) | Side::Both => Side::Both,
        };
        let sum = &mut self.sums[vertex];
        [x, y, z].into_iter().zip(sum).for_each(|(x, sum)| *sum += x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares side by side in the plane z = 0; u runs along x in the first, and back in the second where `mirrored`.
    fn squares(mirrored: bool) -> Mesh {
        let u = |i: usize| if mirrored && i == 2 { 0.0 } else { i as f32 };
        let corners_order = (0..6).map(|k| (k % 3, k / 3));
        Mesh {
            positions: corners_order.clone().map(|(x, y)| [x as f32, y as f32, 0.0]).collect(),
            normals: vec![[0.0, 0.0, 2.0]; 6],
            texcoords: corners_order.map(|(x, y)| [u(x), y as f32]).collect(),
            indices: vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
            ..Mesh::default()
        }
    }

    #[test]
    fn tangents_follow_coordinates_and_their_mirrors() {
        let close = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
        for found in tangents(&squares(false)) {
            assert!(close(found, [1.0, 0.0, 0.0, 1.0]), "along x: {found:?}");
        }
        let found = tangents(&squares(true));
        for i in [0, 3] {
            assert!(close(found[i], [1.0, 0.0, 0.0, 1.0]), "{i}: {:?}", found[i]);
        }
        for i in [2, 5] {
            assert!(close(found[i], [-1.0, 0.0, 0.0, -1.0]), "u runs back, v still up: {i}: {:?}", found[i]);
        }
        for i in [1, 4] {
            assert_eq!(found[i], [0.0; 4], "on the seam");
        }
    }

    #[test]
    fn odd_meshes_are_survived() {
        let mut mesh = squares(false);
        mesh.positions[0] = [f32::NAN, f32::INFINITY, 1e38];
        mesh.positions[1] = [-3e38; 3];
        mesh.texcoords[2] = [f32::NAN, 1e30];
        mesh.normals[3] = [0.0; 3];
        mesh.normals[4] = [f32::NAN, 1.0, 0.0];
        mesh.indices.push([1, 1, 1]);
        for tangent in tangents(&mesh) {
            assert!(tangent.iter().all(|x| x.is_finite()), "{tangent:?}");
        }
        mesh.positions.iter_mut().for_each(|p| *p = [1.0; 3]);
        assert_eq!(tangents(&mesh).len(), 6, "all in one point");
        mesh.texcoords.clear();
        assert!(tangents(&mesh).is_empty(), "no coordinates");
    }
}
