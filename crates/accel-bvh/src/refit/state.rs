// SPDX-License-Identifier: GPL-3.0-or-later
//! What a tree that is refitted knows besides its nodes and blocks. Source: original.

use gnurt_accel_core::Aabb;

/// What a tree that moves knows besides.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moving {
    /// Triangles, good and bad.
    pub(crate) count: u64,
    /// Triangles that could not be traced when the tree was built, ascending.
    pub(crate) strays: Vec<u32>,
    /// Triangles that cannot for the time being, and their blocks.
    pub(crate) absent: Vec<(u32, u32)>,
    /// Boxes of leaf blocks: room.
    pub(crate) boxes: Vec<Aabb>,
    /// What each subtree cost when it was built, and costs now; see [`Tree::refit`](crate::tree::Tree::refit).
    pub(crate) built: Vec<f32>,
    pub(crate) costs: Vec<f32>,
}

impl Moving {
    /// Of what it keeps.
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.boxes[..]) + size_of_val(&self.built[..]) + size_of_val(&self.costs[..])
    }
}
