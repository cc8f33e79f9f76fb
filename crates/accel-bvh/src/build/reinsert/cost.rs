// SPDX-License-Identifier: GPL-3.0-or-later
//! Conversion of a movable tree to nodes, with the expected cost of its wide tree.
//! Source: [YKL17], as in `collapse`. Invariant: as of [`MovableTree`]. Tests: `super::tests`.

use super::super::binary_node::BinaryNode;
use super::super::costs::{Costs, Shares, inner_costs, leaf_costs};
use super::MovableTree;

/// Below this height one thread does it.
const LOW: u32 = if cfg!(test) { 4 } else { 10 };

/// The division of slots between one node's children.
struct Shared {
    node: u32,
    shares: Shares,
}

impl MovableTree<'_> {
    /// Brings `nodes` up to date; returns the cost of the wide tree.
    pub(super) fn write(&self, nodes: &mut [BinaryNode]) -> f32 {
        let mut all = Vec::new();
        let costs = self.costs(self.root, &mut all);
        for Shared { node, shares } in all {
            let movable = self.movable(node);
            let back = movable.children.map(|child| node.wrapping_sub(child));
            nodes[node as usize] = BinaryNode::inner(movable.bounds, back, shares);
        }
        costs[1]
    }

    /// Costs of a node; the division of its slots, and of all below, goes to `all`.
    fn costs(&self, at: u32, all: &mut Vec<Shared>) -> Costs {
        let movable = self.movable(at);
        let area = movable.bounds.half_area(self.tasks.scale);
        if movable.is_leaf() {
            return leaf_costs(area);
        }
        let [left, right] = movable.children;
        let (left, right) = if self.tasks.parallel && movable.height > LOW {
            let mut more = Vec::new();
            let both = self.tasks.both(|| self.costs(left, all), || self.costs(right, &mut more));
            all.append(&mut more);
            both
        } else {
            (self.costs(left, all), self.costs(right, all))
        };
        let (costs, shares) = inner_costs(area, &left, &right);
        all.push(Shared { node: at, shares });
        costs
    }
}
