// SPDX-License-Identifier: GPL-3.0-or-later
//! The size and shape of a tree, for display.
//! The cost is that of [MB90].

/// The contents of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TreeStats {
    /// Triangles (or instances) that it was built over, without dropped ones.
    pub primitives: u64,
    /// Nodes, leaves included.
    pub nodes: u64,
    /// Leaves.
    pub leaves: u64,
    /// Leaves without any primitive.
    pub empty_leaves: u64,
    /// Primitives in leaves, counted as often as they occur.
    pub references: u64,
    /// Depth of the deepest leaf; a lone root has depth 0.
    pub depth: u32,
    /// Expected cost of a ray that meets the bounds: steps through nodes, plus tests in the builder's unit.
    pub sah_cost: f64,
    /// Memory of nodes and references.
    pub tree_bytes: u64,
    /// Memory of prepared triangles or instances.
    pub primitive_bytes: u64,
}
