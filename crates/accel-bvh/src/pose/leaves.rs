// SPDX-License-Identifier: GPL-3.0-or-later
//! The leaf blocks of a pose: shared triangles, over its own corners. Space: object.
//! Tests: `tests/poses.rs` of `gnurt-accel`.

use std::sync::Arc;

use gnurt_accel_core::blocks::TriangleBlock;
use gnurt_accel_core::filter_region::filter_triangles;
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::RegionFilter;
use gnurt_simd::{Simd, f32x4, prelude::*};

use super::structure::{Structure, VertexBlock};
use crate::gather::{Eight, store};
use crate::node::WIDTH;
use crate::pools::{Filling, Pools};

/// Blocks by their numbers.
#[derive(Clone, Debug)]
pub(crate) struct PosedLeaves {
    pub(crate) structure: Arc<Structure>,
    /// Three floats for each corner, and one more that is read with the last.
    pub(crate) corners: Vec<f32>,
}

impl PartialEq for PosedLeaves {
    fn eq(&self, other: &Self) -> bool {
        let bits = |leaves: &Self| leaves.corners.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        self.structure.blocks == other.structure.blocks && bits(self) == bits(other)
    }
}

impl PosedLeaves {
    pub(crate) fn blocks(&self) -> &[VertexBlock] {
        &self.structure.blocks
    }

    /// The corners of a block in lanes.
    #[inline(always)]
    pub(crate) fn gather<S: Simd>(&self, simd: S, block: &VertexBlock) -> Eight<S> {
        let mut corners = [[f32x4::splat(simd, 0.0); WIDTH]; 3];
        for (corners, vertices) in corners.iter_mut().zip(&block.vertices) {
            for (corner, &vertex) in corners.iter_mut().zip(vertices) {
                let at = 3 * vertex as usize;
                *corner = f32x4::from_slice(simd, &self.corners[at..at + 4]);
            }
        }
        Eight(corners)
    }

    /// Block `index` as tests take it. Cold, so that walks of other trees keep their registers.
    #[cold]
    #[inline(never)]
    pub(crate) fn expand<S: Simd>(&self, simd: S, index: usize, into: &mut TriangleBlock) {
        simd.vectorize(
            #[inline(always)]
            || {
                let block = &self.structure.blocks[index];
                store(&self.gather(simd, block).rows(), into);
                into.numbers = block.numbers;
            },
        );
    }

    fn corner(&self, vertex: u32) -> [f32; 3] {
        let at = 3 * vertex as usize;
        [self.corners[at], self.corners[at + 1], self.corners[at + 2]]
    }

    /// The corners of one triangle of a block.
    pub(crate) fn triangle(&self, block: usize, lane: usize) -> [[f32; 3]; 3] {
        let block = &self.structure.blocks[block];
        [0, 1, 2].map(|corner: usize| self.corner(block.vertices[corner][lane]))
    }

    /// Shows those triangles of a block that may meet it.
    pub(crate) fn filter_region(
        &self,
        index: usize,
        region_filter: &RegionFilter,
        visit: &mut dyn FnMut(u32, Primitive),
    ) {
        let mut corners = [[[0.0; WIDTH]; 3]; 3];
        for lane in 0..WIDTH {
            for (rows, corner) in corners.iter_mut().zip(self.triangle(index, lane)) {
                (rows[0][lane], rows[1][lane], rows[2][lane]) = (corner[0], corner[1], corner[2]);
            }
        }
        filter_triangles(&corners, &self.structure.blocks[index].numbers, region_filter, visit);
    }

    /// The same blocks as a compact tree by itself has them.
    pub(crate) fn to_pools(&self) -> Pools {
        let mut filling = Filling::new(self.blocks().len());
        for block in self.blocks() {
            let corners = |number: u32| {
                let lane = block.numbers.iter().position(|&other| other == number).unwrap_or(0);
                [0, 1, 2].map(|corner: usize| self.corner(block.vertices[corner][lane]))
            };
            filling.push(&block.numbers, corners);
        }
        filling.finish()
    }

    /// Without shared memory.
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.corners[..])
    }
}
