// SPDX-License-Identifier: GPL-3.0-or-later
//! A wide BVH's way into a file and back. Source: original; the format is that of `crate::store`.
//! Invariant: what is loaded is one tree of nodes and blocks in the order of a walk, none deeper than a build would put it. Proof: `tests/saved.rs`.

use std::io::{self, Read, Write};

use gnurt_accel_core::store::blocks::{check_corners, check_numbers};
use gnurt_accel_core::store::{
    LoadError, Reader, Words, Writer, get_bytes, get_floats, is_sound, put_bytes, put_floats,
};
use gnurt_accel_core::{Aabb, LARGEST_COORDINATE, Memory, TreeStats};

use super::BvhIndex;
use crate::compact::CompactNode;
use crate::leaves::Leaves;
use crate::node::{Child, Node8, WIDTH};
use crate::pools::{PooledBlock, Pools};
use crate::tree::{DEEPEST, Tree};

impl Words for Node8 {
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

impl Words for CompactNode {
    const WORDS: usize = 3 + 3 + 3 * 2 * WIDTH / 4 + WIDTH;

    #[inline(always)]
    fn put(&self, words: &mut [u32]) {
        let (origin, rest) = words.split_at_mut(3);
        let (step, rest) = rest.split_at_mut(3);
        let (counts, children) = rest.split_at_mut(3 * 2 * WIDTH / 4);
        put_floats(origin, &self.origin);
        put_floats(step, &self.step);
        put_bytes(counts, self.counts.as_flattened().as_flattened());
        put_floats(children, &self.children);
    }

    #[inline(always)]
    fn get(words: &[u32]) -> Self {
        let mut node = Self::EMPTY;
        let (origin, rest) = words.split_at(3);
        let (step, rest) = rest.split_at(3);
        let (counts, children) = rest.split_at(3 * 2 * WIDTH / 4);
        get_floats(&mut node.origin, origin);
        get_floats(&mut node.step, step);
        get_bytes(node.counts.as_flattened_mut().as_flattened_mut(), counts);
        get_floats(&mut node.children, children);
        node
    }
}

impl CompactNode {
    /// Whether planes can be computed.
    pub(crate) fn check(&self) -> Result<(), LoadError> {
        let steps = f32::MIN_POSITIVE..=4.0 * LARGEST_COORDINATE / 255.0;
        if self.step.iter().all(|step| steps.contains(step) && step.to_bits().trailing_zeros() >= 23) {
            return Ok(());
        }
        Err(LoadError::Damaged("a node's steps are none"))
    }
}

impl Words for PooledBlock {
    const WORDS: usize = 3 * WIDTH / 4 + 2 + WIDTH;

    #[inline(always)]
    fn put(&self, words: &mut [u32]) {
        let (places, rest) = words.split_at_mut(3 * WIDTH / 4);
        put_bytes(places, self.places.as_flattened());
        (rest[0], rest[1]) = (self.pool as u32, (self.pool >> 32) as u32);
        rest[2..].copy_from_slice(&self.numbers);
    }

    #[inline(always)]
    fn get(words: &[u32]) -> Self {
        let (places, rest) = words.split_at(3 * WIDTH / 4);
        let pool = u64::from(rest[0]) | u64::from(rest[1]) << 32;
        let mut block = Self { places: [[0; WIDTH]; 3], pool, numbers: [0; WIDTH] };
        get_bytes(block.places.as_flattened_mut(), places);
        block.numbers.copy_from_slice(&rest[2..]);
        block
    }
}

impl Pools {
    /// Whether blocks have corners, and triangles can be tested, where there are `count` in all.
    fn check(&self, count: u32) -> Result<(), LoadError> {
        check_corners(&self.corners)?;
        for PooledBlock { places, pool, numbers } in &self.blocks {
            check_numbers(numbers, count)?;
            let last = places.as_flattened().iter().max().map_or(0, |&last| u64::from(last));
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
        match self.tree.is_compact() {
            false => writer.list(&self.leaves.blocks),
            true => {
                writer.list(&self.leaves.pools.blocks)?;
                writer.list(&self.leaves.pools.corners)
            }
        }
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
        Ok(Self { greatest: tree.greatest(), tree, leaves, stats: TreeStats::default(), moving: None })
    }

    /// Whether all that a walk relies on is so, where there are `count` triangles. Then the tree is measured: what a file
    /// says of its cost is not believed.
    ///
    /// # Errors
    /// What is not so.
    pub fn check(&mut self, count: u32) -> Result<(), LoadError> {
        self.leaves.blocks.iter().try_for_each(|block| block.check(count))?;
        self.leaves.pools.check(count)?;
        self.tree.check(self.leaves.count())?;
        let measured = self.tree.measure();
        // As it was measured when it was built: with the numbers only of what is in the blocks, places that are left over
        // repeat the first.
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
            true => writer.list(&self.compact),
        }
    }

    /// Nodes as they are, without what they are built over.
    pub(crate) fn load(
        reader: &mut Reader<'_, impl Read>,
        memory: Memory,
        bounds: Aabb,
    ) -> Result<Self, LoadError> {
        let mut tree = Self::new(bounds);
        match memory {
            Memory::Fast => tree.nodes = reader.list(1 << 27)?,
            Memory::Compact => tree.compact = reader.list(1 << 27)?,
        }
        Ok(tree)
    }
}

impl Tree {
    /// Whether all that a walk relies on is so, where leaves are of so many blocks.
    pub(crate) fn check(&self, blocks: usize) -> Result<(), LoadError> {
        let damaged = |what| Err(LoadError::Damaged(what));
        let count = self.count();
        if (count == 0) != self.bounds.is_empty() {
            return damaged("its bounds are not those of its nodes");
        }
        // Nodes that are to come, the next one last, and their depths; and the next block.
        let mut waiting = if count == 0 { Vec::new() } else { vec![(0, 0)] };
        let mut next_block = 0;
        for at in 0..count {
            let Some((_, depth)) = waiting.pop().filter(|&(next, _)| next == at) else {
                return damaged("a node is not where a walk comes to it");
            };
            if depth >= DEEPEST {
                return damaged("it is too deep");
            }
            self.compact.get(at).map_or(Ok(()), CompactNode::check)?;
            for place in (0..WIDTH).rev() {
                let (child, bounds) = self.child(at, place);
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
                    if range.is_empty() || range.start != next_block || range.end > blocks {
                        return damaged("a leaf's blocks are not where a walk comes to them");
                    }
                    next_block = range.end;
                } else {
                    waiting.push((child.index(), depth + 1));
                }
            }
        }
        if !waiting.is_empty() || next_block != blocks {
            return damaged("nodes or blocks are missing, or there are too many");
        }
        Ok(())
    }
}
