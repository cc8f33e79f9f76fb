// SPDX-License-Identifier: GPL-3.0-or-later
//! The geometry of an object while it is defined: vertices and triangles, one part per shader.
//! Source: original. Space: object; the matrix of each vertex has been applied already.
//! Invariant: a channel (normals, colours, ...) is empty as long as all its values are the default ones, else full.
//! Proof: `tests`; tests/c/fragments.c, tests/c/primitives.c.

use std::sync::Arc;

use gnurt::scene::{Attribute, Mesh, Rate};
use gnurt::shading::classes::NORMALS_GIVEN;

use crate::class::Code;
use crate::shader_class::{Block, LoadedClass};

/// A vertex as it is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Position.
    pub position: [f32; 3],
    /// Unit normal; zero = the program gave none.
    pub normal: [f32; 3],
    /// Texture coordinates.
    pub texcoord: [f32; 2],
    /// Red, green, blue, alpha.
    pub color: [f32; 4],
}

/// Name of the mesh attribute, two floats per triangle, that says where it is among those of its object: the low and the
/// high 16 bits.
pub const TRIANGLE_NUMBER: &str = "openrt.triangle_number";

const NO_NORMAL: [f32; 3] = [0.0; 3];
const WHITE: [f32; 4] = [1.0; 4];

/// The triangles of an object that have one shader.
pub struct Part {
    /// The shader's id.
    pub shader: u32,
    class: Arc<LoadedClass>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Whether some of the normals are none.
    lacks_normals: bool,
    texcoords: Vec<[f32; 2]>,
    colors: Vec<[f32; 4]>,
    /// One block per vertex, if the class has parameters per vertex.
    vertex_values: Vec<f32>,
    indices: Vec<[u32; 3]>,
    /// One block per triangle, if the class has parameters per triangle.
    triangle_values: Vec<f32>,
    /// Number of each triangle in the object, if a plugin may ask for it.
    numbers: Vec<u32>,
}

/// The mesh of a finished part.
pub struct ShaderMesh {
    /// The shader's id.
    pub shader: u32,
    /// Its triangles; the material is not set.
    pub mesh: Mesh,
}

/// All parts of an object.
#[derive(Default)]
pub struct Geometry {
    parts: Vec<Part>,
    /// Triangles of all parts.
    triangles: u32,
    /// Vertices that the program gave, whether they made triangles or not.
    pub vertices_given: usize,
}

impl Geometry {
    /// Number of the part for `shader`, which is made if it is new.
    pub fn part_for(&mut self, shader: u32, class: &Arc<LoadedClass>) -> usize {
        let known = self.parts.iter().position(|part| part.shader == shader);
        known.unwrap_or_else(|| {
            self.parts.push(Part::new(shader, class.clone()));
            self.parts.len() - 1
        })
    }

    /// Adds a triangle to a part, with the block of its per-triangle parameters. One without area, or with a coordinate
    /// that is not finite, is left out.
    pub fn push_triangle(&mut self, part: usize, vertices: [u32; 3], values: &[f32]) {
        if self.parts[part].push_triangle(vertices, values, self.triangles) {
            self.triangles += 1;
        }
    }

    /// A part, to be added to.
    pub fn part_mut(&mut self, part: usize) -> &mut Part {
        &mut self.parts[part]
    }

    /// Triangles so far.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.indices.len()).sum()
    }

    /// Shaders that have been bound at a block.
    pub fn shaders(&self) -> impl Iterator<Item = u32> + '_ {
        self.parts.iter().map(|part| part.shader)
    }

    /// Whether there is no triangle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.triangle_count() == 0
    }

    /// The meshes, one per shader that has triangles.
    #[must_use]
    pub fn finish(self) -> Vec<ShaderMesh> {
        let with_triangles = self.parts.into_iter().filter(|part| !part.indices.is_empty());
        with_triangles.map(Part::finish).collect()
    }
}

