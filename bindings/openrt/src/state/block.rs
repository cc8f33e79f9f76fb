// SPDX-License-Identifier: GPL-3.0-or-later
//! Blocks of vertices between rtBegin and rtEnd, and the fragments that continue each other.
//! Source: OpenGL 1.x for blocks; the fragment rule is original: it lets the paper's Figure 1, which wraps each single
//! vertex in rtBegin and rtEnd, make triangles, and leaves programs in OpenGL's manner alone.
//! A block with fewer vertices than one independent primitive takes is a fragment; its vertices wait for the next
//! fragment of the same mode, object and shader. Any other block with vertices discards the fragment.
//! Tests: tests/c/fragments.c; `random::state_machine`.

use std::sync::Arc;

use super::current::{Current, Transforms};
use super::enums::Primitive;
use super::error::{Error, Result};
use super::geometry::Geometry;
use super::shader_class::LoadedClass;

/// A block between rtBegin and rtEnd.
pub(crate) struct Block {
    mode: Primitive,
    /// Where its vertices go: a part of the object's geometry. None if no surface shader is bound.
    part: Option<usize>,
    /// Number of its first vertex in the part.
    first: usize,
    /// How many vertices it has.
    count: u32,
    /// The matrices of its vertices: they cannot change within a block.
    transforms: Transforms,
    /// Values per triangle, current at each vertex while this may still be a fragment.
    values: Vec<f32>,
}

/// Vertices of fragments that wait for more.
#[derive(Debug)]
struct Waiting {
    mode: Primitive,
    part: usize,
    /// Their numbers in the part.
    vertices: Vec<u32>,
    /// Values per triangle, current at each of them.
    values: Vec<f32>,
}

/// Values that shaders vary by, current at a vertex.
#[derive(Default)]
pub(crate) struct CurrentValues {
    /// Values of the next triangle.
    pub(crate) triangle: Vec<f32>,
    /// Values of the next vertex.
    pub(crate) vertex: Vec<f32>,
}

/// An object that takes geometry: its triangles and the vertices that wait.
#[derive(Default)]
pub(crate) struct Assembly {
    /// The triangles so far.
    pub(crate) geometry: Geometry,
    waiting: Option<Waiting>,
    /// Whether the program has given a normal since this began.
    pub(crate) has_normals: bool,
}

impl Assembly {
    /// A block begins, with the bound surface shader and its class if there is one.
    pub(crate) fn begin(
        &mut self,
        mode: Primitive,
        surface: Option<(u32, Arc<LoadedClass>)>,
        transforms: Transforms,
    ) -> Block {
        let part = surface.map(|(shader, class)| self.geometry.part_for(shader, &class));
        let first = part.map_or(0, |part| self.geometry.part_mut(part).next_vertex());
        Block { mode, part, first, count: 0, transforms, values: Vec::new() }
    }

    /// Adds a vertex to the block, with any primitives that it completes.
    #[inline]
    pub(crate) fn vertex(
        &mut self,
        block: &mut Block,
        current: &Current,
        position: [f64; 4],
        values: &CurrentValues,
    ) -> Result<()> {
        let part = block.part.ok_or(Error::InvalidOperation)?;
        let i = block.count;
        if block.first + i as usize >= u32::MAX as usize {
            return Err(Error::OutOfMemory);
        }
        let vertex = current.vertex(&block.transforms, position, self.has_normals);
        self.geometry.part_mut(part).push_vertex(vertex, &values.vertex)?;
        self.geometry.vertices_given += 1;
        block.count += 1;
        match block.mode.independent_size() {
            Some(size) if i + 1 < size && !values.triangle.is_empty() => {
                block.values.extend_from_slice(&values.triangle);
            }
            Some(size) if i + 1 == size => self.waiting = None,
            _ => {}
        }
        self.complete(block, part, i, &values.triangle);
        Ok(())
    }

    /// The block ends.
    pub(crate) fn end(&mut self, block: &Block) {
        if let Some(part) = block.part.filter(|_| block.count > 0) {
            match block.mode.independent_size() {
                Some(size) if block.count < size => self.join(block, part, size),
                _ => self.waiting = None,
            }
        }
    }

    /// The block's primitive number `i` of vertices is complete: its triangles are added.
    #[inline]
    fn complete(&mut self, block: &Block, part: usize, i: u32, values: &[f32]) {
        for triangle in block.mode.completed_by(i).iter() {
            self.geometry.push_triangle(part, triangle.map(|k| block.first as u32 + k), values);
        }
    }

    /// A block has ended that was too short for a primitive: its vertices join the waiting ones, and make a
    /// primitive where there are enough.
    fn join(&mut self, block: &Block, part: usize, size: u32) {
        let continues = self.waiting.as_ref().is_some_and(|w| w.mode == block.mode && w.part == part);
        if !continues {
            self.waiting = None;
        }
        let start = || Waiting { mode: block.mode, part, vertices: Vec::new(), values: Vec::new() };
        let waiting = self.waiting.get_or_insert_with(start);
        waiting.vertices.extend((0..block.count).map(|k| block.first as u32 + k));
        waiting.values.extend_from_slice(&block.values);
        let stride = waiting.values.len() / waiting.vertices.len();
        // Fewer than `size` waited and fewer than `size` came: at most one primitive is complete.
        let size_waiting = size as usize;
        if waiting.vertices.len() >= size_waiting {
            let vertices: Vec<u32> = waiting.vertices.drain(..size_waiting).collect();
            let values: Vec<f32> = waiting.values.drain(..size_waiting * stride).collect();
            for triangle in block.mode.completed_by(size - 1).iter() {
                let at_last_vertex = &values[(size_waiting - 1) * stride..];
                self.geometry.push_triangle(part, triangle.map(|k| vertices[k as usize]), at_last_vertex);
            }
        }
    }
}
