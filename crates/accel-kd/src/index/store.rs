// SPDX-License-Identifier: GPL-3.0-or-later
//! Saving and loading of a kd-tree and its triangles. The format is that of `crate::store`. Tests:
//! `tests/saved.rs`.

use std::io::{self, Read, Write};

use super::{KdIndex, Prepared};
use crate::leaves::Leaves;
use crate::node::KdTree;
use crate::projected::ProjectedTriangles;
use gnurt_accel_core::MOST_TRIANGLES;
use gnurt_accel_core::store::{LoadError, Reader, Writer};
use gnurt_accel_core::{Aabb, TreeStats, TriangleTest};

impl KdIndex {
    /// Which test its triangles are for.
    pub fn triangle_test(&self) -> TriangleTest {
        match self.triangles {
            Prepared::Watertight(_) => TriangleTest::Watertight,
            Prepared::Projected(_) => TriangleTest::Projected,
        }
    }

    /// Writes the tree.
    ///
    /// # Errors
    /// Those of where it goes.
    pub fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        writer.list(&self.tree.nodes)?;
        writer.list(&self.tree.items)?;
        match &self.triangles {
            Prepared::Watertight(triangles) => triangles.save(writer),
            Prepared::Projected(triangles) => triangles.save(writer),
        }
    }

    /// The lists as they are; [`check`](Self::check) comes after the checksum.
    pub fn load(
        reader: &mut Reader<'_, impl Read>,
        bounds: Aabb,
        stats: TreeStats,
        test: TriangleTest,
    ) -> Result<Self, LoadError> {
        let nodes = reader.list(u32::MAX as usize)?;
        let items = reader.list(u32::MAX as usize)?;
        let tree = KdTree { nodes, items, bounds };
        let triangles = match test {
            TriangleTest::Watertight => Prepared::Watertight(Leaves::load(reader)?),
            TriangleTest::Projected => Prepared::Projected(ProjectedTriangles::load(reader, MOST_TRIANGLES)?),
        };
        let bytes = match &triangles {
            Prepared::Watertight(leaves) => leaves.memory_bytes(),
            Prepared::Projected(projected) => projected.memory_bytes(),
        };
        let tree_bytes = tree.memory_bytes() as u64;
        let stats = TreeStats { tree_bytes, primitive_bytes: bytes as u64, ..stats };
        Ok(Self { tree, triangles, greatest: bounds.greatest(), stats })
    }

    /// Whether all that a walk relies on is so, where there are `count` triangles.
    pub fn check(&self, count: u32) -> Result<(), LoadError> {
        match &self.triangles {
            Prepared::Watertight(leaves) => leaves.check(&self.tree, count),
            Prepared::Projected(triangles) => {
                let prepared = triangles.check()?;
                if prepared > count as usize {
                    return Err(LoadError::Damaged("there are too many triangles"));
                }
                self.tree.check_lists(prepared as u32)
            }
        }
    }
}