impl Part {
    fn new(shader: u32, class: Arc<LoadedClass>) -> Self {
        Self {
            shader,
            class,
            positions: Vec::new(),
            normals: Vec::new(),
            lacks_normals: false,
            texcoords: Vec::new(),
            colors: Vec::new(),
            vertex_values: Vec::new(),
            indices: Vec::new(),
            triangle_values: Vec::new(),
            numbers: Vec::new(),
        }
    }

    /// The number that the next vertex gets.
    #[must_use]
    pub fn next_vertex(&self) -> usize {
        self.positions.len()
    }

    /// Adds a vertex with the block of its per-vertex parameters.
    #[inline]
    pub fn push_vertex(&mut self, vertex: Vertex, values: &[f32]) {
        let n = self.positions.len();
        self.positions.push(vertex.position);
        push_unless_default(&mut self.normals, n, vertex.normal, NO_NORMAL);
        self.lacks_normals |= vertex.normal == NO_NORMAL;
        push_unless_default(&mut self.texcoords, n, vertex.texcoord, [0.0; 2]);
        push_unless_default(&mut self.colors, n, vertex.color, WHITE);
        if !values.is_empty() {
            self.vertex_values.extend_from_slice(values);
        }
    }

    /// Adds a triangle with the block of its per-triangle parameters. One without area, or with a coordinate that is
    /// not finite, is left out.
    fn push_triangle(&mut self, vertices: [u32; 3], values: &[f32], number: u32) -> bool {
        let is_kept = has_area(vertices.map(|i| self.positions[i as usize]));
        if is_kept {
            self.indices.push(vertices);
            if !values.is_empty() {
                self.triangle_values.extend_from_slice(values);
            }
            if matches!(self.class.code, Code::Plugin(_)) {
                self.numbers.push(number);
            }
        }
        is_kept
    }

    fn finish(mut self) -> ShaderMesh {
        self.drop_unused_vertices();
        let mut attributes = attributes_of(&self.class, &self.class.vertex, Rate::Vertex, self.vertex_values);
        attributes.extend(attributes_of(
            &self.class,
            &self.class.triangle,
            Rate::Triangle,
            self.triangle_values,
        ));
        // The only part of an object has its triangles in their order.
        if self.numbers.iter().zip(0..).any(|(&number, i)| number != i) {
            // Two halves: floats hold integers up to 2^24.
            let data = self.numbers.iter().flat_map(|&n| [(n & 0xFFFF) as f32, (n >> 16) as f32]).collect();
            let name = TRIANGLE_NUMBER.to_owned();
            attributes.push(Attribute { name, rate: Rate::Triangle, components: 2, data });
        }
        if !self.normals.is_empty() {
            let normals = &self.normals;
            let given = |triangle: &[u32; 3]| triangle.iter().all(|&i| normals[i as usize] != NO_NORMAL);
            let data = if self.lacks_normals {
                self.indices.iter().map(|triangle| f32::from(u8::from(given(triangle)))).collect()
            } else {
                vec![1.0; self.indices.len()]
            };
            let name = NORMALS_GIVEN.to_owned();
            attributes.push(Attribute { name, rate: Rate::Triangle, components: 1, data });
        }
        let mesh = Mesh {
            name: String::new(),
            positions: self.positions,
            normals: self.normals,
            texcoords: self.texcoords,
            colors: self.colors,
            indices: self.indices,
            material: Default::default(),
            attributes,
        };
        ShaderMesh { shader: self.shader, mesh }
    }

