// SPDX-License-Identifier: GPL-3.0-or-later
//! Size and shape of a wide BVH. Source: the cost is that of [MB90]. Proof: `tests::a_small_tree_is_measured`.

use super::{Tree, WIDTH};
use crate::{INVALID_ID, TreeStats};

impl Tree {
    /// Counts everything; a visit of a node and a test of a block of eight cost 1 each.
    pub(crate) fn measure(&self) -> TreeStats {
        let mut stats = TreeStats {
            tree_bytes: (size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])) as u64,
            ..TreeStats::default()
        };
        if self.nodes.is_empty() {
            return stats;
        }
        let whole = self.bounds.half_area();
        let share = |area: f64| if whole > 0.0 { area / whole } else { 1.0 };
        let mut waiting = vec![(0, 1)];
        stats.nodes = 1;
        stats.sah_cost = 1.0;
        while let Some((at, depth)) = waiting.pop() {
            stats.depth = stats.depth.max(depth);
            let node = &self.nodes[at];
            for place in (0..WIDTH).filter(|&place| !node.bounds(place).is_empty()) {
                let (child, area) = (node.child(place), node.bounds(place).half_area());
                stats.nodes += 1;
                if child.is_leaf() {
                    stats.leaves += 1;
                    stats.sah_cost += share(area) * child.blocks().len() as f64;
                    let numbers = self.blocks.get(child.blocks()).unwrap_or(&[]).iter().flatten();
                    stats.references += numbers.filter(|&&number| number != INVALID_ID).count() as u64;
                } else {
                    stats.sah_cost += share(area);
                    waiting.push((child.index(), depth + 1));
                }
            }
        }
        stats
    }
}
