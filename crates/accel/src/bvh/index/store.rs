// SPDX-License-Identifier: GPL-3.0-or-later
//! A wide BVH's way into a file and back. Source: original; the format is that of `crate::store`.
//! Invariant: what is loaded is one tree of nodes, children behind their parents, none deeper than a build would put it;
//! its leaves hold each block once. Proof: `tests/saved.rs`.

use std::io::{self, Read, Write};

use super::BvhIndex;
use crate::LARGEST_COORDINATE;
use crate::bvh::blocks::TriangleBlock;
use crate::bvh::build::DEEPEST;
use crate::bvh::{Child, Node8, Tree, WIDTH};
use crate::store::{LoadError, Reader, Record, Writer, get_floats, is_sound, put_floats};
use crate::{Aabb, TreeStats};

impl Record for Node8 {
    const WORDS: usize = 8 * WIDTH;

    #[inline(always)]
    fn put(&self, words: &mut [u32]) {
        put_floats(words, self.rows.as_flattened());
    }

    #[inline(always)]
    fn get(words: &[u32]) -> Self {
        let mut node = Self::EMPTY;
        get_floats(node.rows.as_flattened_mut(), words);
        node
    }
}

impl Record for TriangleBlock {
    const WORDS: usize = 10 * WIDTH;

    #[inline(always)]
    fn put(&self, words: &mut [u32]) {
        let (corners, numbers) = words.split_at_mut(9 * WIDTH);
        put_floats(corners, self.corners.as_flattened().as_flattened());
        numbers.copy_from_slice(&self.numbers);
    }

    #[inline(always)]
    fn get(words: &[u32]) -> Self {
        let mut block = Self { corners: [[[0.0; WIDTH]; 3]; 3], numbers: [0; WIDTH] };
        let (corners, numbers) = words.split_at(9 * WIDTH);
        get_floats(block.corners.as_flattened_mut().as_flattened_mut(), corners);
        block.numbers.copy_from_slice(numbers);
        block
    }
}

impl TriangleBlock {
    /// Whether its triangles can be tested, where there are `count` in all.
    pub(crate) fn check(&self, count: u32) -> Result<(), LoadError> {
        if !self.numbers.iter().all(|&number| number < count) {
            return Err(LoadError::Damaged("a block names a triangle that does not exist"));
        }
        // The greatest as bits, which NaN is as well.
        let corners = self.corners.as_flattened().as_flattened();
        let greatest = corners.iter().fold(0, |most, x| most.max(x.abs().to_bits()));
        if greatest > LARGEST_COORDINATE.to_bits() {
            return Err(LoadError::Damaged("a corner is too far away"));
        }
        Ok(())
    }
}

impl BvhIndex {
    pub(crate) fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        writer.list(&self.tree.nodes)?;
        writer.list(&self.blocks)
    }

    /// The lists as they are; [`check`](Self::check) comes after the checksum.
    pub(crate) fn load(
        reader: &mut Reader<'_, impl Read>,
        bounds: Aabb,
        stats: TreeStats,
    ) -> Result<Self, LoadError> {
        let nodes: Vec<Node8> = reader.list(1 << 27)?;
        let blocks: Vec<TriangleBlock> = reader.list(1 << 27)?;
        let tree = Tree { nodes, blocks: Vec::new(), bounds };
        // As it was measured: with the numbers only of what is in the blocks.
        let tree_bytes = size_of_val(&tree.nodes[..]) + size_of::<[u32; WIDTH]>() * blocks.len();
        let stats = TreeStats { tree_bytes: tree_bytes as u64, ..stats };
        Ok(Self { tree, blocks, reach: bounds.reach(), stats })
    }

    /// Whether all that a walk relies on is so, where there are `count` triangles.
    pub(crate) fn check(&self, count: u32) -> Result<(), LoadError> {
        self.blocks.iter().try_for_each(|block| block.check(count))?;
        self.tree.check(self.blocks.len())
    }
}

impl Tree {
    /// Whether all that a walk relies on is so, where leaves are of so many blocks.
    pub(crate) fn check(&self, blocks: usize) -> Result<(), LoadError> {
        let damaged = |what| Err(LoadError::Damaged(what));
        let nodes = &self.nodes;
        if nodes.is_empty() != self.bounds.is_empty() {
            return damaged("its bounds are not those of its nodes");
        }
        // One more than the depth of each node whose parent has been seen.
        let mut depths = vec![0u8; nodes.len()];
        depths.iter_mut().take(1).for_each(|root| *root = 1);
        let mut in_leaves = 0;
        for (at, node) in nodes.iter().enumerate() {
            let depth = depths[at];
            if depth == 0 {
                return damaged("a node has no parent before it");
            }
            for place in 0..WIDTH {
                let (bounds, child) = (node.bounds(place), node.child(place));
                if child == Child::NONE {
                    if bounds != Aabb::EMPTY {
                        return damaged("nothing has a box");
                    }
                    continue;
                }
                if !is_sound(&bounds) {
                    return damaged("a child's box is none");
                }
                if child.is_leaf() {
                    let range = child.blocks();
                    in_leaves += range.len();
                    if range.is_empty() || range.end > blocks {
                        return damaged("a leaf has blocks that do not exist");
                    }
                } else {
                    let index = child.index();
                    if index <= at || depths.get(index) != Some(&0) {
                        return damaged("a node is the child of several, or does not exist");
                    }
                    if depth as usize >= DEEPEST {
                        return damaged("it is too deep");
                    }
                    depths[index] = depth + 1;
                }
            }
        }
        if in_leaves != blocks {
            return damaged("a block is in several leaves, or in none");
        }
        Ok(())
    }
}
