// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangles that no ray can hit, and vertices that no triangle uses. Space: object.
//! Tests: `tests`; `io::clean::tests`.

use crate::mesh::{Mesh, Rate};

/// Whether a triangle has an area above zero, in double precision. One with a coordinate that is not finite has none.
#[inline]
#[must_use]
pub fn has_area([a, b, c]: [[f32; 3]; 3]) -> bool {
    let edge = |p: [f32; 3], k: usize| f64::from(p[k]) - f64::from(a[k]);
    let component = |i: usize, j: usize| edge(b, i) * edge(c, j) - edge(b, j) * edge(c, i);
    // Products of two single-precision numbers neither underflow nor overflow. Coordinates that are not finite make the
    // sum infinite or NaN, which is not above zero.
    let size = component(1, 2).abs() + component(2, 0).abs() + component(0, 1).abs();
    size > 0.0 && size < f64::INFINITY
}

impl Mesh {
    /// Removes the vertices that no triangle uses, and keeps the order of the others.
    pub fn drop_unused_vertices(&mut self) {
        if !self.has_triangles() {
            return;
        }
        let count = self.positions.len();
        // A vertex for each corner of each triangle is a common case with a quick test.
        let are_own = |(i, triangle): (usize, &[u32; 3])| *triangle == [0, 1, 2].map(|k| 3 * i as u32 + k);
        if count == 3 * self.indices.len() && self.indices.iter().enumerate().all(are_own) {
            return;
        }
        let mut used = vec![false; count];
        self.indices.iter().flatten().for_each(|&i| used[i as usize] = true);
        if used.iter().all(|&is_used| is_used) {
            return;
        }
        let mut next = 0;
        let number = |&is_used: &bool| {
            next += u32::from(is_used);
            next.saturating_sub(1)
        };
        let numbers: Vec<u32> = used.iter().map(number).collect();
        self.indices.iter_mut().flatten().for_each(|i| *i = numbers[*i as usize]);
        keep_used(&mut self.positions, &used, 1);
        keep_used(&mut self.normals, &used, 1);
        keep_used(&mut self.texcoords, &used, 1);
        keep_used(&mut self.tangents, &used, 1);
        keep_used(&mut self.colors, &used, 1);
        for attribute in self.attributes.iter_mut().filter(|attribute| attribute.rate == Rate::Vertex) {
            keep_used(&mut attribute.data, &used, attribute.components as usize);
        }
    }
}

/// Keeps the groups of `size` values whose flag is set; an empty channel stays empty.
fn keep_used<T>(channel: &mut Vec<T>, used: &[bool], size: usize) {
    let mut i = 0;
    channel.retain(|_| {
        i += 1;
        used.get((i - 1) / size.max(1)).is_some_and(|&is_used| is_used)
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Attribute;

    #[test]
    fn only_triangles_with_area_can_be_hit() {
        let corners = |last| [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], last];
        assert!(has_area(corners([0.0, 1.0, 0.0])), "half a unit");
        assert!(has_area([[0.0; 3], [1e-20, 0.0, 0.0], [0.0, 1e-20, 0.0]]), "tiny ones stay");
        assert!(has_area([[0.0; 3], [1e-44, 0.0, 0.0], [0.0, 1e-44, 0.0]]), "the tiniest too");
        assert!(!has_area(corners([2.0, 0.0, 0.0])), "three points on a line");
        assert!(!has_area(corners([f32::NAN, 1.0, 0.0])), "no number");
        assert!(!has_area(corners([f32::INFINITY, 1.0, 0.0])), "no place");
    }

    #[test]
    fn all_that_vertices_have_goes_with_them() {
        let mut mesh = Mesh {
            positions: (0..5).map(|i| [i as f32; 3]).collect(),
            texcoords: (0..5).map(|i| [i as f32; 2]).collect(),
            indices: vec![[4, 0, 2]],
            attributes: vec![
                Attribute {
                    name: "v".into(),
                    rate: Rate::Vertex,
                    components: 2,
                    data: (0..10).map(|i| i as f32).collect(),
                },
                Attribute { name: "t".into(), rate: Rate::Triangle, components: 1, data: vec![7.0] },
            ],
            ..Mesh::default()
        };
        mesh.drop_unused_vertices();
        assert_eq!(mesh.positions, [[0.0; 3], [2.0; 3], [4.0; 3]], "in their order");
        assert_eq!(mesh.texcoords, [[0.0; 2], [2.0; 2], [4.0; 2]], "theirs");
        assert_eq!(mesh.indices, [[2, 0, 1]], "renumbered");
        assert_eq!(mesh.attributes[0].data, [0.0, 1.0, 4.0, 5.0, 8.0, 9.0], "two numbers of each vertex");
        assert_eq!(mesh.attributes[1].data, [7.0], "those of triangles stay");
        assert!(mesh.normals.is_empty() && mesh.colors.is_empty(), "what was empty stays so");
    }
}
