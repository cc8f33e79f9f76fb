// SPDX-License-Identifier: GPL-3.0-or-later
//! The common part of all poses of an object. Space: none; it holds no coordinates.
//! Invariant: corners are numbered in the order of their first use by blocks, so that a block's corners are
//! adjacent.
//! Tests: `tests/poses.rs` of `gnurt-accel`.

use std::sync::Arc;

use gnurt_accel_core::TreeStats;
use gnurt_accel_core::surfaces::Surfaces;

use crate::compact::Children;
use crate::node::WIDTH;

/// The triangles of a leaf block, for all poses.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct VertexBlock {
    /// Corners by their numbers in a pose; spare slots repeat the first triangle.
    pub(crate) vertices: [[u32; WIDTH]; 3],
    /// Numbers in the object.
    pub(crate) numbers: [u32; WIDTH],
}

/// Shared by all poses of an object.
#[derive(Debug)]
pub(crate) struct Structure {
    pub(crate) children: Arc<Vec<Children>>,
    pub(crate) blocks: Vec<VertexBlock>,
    /// The vertex of a pose's corner: geometry, and index among its positions.
    pub(crate) sources: Vec<[u32; 2]>,
    /// Vertices of all triangles and quads, geometry by geometry.
    pub(super) topology: Vec<Vec<u32>>,
    /// Triangles that are in no block, ascending: untraceable ones.
    pub(crate) strays: Vec<u32>,
    /// Triangles, good and bad.
    pub(crate) count: u64,
    /// The expected cost of a ray below the root at the build, in steps and blocks.
    pub(crate) built: f32,
    /// Of the tree that was built.
    pub(crate) stats: TreeStats,
}

impl Structure {
    /// Whether geometry consists of the same triangles.
    pub(crate) fn has_topology_of(&self, surfaces: &Surfaces) -> bool {
        self.topology.len() + 1 == surfaces.starts.len()
            && self.topology.iter().enumerate().all(|(i, known)| surfaces.vertices(i) == &known[..])
    }

    /// Bytes that it takes.
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.children[..])
            + size_of_val(&self.blocks[..])
            + size_of_val(&self.sources[..])
            + size_of_val(&self.strays[..])
            + self.topology.iter().map(|vertices| size_of_val(&vertices[..])).sum::<usize>()
    }
}
