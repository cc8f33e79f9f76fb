// SPDX-License-Identifier: GPL-3.0-or-later
//! Saving and loading of a wide BVH. The format is that of `crate::store`.
//! Invariant: a loaded tree has its nodes in depth-first order, each block in one leaf, and no node deeper
//! than a build would put it. Tests: `tests/saved.rs`.

use std::io::{self, Read, Write};
use std::sync::Arc;

use gnurt_accel_core::store::blocks::{check_corners, check_numbers};
use gnurt_accel_core::store::{
    LoadError, Reader, StoredRecord, Writer, get_bytes, get_floats, is_sound, put_bytes, put_floats,
};
use gnurt_accel_core::{Aabb, FARTHEST_PLANE, Memory, TreeStats};

use super::BvhIndex;
use crate::compact::{Children, CompactNode};
use crate::leaves::Leaves;
use crate::node::{Child, Node8, WIDTH};
use crate::pools::{PooledBlock, Pools};
use crate::pose::PosedLeaves;
use crate::tree::{DEEPEST, Tree};

impl StoredRecord for Node8 {
    const LENGTH: usize = 8 * WIDTH;

    #[inline(always)]
    fn put(&self, data: &mut [u32]) {
        put_floats(data, self.rows.as_flattened());
    }

    #[inline(always)]
    fn get(data: &[u32]) -> Self {
        let mut node = Self::EMPTY;
        get_floats(node.rows.as_flattened_mut(), data);
        node
    }
}

/// A compact node with its contents, as files have it: steps are floats there.
pub(crate) struct Whole(pub(crate) CompactNode, pub(crate) Children);

impl StoredRecord for Whole {
    const LENGTH: usize = 3 + 3 + 3 * 2 * WIDTH / 4 + WIDTH;

    #[inline(always)]
    fn put(&self, data: &mut [u32]) {
        let (origin, rest) = data.split_at_mut(3);
        let (step, rest) = rest.split_at_mut(3);
        let (counts, children) = rest.split_at_mut(3 * 2 * WIDTH / 4);
        let Self(node, below) = self;
        put_floats(origin, &node.origin);
        put_floats(step, &[0, 1, 2].map(|k| node.step(k)));
        put_bytes(counts, node.counts.as_flattened().as_flattened());
        put_floats(children, below);
    }

    #[inline(always)]
    fn get(data: &[u32]) -> Self {
        let (mut node, mut below) = (CompactNode::EMPTY, [0.0; WIDTH]);
        let (origin, rest) = data.split_at(3);
        let (step, rest) = rest.split_at(3);
        let (counts, children) = rest.split_at(3 * 2 * WIDTH / 4);
        get_floats(&mut node.origin, origin);
        for (exponent, &step) in node.exponents.iter_mut().zip(step) {
            // A value other than a power of two becomes zero, which the check finds.
            let is_power = step & !(0xff << 23) == 0;
            *exponent = if is_power { (step >> 23) as u8 } else { 0 };
        }
        get_bytes(node.counts.as_flattened_mut().as_flattened_mut(), counts);
        get_floats(&mut below, children);
        Self(node, below)
    }
}

impl CompactNode {
    /// Whether planes can be computed.
    pub(crate) fn check(&self) -> Result<(), LoadError> {
        // At most twice the step that divides the greatest extent by 255.
        let steps = f32::MIN_POSITIVE..=4.0 * FARTHEST_PLANE / 255.0;
        if (0..3).all(|k| steps.contains(&self.step(k))) {
            return Ok(());
        }
        Err(LoadError::Damaged("a node's steps are none"))
    }
}

impl StoredRecord for PooledBlock {
    const LENGTH: usize = 3 * WIDTH / 4 + 2 + WIDTH;

    #[inline(always)]
    fn put(&self, data: &mut [u32]) {
        let (offsets, rest) = data.split_at_mut(3 * WIDTH / 4);
        put_bytes(offsets, self.offsets.as_flattened());
        (rest[0], rest[1]) = (self.pool as u32, (self.pool >> 32) as u32);
        rest[2..].copy_from_slice(&self.numbers);
    }

    #[inline(always)]
    fn get(data: &[u32]) -> Self {
        let (offsets, rest) = data.split_at(3 * WIDTH / 4);
        let pool = u64::from(rest[0]) | u64::from(rest[1]) << 32;
        let mut block = Self { offsets: [[0; WIDTH]; 3], pool, numbers: [0; WIDTH] };
        get_bytes(block.offsets.as_flattened_mut(), offsets);
        block.numbers.copy_from_slice(&rest[2..]);
        block
    }
}

impl Pools {
    /// Whether blocks have corners, and triangles can be tested, where there are `count` in all.
    fn check(&self, count: u32) -> Result<(), LoadError> {
        check_corners(&self.corners)?;
        for PooledBlock { offsets, pool, numbers } in &self.blocks {
            check_numbers(numbers, count)?;
            let last = offsets.as_flattened().iter().max().map_or(0, |&last| u64::from(last));
            // Three floats from there on.
            if pool.checked_add(last + 3).is_none_or(|end| end > self.corners.len() as u64) {
                return Err(LoadError::Damaged("a block has corners that do not exist"));
            }
        }
        Ok(())
    }
}

