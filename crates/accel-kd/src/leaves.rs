// SPDX-License-Identifier: GPL-3.0-or-later
//! The leaves of a kd-tree as rows of triangle blocks, in the order in which the tree holds them.
//! A triangle in several leaves is copied into each, so that the triangles of a leaf are adjacent.
//! Invariant: leaf 0 is the empty one. Tests: `tests/brute_force.rs`.

mod store;

use std::ops::Range;

use crate::node::{EMPTY_LEAF, KdTree, Node};
use gnurt_accel_core::blocks::{TriangleBlock, WIDTH};
use gnurt_accel_core::threads::extend;
use gnurt_accel_core::valid_triangles::ValidTriangles;
use gnurt_accel_core::{INVALID_ID, Threads};

/// Blocks of all leaves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Leaves {
    /// First block of each leaf, and one past the last of all.
    starts: Vec<u32>,
    pub(crate) blocks: Vec<TriangleBlock>,
}

impl Leaves {
    /// Takes the triangles' numbers out of `tree`: its leaves name blocks afterwards.
    pub(crate) fn take(tree: &mut KdTree, valid_triangles: &ValidTriangles, threads: Threads) -> Self {
        let mut nodes = std::mem::take(&mut tree.nodes);
        let mut starts = vec![0, 0];
        let mut in_blocks: Vec<&[u32]> = Vec::with_capacity(blocks_of(&nodes, tree));
        for node in nodes.iter_mut().filter(|node| node.is_leaf() && **node != EMPTY_LEAF) {
            in_blocks.extend(tree.leaf_items(*node).chunks(WIDTH));
            *node = Node::leaf(starts.len() as u32 - 1);
            starts.push(in_blocks.len() as u32);
        }
        let block = |i: usize| {
            let (numbers, mut padded) = (in_blocks[i], [INVALID_ID; WIDTH]);
            padded[..numbers.len()].copy_from_slice(numbers);
            TriangleBlock::new(|number| valid_triangles.corners(number), &padded)
        };
        let mut blocks = Vec::with_capacity(in_blocks.len());
        threads.run(|parallel| extend(parallel, &mut blocks, in_blocks.len(), block));
        starts.shrink_to_fit();
        drop(in_blocks);
        tree.nodes = nodes;
        tree.items = Vec::new();
        Self { starts, blocks }
    }

    /// The memory of the blocks of [`take`](Self::take).
    pub(crate) fn memory_for(tree: &KdTree) -> usize {
        size_of::<TriangleBlock>() * blocks_of(&tree.nodes, tree)
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
fn blocks_of(nodes: &[Node], tree: &KdTree) -> usize {
    let count = |node: &Node| {
        if node.is_leaf() && node.item() != 0 { tree.leaf_items(*node).len().div_ceil(WIDTH) } else { 0 }
    };
    nodes.iter().map(count).sum()
}
