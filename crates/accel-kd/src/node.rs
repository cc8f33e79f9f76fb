// SPDX-License-Identifier: GPL-3.0-or-later
//! The kd-tree's layout: 8 bytes per node on every machine, as the paper's Figure 5.
//! Source: the paper's section 5.2.
//!
//! ```text
//! node  | left: u32            | value: f32 with the axis in its two lowest bits    inner: children left, left + 1
//!       | 0                    | item: u32, where the leaf's list starts            leaf
//! items | count, triangle, triangle, ... | count, triangle, ... |                   items[0] = 0: the empty leaf
//! ```
//!
//! A stored plane is up to two units in the last place away from the builder's; `slab.rs` widens every
//! interval by more than that. Tests: `tests::planes_move_by_two_ulps_at_most`.

mod store;

use gnurt_accel_core::Aabb;

/// An inner node or a leaf.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Node {
    left: u32,
    value_or_item: u32,
}

/// An empty leaf: the initial value of a slot.
pub(crate) const EMPTY_LEAF: Node = Node { left: 0, value_or_item: 0 };

impl Node {
    pub(crate) fn leaf(item: u32) -> Self {
        Self { left: 0, value_or_item: item }
    }

    /// `left > 0`: node 0 is the root and nobody's child.
    pub(crate) fn inner(left: u32, axis: usize, plane: f32) -> Self {
        Self { left, value_or_item: nearest_with_axis(axis, plane).to_bits() }
    }

    /// The same node after `nodes` nodes and `items` items were put before its subtree's.
    pub(crate) fn moved(self, nodes: u32, items: u32) -> Self {
        match self {
            EMPTY_LEAF => self,
            Self { left: 0, value_or_item } => Self::leaf(value_or_item + items),
            Self { left, value_or_item } => Self { left: left + nodes, value_or_item },
        }
    }

    #[inline(always)]
    pub(crate) fn is_leaf(self) -> bool {
        self.left == 0
    }

    /// First child of an inner node: the side of smaller coordinates.
    #[inline(always)]
    pub(crate) fn left(self) -> u32 {
        self.left
    }

    /// 0, 1 or 2; the type of an index that needs no check against arrays of four.
    #[inline(always)]
    pub(crate) fn axis(self) -> usize {
        (self.value_or_item & 3) as usize
    }

    #[inline(always)]
    pub(crate) fn plane(self) -> f32 {
        f32::from_bits(self.value_or_item)
    }

    #[inline(always)]
    pub(crate) fn item(self) -> usize {
        self.value_or_item as usize
    }
}

/// The float nearest to `plane` whose two lowest bits are `axis`.
fn nearest_with_axis(axis: usize, plane: f32) -> f32 {
    let bits = plane.to_bits();
    let same_block = (bits & !3) | axis as u32;
    // At most two steps away, unless the axis is 0 and the bits end in 3: then the next block is nearer.
    f32::from_bits(if axis as u32 + 3 == (bits & 3) { same_block + 4 } else { same_block })
}

/// Traversal stacks hold this many entries; the builder goes no deeper.
pub(crate) const DEEPEST: usize = 64;

/// A tree; node 0 is the root.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct KdTree {
    pub(crate) nodes: Vec<Node>,
    pub(crate) items: Vec<u32>,
    pub(crate) bounds: Aabb,
}

impl KdTree {
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.items[..])
    }

    /// The triangles of a leaf.
    #[inline(always)]
    pub(crate) fn leaf_items(&self, leaf: Node) -> &[u32] {
        let (count, rest) = self.items[leaf.item()..].split_first().unwrap_or((&0, &[]));
        &rest[..*count as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_eight_bytes() {
        assert_eq!(size_of::<Node>(), 8, "Figure 5 promises 8 bytes");
    }

    #[test]
    fn planes_move_by_two_ulps_at_most() {
        for base in [0.0f32, 1.0, -1.0, 1e-40, 1e18, -3.5e-7] {
            for step in 0..8 {
                let plane = f32::from_bits(base.to_bits() + step);
                for axis in 0..3 {
                    let node = Node::inner(7, axis, plane);
                    let moved = node.plane().to_bits().abs_diff(plane.to_bits());
                    assert_eq!(
                        (node.axis(), node.left(), node.is_leaf()),
                        (axis, 7, false),
                        "fields of {node:?}"
                    );
                    assert!(moved <= 2, "{plane:e} on axis {axis} moved by {moved} ulps");
                }
            }
        }
        assert!(Node::leaf(3).is_leaf(), "no left child means leaf");
        assert_eq!(Node::leaf(3).moved(5, 2), Node::leaf(5), "items move");
        assert_eq!(EMPTY_LEAF.moved(5, 2), EMPTY_LEAF, "all empty leaves share one list");
    }
}
