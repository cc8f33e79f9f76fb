// SPDX-License-Identifier: GPL-3.0-or-later
//! The geometry of an object while it is defined: vertices and triangles, one part per shader.
//! Space: object; the matrix of each vertex has been applied already.
//! Invariant: a channel (normals, colours, ...) is empty as long as all its values are the default ones, else full.
//! Tests: `tests`; tests/c/fragments.c, tests/c/primitives.c.

use std::collections::{BTreeMap, TryReserveError};
use std::sync::Arc;

use gnurt::scene::{Attribute, Mesh, Rate, TEXCOORD_RQ, has_area};
use gnurt::shading::classes::NORMALS_GIVEN;
use gnurt_plugins::host::TRIANGLE_NUMBER;

use super::class::ClassCode;
use super::error::{Error, Result};
use super::shader_class::{Layout, LoadedClass, Slot};

/// A vertex as it is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vertex {
    /// Position.
    pub(crate) position: [f32; 3],
    /// Unit normal; zero = the program gave none.
    pub(crate) normal: [f32; 3],
    /// Texture coordinates s, t, r, q: not divided yet.
    pub(crate) texcoord: [f32; 4],
    /// Red, green, blue, alpha.
    pub(crate) color: [f32; 4],
}

const NO_NORMAL: [f32; 3] = [0.0; 3];
const WHITE: [f32; 4] = [1.0; 4];
/// Triangles that one vertex completes at most.
const MOST_COMPLETED: usize = 2;
const NO_THIRD: [f32; 2] = [0.0, 1.0];

/// The triangles of an object that have one shader.
pub(crate) struct Part {
    /// The shader's id.
    pub(crate) shader: u32,
    class: Arc<LoadedClass>,
    /// Vertices for which all non-empty channels have memory.
    capacity: usize,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Whether some of the normals are none.
    lacks_normals: bool,
    /// Not divided yet.
    texcoords: Vec<[f32; 2]>,
    /// Third coordinates and divisors.
    texcoords_rq: Vec<[f32; 2]>,
    colors: Vec<[f32; 4]>,
    /// One block per vertex, if the class has parameters per vertex.
    vertex_values: Vec<f32>,
    indices: Vec<[u32; 3]>,
    /// One block per triangle, if the class has parameters per triangle.
    triangle_values: Vec<f32>,
    /// Number of each triangle in the object, if a plugin may query it.
    numbers: Vec<u32>,
}

/// The mesh of a finished part.
pub(crate) struct ShaderMesh {
    /// The shader's id.
    pub(crate) shader: u32,
    /// Its triangles; the material is not set.
    pub(crate) mesh: Mesh,
}

/// All parts of an object.
#[derive(Default)]
pub(crate) struct Geometry {
    parts: Vec<Part>,
    /// The number of each shader's part.
    part_of: BTreeMap<u32, usize>,
    /// Triangles of all parts.
    triangles: u32,
    /// Vertices that the program gave, whether they made triangles or not.
    pub(crate) vertices_given: usize,
}

impl Geometry {
    /// Number of the part for `shader`, which is made if it is new.
    pub(crate) fn part_for(&mut self, shader: u32, class: &Arc<LoadedClass>) -> usize {
        *self.part_of.entry(shader).or_insert_with(|| {
            self.parts.push(Part::new(shader, class.clone()));
            self.parts.len() - 1
        })
    }

    /// Adds a triangle to a part, with the block of its per-triangle parameters. One without area, or with a coordinate
    /// that is not finite, is left out.
    pub(crate) fn push_triangle(&mut self, part: usize, vertices: [u32; 3], values: &[f32]) {
        if self.parts[part].push_triangle(vertices, values, self.triangles) {
            self.triangles += 1;
        }
    }

    /// A part, to be added to.
    pub(crate) fn part_mut(&mut self, part: usize) -> &mut Part {
        &mut self.parts[part]
    }

    /// Triangles so far.
    #[must_use]
    pub(crate) fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.indices.len()).sum()
    }

    /// Shaders that have been bound at a block.
    pub(crate) fn shaders(&self) -> impl Iterator<Item = u32> + '_ {
        self.parts.iter().map(|part| part.shader)
    }

    /// Whether there is no triangle.
    #[must_use]
    pub(crate) fn is_empty(&self) -> bool {
        self.triangle_count() == 0
    }

    /// The meshes, one per shader that has triangles.
    #[must_use]
    pub(crate) fn finish(self) -> Vec<ShaderMesh> {
        let with_triangles = self.parts.into_iter().filter(|part| !part.indices.is_empty());
        with_triangles.map(Part::finish).collect()
    }
}

impl Part {
    fn new(shader: u32, class: Arc<LoadedClass>) -> Self {
        Self {
            shader,
            class,
            capacity: 0,
            positions: Vec::new(),
            normals: Vec::new(),
            lacks_normals: false,
            texcoords: Vec::new(),
            texcoords_rq: Vec::new(),
            colors: Vec::new(),
            vertex_values: Vec::new(),
            indices: Vec::new(),
            triangle_values: Vec::new(),
            numbers: Vec::new(),
        }
    }

    /// The number that the next vertex gets.
    #[must_use]
    pub(crate) fn next_vertex(&self) -> usize {
        self.positions.len()
    }

