// SPDX-License-Identifier: GPL-3.0-or-later
//! Polygons with values at their corners as triangles with values at their vertices.
//! Corners become one vertex where they have the same point and the same elements.
//! Tests: `tests/meshes.rs`.

use std::borrow::Cow;

use gnurt_scene::Mesh;
use gnurt_scene::io::reader::{CornerNumbers, Cutter};
use gnurt_scene::subdivision::Faces;

use crate::attributes::Attribute;

/// A mesh with all that its corners have.
pub(crate) struct Corners<'a> {
    pub(crate) faces: &'a Faces,
    pub(crate) points: Cow<'a, [[f32; 3]]>,
    pub(crate) normals: Option<&'a Attribute>,
    pub(crate) texcoords: Option<&'a Attribute>,
    pub(crate) colors: Option<&'a Attribute>,
    pub(crate) opacities: Option<&'a Attribute>,
    /// Whether faces run clockwise seen from their outside.
    pub(crate) is_left_handed: bool,
    /// Whether all faces are taken.
    pub(crate) is_whole: bool,
}

impl Corners<'_> {
    /// Triangles of all faces, or of those that `take` chooses.
    pub(crate) fn mesh(self, cutter: &mut Cutter, take: impl Fn(usize) -> bool) -> Mesh {
        let parts = [self.normals, self.texcoords, self.colors, self.opacities];
        match parts.iter().flatten().all(|part| part.is_of_points()) {
            true => self.by_points(cutter, take),
            false => self.by_corners(cutter, take),
        }
    }

    /// A vertex for each used point, in the order of the points.
    fn by_points(self, cutter: &mut Cutter, take: impl Fn(usize) -> bool) -> Mesh {
        let corners = self.faces.corners();
        let mut triangles = Vec::with_capacity(if self.is_whole { self.faces.len() } else { 0 });
        match self.is_whole && corners.len() == 3 * self.faces.len() {
            true => triangles.extend_from_slice(corners.as_chunks::<3>().0),
            false => {
                for face in (0..self.faces.len()).filter(|&face| take(face)) {
                    let face = &corners[self.faces.range(face)];
                    let position = |i: usize| self.points[face[i] as usize];
                    cutter.cut(face.len(), position, |triangle| triangles.push(triangle.map(|i| face[i])));
                }
            }
        }
        if self.is_left_handed {
            triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
        }
        let mut is_used = vec![false; self.points.len()];
        triangles.as_flattened().iter().for_each(|&point| is_used[point as usize] = true);
        let mut mesh = Mesh { indices: triangles, ..Mesh::default() };
        let are_all_used = !is_used.contains(&false);
        if !are_all_used {
            let mut numbers = vec![u32::MAX; is_used.len()];
            for point in (0..is_used.len()).filter(|&point| is_used[point]) {
                numbers[point] = mesh.positions.len() as u32;
                mesh.positions.push(self.points[point]);
            }
            mesh.indices.as_flattened_mut().iter_mut().for_each(|point| *point = numbers[*point as usize]);
        }
        let used = || (0..is_used.len()).filter(|&point| is_used[point]).map(|point| point as u32);
        let element = |part: &Attribute, point: u32| part.element(0, 0, point);
        let count = if are_all_used { is_used.len() } else { mesh.positions.len() };
        if let Some(part) = self.normals {
            mesh.normals.reserve(count);
            mesh.normals.extend(used().map(|point| part.get(element(part, point), [0.0; 3])));
        }
        if let Some(part) = self.texcoords {
            mesh.texcoords.reserve(count);
            mesh.texcoords.extend(used().map(|point| part.get(element(part, point), [0.0; 2])));
        }
        if self.colors.is_some() || self.opacities.is_some() {
            let of = |part: Option<&Attribute>, point| part.map_or(0, |part| element(part, point));
            let rgba = used().map(|point| self.color(of(self.colors, point), of(self.opacities, point)));
            mesh.colors.extend(rgba);
        }
        if are_all_used {
            mesh.positions = self.points.into_owned();
        }
        mesh
    }

    /// A vertex for all corners with the same point and elements, in the order of their first use.
    fn by_corners(self, cutter: &mut Cutter, take: impl Fn(usize) -> bool) -> Mesh {
        let mut mesh = Mesh::default();
        let parts = [self.normals, self.texcoords, self.colors, self.opacities];
        let mut by_elements = CornerNumbers::default();
        by_elements.extend(self.points.len());
        mesh.indices.reserve(if self.is_whole { self.faces.len() } else { 0 });
        let mut vertices = Vec::new();
        for face in (0..self.faces.len()).filter(|&face| take(face)) {
            let range = self.faces.range(face);
            vertices.clear();
            for corner in range.clone() {
                let point = self.faces.corners()[corner];
                let next = mesh.positions.len() as u32;
                let elements = parts.map(|part| part.map_or(0, |part| part.element(face, corner, point)));
                let vertex = by_elements.number(point, elements, next);
                if vertex == next {
                    self.push(&mut mesh, point, elements);
                }
                vertices.push(vertex);
            }
            let position = |i: usize| self.points[self.faces.corners()[range.start + i] as usize];
            cutter.cut(vertices.len(), position, |[a, b, c]| {
                let [a, b, c] = [a, b, c].map(|corner| vertices[corner]);
                mesh.indices.push(if self.is_left_handed { [a, c, b] } else { [a, b, c] });
            });
        }
        mesh
    }

    fn push(&self, mesh: &mut Mesh, point: u32, [normal, texcoord, color, opacity]: [u32; 4]) {
        mesh.positions.push(self.points[point as usize]);
        if let Some(normals) = self.normals {
            mesh.normals.push(normals.get(normal, [0.0; 3]));
        }
        if let Some(texcoords) = self.texcoords {
            mesh.texcoords.push(texcoords.get(texcoord, [0.0; 2]));
        }
        if self.colors.is_some() || self.opacities.is_some() {
            mesh.colors.push(self.color(color, opacity));
        }
    }

    /// A colour with its opacity.
    fn color(&self, color: u32, opacity: u32) -> [f32; 4] {
        let mut rgba = self.colors.map_or([1.0; 4], |colors| colors.get(color, [0.0, 0.0, 0.0, 1.0]));
        if let Some(opacities) = self.opacities {
            [rgba[3]] = opacities.get(opacity, [1.0]);
        }
        rgba
    }
}
