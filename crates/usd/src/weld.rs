// SPDX-License-Identifier: GPL-3.0-or-later
//! Polygons with values at their corners as triangles with values at their vertices.
//! Corners become one vertex where they have the same point and the same elements. Tests: `tests/meshes.rs`.

use std::collections::HashMap;

use gnurt_scene::Mesh;
use gnurt_scene::io::reader::Cutter;
use gnurt_scene::subdivision::Faces;

use crate::attributes::Attribute;

/// Vertices of a chain at most: longer ones, in a file that is made for it, go on in a table.
const LONGEST: usize = 16;

/// Vertices by their points and elements: a chain for each point, near in memory where faces are neighbours.
struct Chains {
    /// The last link of each point, or `u32::MAX`.
    heads: Vec<u32>,
    links: Vec<Link>,
    others: HashMap<(u32, [u32; 4]), u32>,
}

struct Link {
    elements: [u32; 4],
    number: u32,
    next: u32,
}

impl Chains {
    fn new(points: usize) -> Self {
        Self { heads: vec![u32::MAX; points], links: Vec::new(), others: HashMap::new() }
    }

    /// The number of a vertex; a new one gets `next`.
    fn number(&mut self, point: u32, elements: [u32; 4], next: u32) -> u32 {
        let head = self.heads[point as usize];
        let (mut at, mut length) = (head, 0);
        while let Some(link) = self.links.get(at as usize) {
            if link.elements == elements {
                return link.number;
            }
            (at, length) = (link.next, length + 1);
        }
        if length >= LONGEST || self.links.len() >= u32::MAX as usize {
            return *self.others.entry((point, elements)).or_insert(next);
        }
        self.heads[point as usize] = self.links.len() as u32;
        self.links.push(Link { elements, number: next, next: head });
        next
    }
}

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
        let mut by_elements = Chains::new(if is_of_points { 0 } else { self.points.len() });
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_corner_has_one_number() {
        let (mut chains, mut known) = (Chains::new(5), HashMap::new());
        let mut random = 1_u32;
        for _ in 0..10_000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let part = |shift: u32, count: u32| (random >> shift) % count;
            let (point, elements) = (part(28, 5), [part(20, 9), 0, part(10, 20), 7]);
            let next = known.len() as u32;
            let number = *known.entry((point, elements)).or_insert(next);
            assert_eq!(chains.number(point, elements, next), number, "{point} {elements:?}");
        }
        assert!(!chains.others.is_empty() && chains.links.len() == 5 * LONGEST, "both are used");
    }
}