    /// Adds a vertex with the block of its per-vertex parameters. Fails where memory is short: the library
    /// sets no limit to a program's data.
    #[inline]
    pub(crate) fn push_vertex(&mut self, vertex: Vertex, values: &[f32]) -> Result<()> {
        let n = self.positions.len();
        if n == self.capacity {
            self.make_room()?;
        }
        let capacity = self.capacity;
        self.positions.push(vertex.position);
        let [s, t, r, q] = vertex.texcoord;
        let has_capacity = push_unless_default(&mut self.normals, n, capacity, vertex.normal, NO_NORMAL)
            && push_unless_default(&mut self.texcoords, n, capacity, [s, t], [0.0; 2])
            && push_unless_default(&mut self.texcoords_rq, n, capacity, [r, q], NO_THIRD)
            && push_unless_default(&mut self.colors, n, capacity, vertex.color, WHITE);
        if !has_capacity {
            self.positions.truncate(n);
            self.normals.truncate(n);
            self.texcoords.truncate(n);
            self.texcoords_rq.truncate(n);
            self.colors.truncate(n);
            return Err(Error::OutOfMemory);
        }
        self.lacks_normals |= vertex.normal == NO_NORMAL;
        if !values.is_empty() {
            self.vertex_values.extend_from_slice(values);
        }
        Ok(())
    }

    /// Reserves memory for twice the vertices with their attributes, and for the same number of triangles,
    /// the most that they make.
    #[cold]
    fn make_room(&mut self) -> Result<()> {
        fn grow<T>(channel: &mut Vec<T>, more: usize) -> std::result::Result<(), TryReserveError> {
            if channel.is_empty() { Ok(()) } else { channel.try_reserve(more) }
        }
        let n = self.positions.len();
        let more = n.max(4);
        let triangles = more + MOST_COMPLETED;
        let [vertex_block, triangle_block] =
            [&self.class.vertex, &self.class.triangle].map(|layout| layout.defaults.len());
        let numbers = if matches!(self.class.code, ClassCode::Plugin(_)) { triangles } else { 0 };
        self.positions
            .try_reserve(more)
            .and_then(|()| grow(&mut self.normals, more))
            .and_then(|()| grow(&mut self.texcoords, more))
            .and_then(|()| grow(&mut self.texcoords_rq, more))
            .and_then(|()| grow(&mut self.colors, more))
            .and_then(|()| self.vertex_values.try_reserve(more * vertex_block))
            .and_then(|()| self.indices.try_reserve(triangles))
            .and_then(|()| self.triangle_values.try_reserve(triangles * triangle_block))
            .and_then(|()| self.numbers.try_reserve(numbers))
            .map_err(|_| Error::OutOfMemory)?;
        self.capacity = n + more;
        Ok(())
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
            if matches!(self.class.code, ClassCode::Plugin(_)) {
                self.numbers.push(number);
            }
        }
        is_kept
    }

    /// A divisor common to all vertices is divided out here; others are left to the hit points.
    fn divide_texcoords(&mut self) {
        let Some(&[_, q]) = self.texcoords_rq.first() else { return };
        if self.texcoords_rq.iter().any(|rq| rq[1] != q) {
            return;
        }
        self.texcoords.iter_mut().for_each(|st| *st = st.map(|x| x / q));
        self.texcoords_rq.iter_mut().for_each(|rq| *rq = [rq[0] / q, 1.0]);
        if self.texcoords_rq.iter().all(|rq| *rq == NO_THIRD) {
            self.texcoords_rq = Vec::new();
        }
    }

    fn finish(mut self) -> ShaderMesh {
        self.divide_texcoords();
        let mut attributes = attributes_of(&self.class, &self.class.vertex, Rate::Vertex, self.vertex_values);
        attributes.extend(attributes_of(
            &self.class,
            &self.class.triangle,
            Rate::Triangle,
            self.triangle_values,
        ));
        if !self.texcoords_rq.is_empty() {
            let data = self.texcoords_rq.into_flattened();
            attributes.push(Attribute {
                name: TEXCOORD_RQ.to_owned(),
                rate: Rate::Vertex,
                components: 2,
                data,
            });
        }
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
        let mut mesh = Mesh {
            positions: self.positions,
            normals: self.normals,
            texcoords: self.texcoords,
            colors: self.colors,
            indices: self.indices,
            attributes,
            ..Mesh::default()
        };
        mesh.drop_unused_vertices();
        ShaderMesh { shader: self.shader, mesh }
    }
}

/// Adds value number `n` to a channel that stays empty while all values are the default one; false where
/// memory is short for `capacity` of them, which all other channels have.
#[inline]
fn push_unless_default<T: Copy + PartialEq>(
    channel: &mut Vec<T>,
    n: usize,
    capacity: usize,
    value: T,
    default: T,
) -> bool {
    if channel.is_empty() {
        if value == default {
            return true;
        }
        if channel.try_reserve(capacity).is_err() {
            return false;
        }
        channel.resize(n, default);
    }
    channel.push(value);
    true
}

/// Splits the blocks of one rate into one attribute per parameter.
fn attributes_of(class: &LoadedClass, layout: &Layout, rate: Rate, values: Vec<f32>) -> Vec<Attribute> {
    let size = layout.defaults.len();
    let gather = |offset: usize, components: usize| {
        let blocks = values.chunks_exact(size.max(1));
        blocks.flat_map(|b| b[offset..offset + components].iter().copied()).collect()
    };
    let attribute = |slot: &Slot| Attribute {
        name: class.parameters[slot.parameter].name.clone(),
        rate,
        components: slot.components as u32,
        data: gather(slot.offset, slot.components),
    };
    layout.slots.iter().map(attribute).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_fill_when_they_must() {
        let mut channel = Vec::new();
        push_unless_default(&mut channel, 0, 4, 1, 1);
        push_unless_default(&mut channel, 1, 4, 1, 1);
        assert!(channel.is_empty(), "defaults take no memory");
        push_unless_default(&mut channel, 2, 4, 5, 1);
        push_unless_default(&mut channel, 3, 4, 1, 1);
        assert_eq!(channel, [1, 1, 5, 1], "then all are there");
    }
}