impl BvhIndex {
    /// Writes the tree.
    ///
    /// # Errors
    /// Those of where it goes.
    pub fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        self.tree.save(writer)?;
        if !self.tree.is_compact() {
            return writer.list(&self.leaves.blocks);
        }
        // A pose goes into a file as a tree by itself.
        let single = self.leaves.posed.as_ref().map(PosedLeaves::to_pools);
        let pools = single.as_ref().unwrap_or(&self.leaves.pools);
        writer.list(&pools.blocks)?;
        writer.list(&pools.corners)
    }

    /// Whether it is compact.
    pub fn is_compact(&self) -> bool {
        self.tree.is_compact()
    }

    /// The lists as they are; [`check`](Self::check) comes after the checksum.
    pub fn load(reader: &mut Reader<'_, impl Read>, memory: Memory, bounds: Aabb) -> Result<Self, LoadError> {
        let tree = Tree::load(reader, memory, bounds)?;
        let leaves = match memory {
            Memory::Fast => Leaves { blocks: reader.list(1 << 27)?, ..Leaves::default() },
            Memory::Compact => {
                let pools = Pools { blocks: reader.list(1 << 27)?, corners: reader.list(usize::MAX)? };
                Leaves { pools, ..Leaves::default() }
            }
        };
        Ok(Self { leaves, ..Self::of_tree(tree, TreeStats::default()) })
    }

    /// Checks all properties that a traversal relies on, for `count` triangles. Then measures the tree,
    /// because a cost from a file is not trusted.
    ///
    /// # Errors
    /// The violated property.
    pub fn check(&mut self, count: u32) -> Result<(), LoadError> {
        self.leaves.blocks.iter().try_for_each(|block| block.check(count))?;
        self.leaves.pools.check(count)?;
        self.tree.check(self.leaves.count())?;
        let measured = self.tree.measure();
        // As measured at the build: with the numbers of used slots only; spare slots repeat the first.
        let tree_bytes = (self.tree.node_bytes() + size_of::<[u32; WIDTH]>() * self.leaves.count()) as u64;
        let fast = self.leaves.blocks.iter().map(|block| &block.numbers);
        let numbers = fast.chain(self.leaves.pools.blocks.iter().map(|block| &block.numbers));
        let references =
            numbers.map(|all| 1 + all[1..].iter().filter(|&&n| n != all[0]).count() as u64).sum();
        self.stats = TreeStats { tree_bytes, references, ..measured };
        Ok(())
    }
}

impl Tree {
    /// Writes the nodes.
    pub(crate) fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        match self.is_compact() {
            false => writer.list(&self.nodes),
            true => {
                let whole = |(node, children): (&CompactNode, &Children)| Whole(node.clone(), *children);
                writer.list(&self.compact.iter().zip(&self.children[..]).map(whole).collect::<Vec<_>>())
            }
        }
    }

    /// The stored nodes, without their primitives.
    pub(crate) fn load(
        reader: &mut Reader<'_, impl Read>,
        memory: Memory,
        bounds: Aabb,
    ) -> Result<Self, LoadError> {
        let mut tree = Self::new(bounds);
        match memory {
            Memory::Fast => tree.nodes = reader.list(1 << 27)?,
            Memory::Compact => {
                let whole: Vec<Whole> = reader.list(1 << 27)?;
                let children;
                (tree.compact, children) =
                    whole.into_iter().map(|Whole(node, children)| (node, children)).unzip();
                tree.children = Arc::new(children);
            }
        }
        Ok(tree)
    }
}

impl Tree {
    /// Checks all properties that a traversal relies on, for leaves of this many blocks.
    pub(crate) fn check(&self, blocks: usize) -> Result<(), LoadError> {
        let damaged = |what| Err(LoadError::Damaged(what));
        let count = self.count();
        if (count == 0) != self.bounds.is_empty() {
            return damaged("its bounds are not those of its nodes");
        }
        // Nodes that are to come, the next one last, and their depths; and blocks that have come.
        let mut waiting = if count == 0 { Vec::new() } else { vec![(0, 0)] };
        let (mut visited, mut visited_blocks) = (vec![false; blocks], 0);
        for at in 0..count {
            let Some((_, depth)) = waiting.pop().filter(|&(next, _)| next == at) else {
                return damaged("a node is not where a walk comes to it");
            };
            if depth >= DEEPEST {
                return damaged("it is too deep");
            }
            self.compact.get(at).map_or(Ok(()), CompactNode::check)?;
            for lane in (0..WIDTH).rev() {
                let (child, bounds) = self.child(at, lane);
                if child == Child::NONE {
                    if bounds != Aabb::EMPTY {
                        return damaged("nothing has a box");
                    }
                    continue;
                }
                if !is_sound(&bounds) {
                    return damaged("invalid box of a child");
                }
                if child.is_leaf() {
                    let range = child.blocks();
                    if range.is_empty() || range.end > blocks || visited[range.clone()].contains(&true) {
                        return damaged("a leaf's blocks are none, or another leaf's");
                    }
                    visited_blocks += range.len();
                    visited[range].fill(true);
                } else {
                    waiting.push((child.index(), depth + 1));
                }
            }
        }
        if !waiting.is_empty() || visited_blocks != blocks {
            return damaged("nodes or blocks are missing, or there are too many");
        }
        Ok(())
    }
}
