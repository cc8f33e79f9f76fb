// SPDX-License-Identifier: GPL-3.0-or-later
//! Size and shape of a wide BVH. Source: the cost is that of [MB90]. Tests: `tests::a_small_tree_is_measured`.

use gnurt_accel_core::{INVALID_ID, TreeStats};

use crate::node::{Child, WIDTH};
use crate::tree::Tree;

impl Tree {
    /// Counts everything; a visit of a node and a test of a block of eight cost 1 each.
    pub(crate) fn measure(&self) -> TreeStats {
        let mut stats = TreeStats { tree_bytes: self.memory_bytes() as u64, ..TreeStats::default() };
        if self.count() == 0 {
            return stats;
        }
        let whole = self.bounds.half_area();
        let share = |area: f64| if whole > 0.0 { area / whole } else { 1.0 };
        let mut depths = vec![0u8; self.count()];
        (stats.nodes, stats.sah_cost) = (1, 1.0);
        // Children come after their parents.
        for at in 0..self.count() {
            let depth = depths[at] + 1;
            stats.depth = stats.depth.max(u32::from(depth));
            let children = (0..WIDTH).map(|lane| self.child(at, lane));
            for (child, bounds) in children.filter(|(child, _)| *child != Child::NONE) {
                let area = bounds.half_area();
                stats.nodes += 1;
                if child.is_leaf() {
                    stats.leaves += 1;
                    stats.sah_cost += share(area) * child.blocks().len() as f64;
                } else {
                    stats.sah_cost += share(area);
                    depths[child.index()] = depth;
                }
            }
        }
        let numbers = self.blocks.iter().flatten();
        stats.references = numbers.filter(|&&number| number != INVALID_ID).count() as u64;
        stats
    }
}
