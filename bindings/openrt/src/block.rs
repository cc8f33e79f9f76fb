// SPDX-License-Identifier: GPL-3.0-or-later
//! Blocks of vertices between rtBegin and rtEnd, and the fragments that continue each other.
//! Source: OpenGL 1.x for blocks; the fragment rule is original: it lets the paper's Figure 1, which wraps each single
//! vertex in rtBegin and rtEnd, make triangles, and leaves programs in OpenGL's manner alone.
//! A block with fewer vertices than one independent primitive takes is a fragment; its vertices wait for the next
//! fragment of the same mode, object and shader. Any other block with vertices discards what waits.
//! Proof: tests/c/fragments.c; tests/state_machine.rs.

use crate::context::Context;
use crate::current::Transforms;
use crate::enums::Primitive;
use crate::error::{Error, Result};
use crate::geometry::Geometry;

/// A block between rtBegin and rtEnd.
pub struct Block {
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

/// An object that takes geometry: its triangles and the vertices that wait.
#[derive(Default)]
pub struct Assembly {
    /// The triangles so far.
    pub geometry: Geometry,
    waiting: Option<Waiting>,
    /// Whether the program has given a normal since this began.
    pub has_normals: bool,
}

impl Assembly {
    /// The block's primitive number `i` of vertices is complete: its triangles are added.
    #[inline]
    fn complete(&mut self, block: &Block, part: usize, i: u32, values: &[f32]) {
        for triangle in block.mode.completed_by(i).iter() {
            self.geometry.push_triangle(part, triangle.map(|k| block.first as u32 + k), values);
        }
    }

    /// A block has ended that was too short for a primitive: its vertices join those that wait, and make a primitive
    /// where there are enough.
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

impl Context {
    /// Where vertices go: the open object, or the unnamed one of the next frame.
    fn assembly_mut(&mut self) -> &mut Assembly {
        match &mut self.open {
            Some(open) => &mut open.assembly,
            None => &mut self.unnamed,
        }
    }

    /// rtBegin.
    pub fn begin(&mut self, mode: u32) -> Result<()> {
        self.outside_block()?;
        let mode = Primitive::from_code(mode)?;
        let surface = self.bound_surface();
        let geometry = &mut self.assembly_mut().geometry;
        let part = surface.map(|(shader, class)| geometry.part_for(shader, &class));
        let first = part.map_or(0, |part| geometry.part_mut(part).next_vertex());
        let transforms = Transforms::of(&self.stacks);
        self.block = Some(Block { mode, part, first, count: 0, transforms, values: Vec::new() });
        Ok(())
    }

    /// rtVertex*.
    #[inline]
    pub fn vertex(&mut self, position: [f64; 4]) -> Result<()> {
        let block = self.block.as_mut().ok_or(Error::InvalidOperation)?;
        let part = block.part.ok_or(Error::InvalidOperation)?;
        let assembly = match &mut self.open {
            Some(open) => &mut open.assembly,
            None => &mut self.unnamed,
        };
        let i = block.count;
        if block.first + i as usize >= u32::MAX as usize {
            return Err(Error::OutOfMemory);
        }
        let vertex = self.current.vertex(&block.transforms, position, assembly.has_normals);
        assembly.geometry.part_mut(part).push_vertex(vertex, &self.bound.vertex);
        assembly.geometry.vertices_given += 1;
        block.count += 1;
        match block.mode.independent_size() {
            Some(size) if i + 1 < size && !self.bound.triangle.is_empty() => {
                block.values.extend_from_slice(&self.bound.triangle);
            }
            Some(size) if i + 1 == size => assembly.waiting = None,
            _ => {}
        }
        assembly.complete(block, part, i, &self.bound.triangle);
        Ok(())
    }

    /// rtEnd.
    pub fn end(&mut self) -> Result<()> {
        let block = self.block.take().ok_or(Error::InvalidOperation)?;
        if let Some(part) = block.part.filter(|_| block.count > 0) {
            let assembly = self.assembly_mut();
            match block.mode.independent_size() {
                Some(size) if block.count < size => assembly.join(&block, part, size),
                _ => assembly.waiting = None,
            }
        }
        Ok(())
    }
}