    /// Removes vertices that no triangle uses, and keeps the order of the others.
    fn drop_unused_vertices(&mut self) {
        let n = self.positions.len();
        // Each vertex for a triangle of its own: the commonest case.
        let are_own = |(i, triangle): (usize, &[u32; 3])| *triangle == [0, 1, 2].map(|k| 3 * i as u32 + k);
        if n == 3 * self.indices.len() && self.indices.iter().enumerate().all(are_own) {
            return;
        }
        let mut used = vec![false; n];
        self.indices.iter().flatten().for_each(|&i| used[i as usize] = true);
        if used.iter().all(|&is_used| is_used) {
            return;
        }
        let mut next = 0;
        let renumbered: Vec<u32> = used
            .iter()
            .map(|&is_used| {
                next += u32::from(is_used);
                next.saturating_sub(1)
            })
            .collect();
        self.indices.iter_mut().flatten().for_each(|i| *i = renumbered[*i as usize]);
        keep_used(&mut self.positions, &used, 1);
        keep_used(&mut self.normals, &used, 1);
        keep_used(&mut self.texcoords, &used, 1);
        keep_used(&mut self.colors, &used, 1);
        keep_used(&mut self.vertex_values, &used, self.class.vertex.defaults.len());
    }
}

/// Adds value number `n` to a channel that stays empty while all values are the default.
#[inline]
fn push_unless_default<T: Copy + PartialEq>(channel: &mut Vec<T>, n: usize, value: T, default: T) {
    if channel.is_empty() {
        if value == default {
            return;
        }
        channel.resize(n, default);
    }
    channel.push(value);
}

/// Keeps the groups of `size` values whose flag is set; an empty channel stays empty.
fn keep_used<T>(channel: &mut Vec<T>, used: &[bool], size: usize) {
    let mut i = 0;
    channel.retain(|_| {
        i += 1;
        used[(i - 1) / size.max(1)]
    });
}

/// Splits the blocks of one rate into one attribute per parameter.
fn attributes_of(class: &LoadedClass, block: &Block, rate: Rate, values: Vec<f32>) -> Vec<Attribute> {
    let size = block.defaults.len();
    let gather = |offset: usize, components: usize| {
        let blocks = values.chunks_exact(size.max(1));
        blocks.flat_map(|b| b[offset..offset + components].iter().copied()).collect()
    };
    let attribute = |slot: &crate::shader_class::Slot| Attribute {
        name: class.parameters[slot.parameter].name.clone(),
        rate,
        components: slot.components as u32,
        data: gather(slot.offset, slot.components),
    };
    block.slots.iter().map(attribute).collect()
}

/// Whether a triangle has an area that is a positive finite number.
#[inline]
fn has_area([a, b, c]: [[f32; 3]; 3]) -> bool {
    let edge = |p: [f32; 3], k: usize| f64::from(p[k]) - f64::from(a[k]);
    // NaN and infinite coordinates make a component NaN or infinite, and the sum with it.
    let component = |i: usize, j: usize| edge(b, i) * edge(c, j) - edge(b, j) * edge(c, i);
    let normal = [component(1, 2), component(2, 0), component(0, 1)];
    let twice_area_squared = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    twice_area_squared > 0.0 && [a, b, c].as_flattened().iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_triangles_with_area_are_kept() {
        let corners = |last| [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], last];
        assert!(has_area(corners([0.0, 1.0, 0.0])), "half a unit");
        assert!(has_area([[0.0; 3], [1e-20, 0.0, 0.0], [0.0, 1e-20, 0.0]]), "tiny ones stay");
        assert!(!has_area(corners([2.0, 0.0, 0.0])), "three points on a line");
        assert!(!has_area(corners([f32::NAN, 1.0, 0.0])), "no number");
        assert!(!has_area(corners([f32::INFINITY, 1.0, 0.0])), "no place");
    }

    #[test]
    fn channels_fill_when_they_must() {
        let mut channel = Vec::new();
        push_unless_default(&mut channel, 0, 1, 1);
        push_unless_default(&mut channel, 1, 1, 1);
        assert!(channel.is_empty(), "defaults take no memory");
        push_unless_default(&mut channel, 2, 5, 1);
        push_unless_default(&mut channel, 3, 1, 1);
        assert_eq!(channel, [1, 1, 5, 1], "then all are there");
        keep_used(&mut channel, &[true, false, true, true], 1);
        assert_eq!(channel, [1, 5, 1], "and unused ones go");
    }
}
