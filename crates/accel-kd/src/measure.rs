// SPDX-License-Identifier: GPL-3.0-or-later
//! Size, shape and expected cost of a kd-tree.
//! Source: [MB90] for the cost: each node is met with a probability that is its share of the root's surface.

use crate::node::KdTree;
use crate::sah::Costs;
use gnurt_accel_core::{Aabb, BuildOptions, TreeStats};

impl KdTree {
    /// Visits every node once.
    pub(crate) fn measure(&self, options: &BuildOptions) -> TreeStats {
        let costs = Costs {
            triangle: f64::from(options.triangle_cost),
            empty_factor: f64::from(options.empty_factor),
        };
        let mut stats = TreeStats {
            nodes: self.nodes.len() as u64,
            tree_bytes: (size_of_val(&self.nodes[..]) + size_of_val(&self.items[..])) as u64,
            ..TreeStats::default()
        };
        let whole = self.bounds.half_area();
        let mut waiting: Vec<(usize, Aabb, u32)> = vec![(0, self.bounds, 0)];
        while let Some((at, bounds, depth)) = waiting.pop() {
            let node = self.nodes[at];
            let share = if whole > 0.0 { bounds.half_area() / whole } else { 0.0 };
            if node.is_leaf() {
                let count = self.leaf_items(node).len();
                stats.leaves += 1;
                stats.empty_leaves += u64::from(count == 0);
                stats.references += count as u64;
                stats.depth = stats.depth.max(depth);
                stats.sah_cost += share * costs.leaf(count);
            } else {
                stats.sah_cost += share;
                let children = bounds.split(node.axis(), node.plane());
                for (child, bounds) in children.into_iter().enumerate() {
                    waiting.push((node.left() as usize + child, bounds, depth + 1));
                }
            }
        }
        stats
    }
}
