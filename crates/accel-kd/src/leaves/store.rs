// SPDX-License-Identifier: GPL-3.0-or-later
//! Saving and loading of leaves of blocks. The format is that of `crate::store`.
//! Invariant: each block is in one leaf, and leaves are numbered in the order of their nodes. Tests: `tests/saved.rs`.

use std::io::{self, Read, Write};

use super::Leaves;
use crate::node::KdTree;
use gnurt_accel_core::blocks::TriangleBlock;
use gnurt_accel_core::store::{LoadError, Reader, Writer};

impl Leaves {
    pub(crate) fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        writer.list(&self.starts)?;
        writer.list(&self.blocks)
    }

    pub(crate) fn load(reader: &mut Reader<'_, impl Read>) -> Result<Self, LoadError> {
        let starts = reader.list(u32::MAX as usize)?;
        let blocks: Vec<TriangleBlock> = reader.list(u32::MAX as usize)?;
        Ok(Self { starts, blocks })
    }

    /// Checks that these are valid leaves of a valid tree, over `count` triangles.
    pub(crate) fn check(&self, tree: &KdTree, count: u32) -> Result<(), LoadError> {
        let damaged = |what| Err(LoadError::Damaged(what));
        let Self { starts, blocks } = self;
        if !tree.items.is_empty() {
            return damaged("a leaf is a list");
        }
        if starts.get(..2) != Some(&[0, 0])
            || !starts.is_sorted()
            || starts.last() != Some(&(blocks.len() as u32))
        {
            return damaged("leaves are not in a row");
        }
        blocks.iter().try_for_each(|block| block.check(count))?;
        let mut next = 1;
        tree.check(|leaf| {
            next += 1;
            if leaf.item() + 1 == next { Ok(()) } else { damaged("leaves are out of order") }
        })?;
        if next + 1 == starts.len() { Ok(()) } else { damaged("leaves are missing") }
    }
}
