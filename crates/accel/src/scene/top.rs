// SPDX-License-Identifier: GPL-3.0-or-later
//! The top tree: a bounding volume hierarchy over the world boxes of instances, built anew whenever they move.
//! Source: SAH sweep over sorted centres after [MB90, WBS07]. A kd-tree would list large instances again and again,
//! and an object costs far more than a triangle to test twice.
//! Invariant: children of a node lie next to each other; depth is at most [`DEEPEST`].
//! Cost: O(n log^2 n). Proof: `tests::{every_box_is_in_its_parents, piles_stay_shallow}`.

use crate::{Aabb, TreeStats};

/// Traversal stacks hold this many entries.
pub(super) const DEEPEST: usize = 64;
/// Below this depth nodes are halved by number, which ends within 32 levels more.
const SAH_DEPTH: usize = 28;

/// A box with either two children or instances in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct TopNode {
    pub(super) bounds: Aabb,
    /// Inner node: the first of two children. Leaf: where its instances start in `order`.
    pub(super) first: u32,
    /// Number of instances; 0 for an inner node.
    pub(super) count: u32,
}

/// The tree; without instances there are no nodes.
#[derive(Debug, Default)]
pub(super) struct TopTree {
    pub(super) nodes: Vec<TopNode>,
    /// Places of instances, leaf by leaf.
    pub(super) order: Vec<u32>,
}

impl TopTree {
    /// Over boxes, none of them empty.
    pub(super) fn build(boxes: &[Aabb]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..boxes.len() as u32).collect() };
        if boxes.is_empty() {
            return tree;
        }
        let leaf = |first: usize, count: usize| TopNode {
            bounds: Aabb::EMPTY,
            first: first as u32,
            count: count as u32,
        };
        tree.nodes.push(leaf(0, boxes.len()));
        let mut waiting = vec![(0, 0)];
        while let Some((at, depth)) = waiting.pop() {
            let TopNode { first, count, .. } = tree.nodes[at];
            let range = first as usize..(first + count) as usize;
            let members = &mut tree.order[range.clone()];
            tree.nodes[at].bounds = members.iter().fold(Aabb::EMPTY, |all, &i| all.union(&boxes[i as usize]));
            if count < 2 {
                continue;
            }
            let middle =
                range.start + if depth < SAH_DEPTH { divide(members, boxes) } else { members.len() / 2 };
            let children = tree.nodes.len();
            tree.nodes.push(leaf(range.start, middle - range.start));
            tree.nodes.push(leaf(middle, range.end - middle));
            tree.nodes[at].first = children as u32;
            tree.nodes[at].count = 0;
            waiting.extend([(children + 1, depth + 1), (children, depth + 1)]);
        }
        tree
    }

    pub(super) fn stats(&self) -> TreeStats {
        let leaves = self.nodes.iter().filter(|node| node.count > 0);
        let whole = self.nodes.first().map_or(0.0, |root| root.bounds.half_area());
        let share = |bounds: &Aabb| if whole > 0.0 { bounds.half_area() / whole } else { 0.0 };
        TreeStats {
            primitives: self.order.len() as u64,
            nodes: self.nodes.len() as u64,
            leaves: leaves.clone().count() as u64,
            empty_leaves: 0,
            references: self.order.len() as u64,
            depth: self.depth(),
            sah_cost: self.nodes.iter().map(|node| share(&node.bounds) * f64::from(node.count.max(1))).sum(),
            tree_bytes: (size_of_val(&self.nodes[..]) + size_of_val(&self.order[..])) as u64,
            primitive_bytes: 0,
        }
    }

    fn depth(&self) -> u32 {
        let mut depths = vec![0; self.nodes.len()];
        for (at, node) in self.nodes.iter().enumerate().filter(|(_, node)| node.count == 0) {
            // Children come after their parents.
            depths[node.first as usize] = depths[at] + 1;
            depths[node.first as usize + 1] = depths[at] + 1;
        }
        depths.into_iter().max().unwrap_or(0)
    }
}

/// Orders `members` along the best axis and says how many go left: at least one, and not all.
fn divide(members: &mut [u32], boxes: &[Aabb]) -> usize {
    let centre = |i: u32, axis: usize| {
        let Aabb { min, max } = boxes[i as usize];
        f64::from(min[axis]) + f64::from(max[axis])
    };
    let sort = |members: &mut [u32], axis: usize| {
        members.sort_unstable_by(|&a, &b| centre(a, axis).total_cmp(&centre(b, axis)).then(a.cmp(&b)));
    };
    let n = members.len();
    let (mut best_cost, mut best_axis, mut best_left) = (f64::INFINITY, 0, n / 2);
    let mut right_costs = vec![0.0; n];
    for axis in 0..3 {
        sort(members, axis);
        let mut right = Aabb::EMPTY;
        for i in (1..n).rev() {
            right = right.union(&boxes[members[i] as usize]);
            right_costs[i] = right.half_area() * (n - i) as f64;
        }
        let mut left = Aabb::EMPTY;
        for i in 1..n {
            left = left.union(&boxes[members[i - 1] as usize]);
            let cost = left.half_area() * i as f64 + right_costs[i];
            if cost < best_cost {
                (best_cost, best_axis, best_left) = (cost, axis, i);
            }
        }
    }
    sort(members, best_axis);
    best_left
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_box_is_in_its_parents() {
        let boxes: Vec<Aabb> = (0..500u32)
            .map(|i| {
                let corner = [i % 7, i * i % 31, i % 13].map(|x| x as f32);
                Aabb { min: corner, max: corner.map(|x| x + (i % 3) as f32) }
            })
            .collect();
        let tree = TopTree::build(&boxes);
        let mut seen = vec![0; boxes.len()];
        for node in &tree.nodes {
            if node.count == 0 {
                let both =
                    tree.nodes[node.first as usize].bounds.union(&tree.nodes[node.first as usize + 1].bounds);
                assert_eq!(both, node.bounds, "a node is the box of its children");
                continue;
            }
            for &i in &tree.order[node.first as usize..][..node.count as usize] {
                seen[i as usize] += 1;
                assert_eq!(
                    node.bounds.union(&boxes[i as usize]),
                    node.bounds,
                    "instance {i} is in its leaf's box"
                );
            }
        }
        assert!(seen.iter().all(|&n| n == 1), "each instance is in one leaf");
    }

    #[test]
    fn piles_stay_shallow() {
        let same = vec![Aabb { min: [0.0; 3], max: [1.0; 3] }; 3000];
        let growing: Vec<Aabb> =
            (0..3000).map(|i| Aabb { min: [0.0; 3], max: [1.01f32.powi(i % 2000), 1.0, 1.0] }).collect();
        for boxes in [same, growing] {
            let depth = TopTree::build(&boxes).stats().depth as usize;
            assert!(depth < DEEPEST, "depth {depth} fits the stack");
        }
        assert!(TopTree::build(&[]).nodes.is_empty(), "nothing to see");
    }
}
