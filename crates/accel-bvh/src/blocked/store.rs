// SPDX-License-Identifier: GPL-3.0-or-later
//! Saving and loading of blocks and their tree. The format is that of `gnurt_accel_core::store`.
//! Tests: `tests/saved.rs` of `gnurt-accel`.

use std::io::{self, Read, Write};

use gnurt_accel_core::store::{LoadError, Reader, Writer};
use gnurt_accel_core::{Aabb, INVALID_ID, Memory, TreeStats};

use super::{BlockData, BlockKind, Blocked, Shared, lanes, primitives};
use crate::node::WIDTH;
use crate::tree::Tree;

/// No tree has more geometries with shared data.
const MOST_SHARED: u64 = 1 << 27;

impl<B: BlockKind> Blocked<B> {
    /// Its kind in files.
    ///
    /// # Errors
    /// It cannot be saved.
    pub(crate) fn in_files(&self) -> io::Result<u64> {
        let unsaved = |reason| io::Error::new(io::ErrorKind::Unsupported, reason);
        B::IN_FILES.map(|kinds| kinds[usize::from(self.tree.is_compact())]).map_err(unsaved)
    }

    /// Writes the tree.
    ///
    /// # Errors
    /// Those of the target.
    pub(crate) fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        self.tree.save(writer)?;
        writer.list(&self.blocks)?;
        if size_of::<B::Data>() == 0 {
            return Ok(());
        }
        writer.number(self.shared.0.len() as u64)?;
        for (start, data) in &self.shared.0 {
            writer.number(u64::from(*start))?;
            data.save(writer)?;
        }
        Ok(())
    }

    /// The lists as they are; [`check`](Self::check) comes after the checksum.
    pub(crate) fn load(
        reader: &mut Reader<'_, impl Read>,
        memory: Memory,
        bounds: Aabb,
    ) -> Result<Self, LoadError> {
        let tree = Tree::load(reader, memory, bounds)?;
        let blocks: Vec<B> = reader.list(1 << 27)?;
        let mut shared = Shared(Vec::new());
        if size_of::<B::Data>() != 0 {
            let count = reader.number()?;
            if count > MOST_SHARED {
                return Err(LoadError::Damaged("a list is too long"));
            }
            for _ in 0..count {
                let start = u32::try_from(reader.number()?);
                let start = start.map_err(|_| LoadError::Damaged("a number has more than 32 bits"))?;
                if shared.0.last().is_some_and(|(before, _)| *before > start) {
                    return Err(LoadError::Damaged("its geometries are not in a row"));
                }
                shared.0.push((start, B::Data::load(reader)?));
            }
        }
        Ok(Self { greatest: tree.greatest(), tree, blocks, shared, stats: TreeStats::default() })
    }

    /// Checks all properties that a traversal relies on, for `count` primitives. Then the tree is measured.
    ///
    /// # Errors
    /// The violated property.
    pub(crate) fn check(&mut self, count: u32) -> Result<(), LoadError> {
        let is_sound = |block: &B| (0..WIDTH).all(|lane| block.is_sound(lane, &self.shared, count));
        if !self.blocks.iter().all(is_sound) {
            return Err(LoadError::Damaged("invalid primitive"));
        }
        self.tree.check(self.blocks.len())?;
        let references = self.blocks.iter().flat_map(lanes).count() as u64;
        let mut numbers: Vec<u32> =
            self.blocks.iter().flat_map(primitives).map(|(_, _, number)| number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let primitives = numbers.len() as u64;
        self.stats = TreeStats { references, primitives, ..self.tree.measure() };
        Ok(())
    }

    /// Whether both have the same nodes and blocks, bit for bit.
    pub(crate) fn same_tree(&self, other: &Self) -> bool {
        let same = |(a, b): (&B, &B)| {
            let (mut of_a, mut of_b) = (vec![INVALID_ID; B::LENGTH], vec![INVALID_ID; B::LENGTH]);
            a.put(&mut of_a);
            b.put(&mut of_b);
            of_a == of_b
        };
        let as_many = self.blocks.len() == other.blocks.len();
        as_many && self.tree == other.tree && self.blocks.iter().zip(&other.blocks).all(same)
    }
}
