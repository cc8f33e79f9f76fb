// SPDX-License-Identifier: GPL-3.0-or-later
//! All triangles under a kd-tree that may meet a region.
//! Invariant: each point of the region lies in a cell whose leaf lists its triangles; cells are widened as
//! boxes are (`region.rs`).
//! Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/overlaps.rs`.

use gnurt_accel_core::Aabb;
use gnurt_accel_core::filter_region::NOTHING;
use gnurt_accel_core::region::{RegionFilter, Rows};

use crate::node::{KdTree, Node};

impl KdTree {
    /// Shows `leaf` the leaves that may meet it. The tree is not empty.
    pub(crate) fn filter_region(&self, region_filter: &RegionFilter, leaf: &mut dyn FnMut(Node)) {
        let mut waiting = vec![(0, self.bounds)];
        while let Some((at, cell)) = waiting.pop() {
            let node = self.nodes[at as usize];
            if node.is_leaf() {
                leaf(node);
                continue;
            }
            let parts = cell.split(node.axis(), node.plane());
            let mut rows: Rows = NOTHING;
            for (i, part) in parts.iter().enumerate() {
                for k in 0..3 {
                    (rows[2 * k][i], rows[2 * k + 1][i]) = (part.min[k], part.max[k]);
                }
            }
            let bits = region_filter.overlap_mask(&rows);
            let children: [(u32, Aabb); 2] = [(node.left(), parts[0]), (node.left() + 1, parts[1])];
            waiting.extend((0..2).filter(|i| bits >> i & 1 == 1).map(|i| children[i]));
        }
    }
}
