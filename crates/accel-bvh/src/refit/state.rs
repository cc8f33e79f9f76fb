// SPDX-License-Identifier: GPL-3.0-or-later
//! State of a refitted tree besides its nodes and blocks.

use gnurt_accel_core::Aabb;

/// State of a moving tree besides its nodes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moving {
    /// Triangles, good and bad.
    pub(crate) count: u64,
    /// Triangles that could not be traced when the tree was built, ascending.
    pub(crate) strays: Vec<u32>,
    /// Blocks, and a triangle in each that cannot for the time being. One in several blocks occurs for each.
    pub(crate) absent: Vec<(u32, u32)>,
    /// Memory for boxes of leaf blocks.
    pub(crate) boxes: Vec<Aabb>,
    /// The cost of each subtree at the build, and now; see [`Tree::refit`](crate::tree::Tree::refit).
    pub(crate) built: Vec<f32>,
    pub(crate) costs: Vec<f32>,
}

impl Moving {
    /// The triangles that are absent, each once, ascending.
    pub(crate) fn missing(&self) -> Vec<u32> {
        let mut numbers: Vec<u32> = self.absent.iter().map(|&(_, number)| number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }

    /// Of its state.
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.boxes[..]) + size_of_val(&self.built[..]) + size_of_val(&self.costs[..])
    }
}
