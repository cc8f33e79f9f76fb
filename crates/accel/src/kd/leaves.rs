// SPDX-License-Identifier: GPL-3.0-or-later
//! The leaves of a kd-tree as rows of triangle blocks, in the order in which the tree holds them.
//! Source: original. A triangle that lies in several leaves is copied into each: what a leaf tests lies together.
//! Invariant: leaf 0 is the empty one. Proof: `tests/brute_force.rs`.

mod store;

use std::ops::Range;

use super::node::{EMPTY_LEAF, KdTree, Node};
use crate::INVALID_ID;
use crate::bvh::{TriangleBlock, WIDTH};
use crate::geometry::Screened;

/// Blocks of all leaves.
#[derive(Debug, PartialEq)]
pub(crate) struct Leaves {
    /// First block of each leaf, and one past the last of all.
    starts: Vec<u32>,
    pub(crate) blocks: Vec<TriangleBlock>,
}

impl Leaves {
    /// Takes the triangles' numbers out of `tree`: its leaves name blocks afterwards.
    pub(crate) fn take(tree: &mut KdTree, screened: &Screened) -> Self {
        let mut leaves = Self { starts: vec![0, 0], blocks: Vec::with_capacity(blocks_of(tree)) };
        let mut nodes = std::mem::take(&mut tree.nodes);
        for node in &mut nodes {
            if !node.is_leaf() || *node == EMPTY_LEAF {
                continue;
            }
            for numbers in tree.leaf_items(*node).chunks(WIDTH) {
                let mut padded = [INVALID_ID; WIDTH];
                padded[..numbers.len()].copy_from_slice(numbers);
                leaves.blocks.push(TriangleBlock::new(screened, &padded));
            }
            *node = Node::leaf(leaves.starts.len() as u32 - 1);
            leaves.starts.push(leaves.blocks.len() as u32);
        }
        leaves.starts.shrink_to_fit();
        tree.nodes = nodes;
        tree.items = Vec::new();
        leaves
    }

    /// What [`take`](Self::take) will take for its blocks.
    pub(crate) fn memory_for(tree: &KdTree) -> usize {
        size_of::<TriangleBlock>() * blocks_of(tree)
    }

    /// The blocks of a leaf.
    #[inline(always)]
    pub(crate) fn of(&self, leaf: Node) -> Range<usize> {
        let item = leaf.item();
        self.starts[item] as usize..self.starts[item + 1] as usize
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.blocks[..])
    }
}

/// How many blocks hold the triangles of all leaves.
fn blocks_of(tree: &KdTree) -> usize {
    let count = |node: &Node| {
        if node.is_leaf() && node.item() != 0 { tree.leaf_items(*node).len().div_ceil(WIDTH) } else { 0 }
    };
    tree.nodes.iter().map(count).sum()
}
