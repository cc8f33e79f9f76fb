// SPDX-License-Identifier: GPL-3.0-or-later
//! Polygons with values at their corners as triangles with values at their vertices.
//! Corners become one vertex where they have the same point and the same elements. Tests: `tests/meshes.rs`.

use gnurt_scene::Mesh;
use gnurt_scene::io::reader::{CornerNumbers, Cutter};
use gnurt_scene::subdivision::Faces;

use crate::attributes::Attribute;

/// A mesh with all that its corners have.
pub(crate) struct Corners<'a> {
    pub(crate) faces: &'a Faces,
    pub(crate) points: &'a [[f32; 3]],
    pub(crate) normals: Option<&'a Attribute>,
    pub(crate) texcoords: Option<&'a Attribute>,
    pub(crate) colors: Option<&'a Attribute>,
    pub(crate) opacities: Option<&'a Attribute>,
    /// Whether faces run clockwise seen from their outside.
    pub(crate) is_left_handed: bool,
}

impl Corners<'_> {
    /// Triangles of the faces that `take` chooses.
    pub(crate) fn mesh(&self, cutter: &mut Cutter, take: impl Fn(usize) -> bool) -> Mesh {
        let mut mesh = Mesh::default();
        let parts = [self.normals, self.texcoords, self.colors, self.opacities];
        let is_of_points = parts.iter().flatten().all(|part| part.is_of_points());
        let mut by_point = vec![u32::MAX; if is_of_points { self.points.len() } else { 0 }];
        let mut by_elements = CornerNumbers::default();
        by_elements.extend(if is_of_points { 0 } else { self.points.len() });
        let mut vertices = Vec::new();
        for face in (0..self.faces.len()).filter(|&face| take(face)) {
            let range = self.faces.range(face);
            vertices.clear();
            for corner in range.clone() {
                let point = self.faces.corners()[corner];
                let next = mesh.positions.len() as u32;
                let elements = || parts.map(|part| part.map_or(0, |part| part.element(face, corner, point)));
                if is_of_points {
                    let vertex = &mut by_point[point as usize];
                    if *vertex == u32::MAX {
                        *vertex = next;
                        self.push(&mut mesh, point, elements());
                    }
                    vertices.push(*vertex);
                    continue;
                }
                let elements = elements();
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
            let mut rgba = self.colors.map_or([1.0; 4], |colors| colors.get(color, [0.0, 0.0, 0.0, 1.0]));
            if let Some(opacities) = self.opacities {
                [rgba[3]] = opacities.get(opacity, [1.0]);
            }
            mesh.colors.push(rgba);
        }
    }
}
