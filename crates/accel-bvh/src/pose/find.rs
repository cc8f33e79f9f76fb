// SPDX-License-Identifier: GPL-3.0-or-later
//! The common part of a tree's poses, extracted from the tree. Space: none.
//! Tests: `tests/poses.rs` of `gnurt-accel`.

use std::sync::Arc;

use gnurt_accel_core::RefitError;
use gnurt_accel_core::geometry::geometry_of;
use gnurt_accel_core::surfaces::Surfaces;

use super::structure::{Structure, VertexBlock};
use crate::index::BvhIndex;
use crate::node::WIDTH;

/// No corner yet.
const NONE: u32 = u32::MAX;

impl BvhIndex {
    /// The common part of its poses, for geometry with these triangles.
    ///
    /// # Errors
    /// The geometry differs from that of the tree.
    pub(super) fn find_structure(&self, surfaces: &Surfaces) -> Result<Structure, RefitError> {
        let tree = &self.tree;
        let children = match tree.is_compact() {
            true => Arc::clone(&tree.children),
            false => Arc::new(tree.nodes.iter().map(|node| *node.children()).collect()),
        };
        let geometries = 0..surfaces.starts.len() - 1;
        let topology: Vec<Vec<u32>> = geometries.map(|i| surfaces.vertices(i).to_vec()).collect();
        let unknown = |i: usize| vec![NONE; surfaces.positions(i).len()];
        let mut corner_of: Vec<Vec<u32>> = (0..topology.len()).map(unknown).collect();
        let mut is_other = false;
        let mut is_there = vec![false; surfaces.starts.last().map_or(0, |&end| end as usize)];
        let (mut sources, mut blocks) = (Vec::new(), Vec::with_capacity(self.leaves.count()));
        self.numbers(&mut |_, numbers| {
            let mut block = VertexBlock { vertices: [[0; WIDTH]; 3], numbers: *numbers };
            for (lane, &number) in numbers.iter().enumerate() {
                is_there[number as usize] = true;
                let geometry = geometry_of(&surfaces.starts, number);
                let (_, corners) = surfaces.indices(number);
                for (vertices, vertex) in block.vertices.iter_mut().zip(corners) {
                    let Some(corner) = corner_of[geometry].get_mut(vertex as usize) else {
                        is_other = true;
                        continue;
                    };
                    if *corner == NONE {
                        *corner = sources.len() as u32;
                        sources.push([geometry as u32, vertex]);
                    }
                    vertices[lane] = *corner;
                }
            }
            blocks.push(block);
        });
        if is_other {
            return Err(RefitError::OtherGeometry);
        }
        sources.shrink_to_fit();
        let strays = surfaces.numbers().flatten().filter(|&number| !is_there[number as usize]).collect();
        Ok(Structure {
            children,
            blocks,
            sources,
            topology,
            strays,
            count: surfaces.numbers().map(|numbers| numbers.len() as u64).sum(),
            built: tree.costs().first().copied().unwrap_or(0.0),
            stats: self.stats,
        })
    }
}
