// SPDX-License-Identifier: GPL-3.0-or-later
//! Boxes of nodes from boxes of leaf blocks, from the last node to the root, and the cost of each subtree.
//! Source: [WBS06] section 4; the cost is that of [MB90]. Space: that of the primitives.
//! Invariant: nodes are in depth-first order, so that a subtree is one range of them. Tests: `tests`.

use gnurt_accel_core::float::{least, most};
use gnurt_accel_core::threads::both;
use gnurt_accel_core::{Aabb, Memory};

use crate::compact::Children;
use crate::node::{Child, Node8, WIDTH};
use crate::tree::Tree;

/// Subtrees of at most this many nodes are fitted by one thread. Tests have small scenes.
const PIECE: usize = if cfg!(test) { 1 << 3 } else { 1 << 8 };

/// Some subtrees side by side.
struct Subtree<'a> {
    nodes: &'a mut [Node8],
    costs: &'a mut [f32],
    /// The first node's index in the tree.
    base: usize,
    bounds: Aabb,
}

impl Tree {
    /// Fits all nodes, given boxes of the leaf blocks, and returns the cost of the tree. Leaves in `costs`
    /// the expected cost of a ray that hits a node's box, below it, in steps and blocks, node by node.
    pub(crate) fn refit(&mut self, boxes: &[Aabb], parallel: bool, costs: &mut Vec<f32>) -> f64 {
        costs.clear();
        costs.resize(self.count(), 0.0);
        if self.is_compact() {
            let expanded = |children: &Children| {
                let mut node = Node8::EMPTY;
                node.rows[6] = *children;
                node
            };
            self.nodes = self.children.iter().map(expanded).collect();
            self.compact = Vec::new();
            self.refit(boxes, parallel, costs);
            self.settle(Memory::Compact);
            // Of boxes as they are now: rounded outwards.
            *costs = self.costs();
            return self.measure().sah_cost;
        }
        let mut whole =
            Subtree { nodes: &mut self.nodes, costs: &mut costs[..], base: 0, bounds: Aabb::EMPTY };
        if !whole.nodes.is_empty() {
            whole.fit(boxes, parallel);
            self.bounds = whole.bounds;
        }
        1.0 + costs.first().map_or(0.0, |&cost| f64::from(cost))
    }

    /// The result of [`refit`](Self::refit) in `costs` without any motion.
    pub(crate) fn costs(&self) -> Vec<f32> {
        let mut costs = vec![0.0; self.count()];
        for at in (0..self.count()).rev() {
            let mut sum = Sum::NONE;
            for lane in 0..WIDTH {
                let (child, bounds) = self.child(at, lane);
                sum.add(child, &bounds, |index| costs[index]);
            }
            costs[at] = sum.cost();
        }
        costs
    }
}

impl Subtree<'_> {
    fn fit(&mut self, boxes: &[Aabb], parallel: bool) {
        if !parallel || self.nodes.len() <= PIECE {
            return self.fit_single(boxes);
        }
        let Some((root, nodes)) = self.nodes.split_first_mut() else { return };
        let (cost, mut costs) = match self.costs.split_first_mut() {
            Some((cost, costs)) => (cost, costs),
            None => return,
        };
        let children = (0..WIDTH).map(|lane| root.child(lane));
        let starts: Vec<usize> =
            children.filter(|child| !child.is_leaf()).map(|child| child.index() - self.base).collect();
        let (mut nodes, mut below) = (nodes, Vec::with_capacity(WIDTH));
        for (i, &start) in starts.iter().enumerate() {
            let end = starts.get(i + 1).copied().unwrap_or(start + nodes.len());
            let (mine, others) = nodes.split_at_mut(end - start);
            let (my_costs, other_costs) = costs.split_at_mut(end - start);
            (nodes, costs) = (others, other_costs);
            below.push(Subtree {
                nodes: mine,
                costs: my_costs,
                base: self.base + start,
                bounds: Aabb::EMPTY,
            });
        }
        side_by_side(&mut below, &|subtree| subtree.fit(boxes, true));
        let mut below = below.iter();
        (self.bounds, *cost) = fit_node(root, boxes, |_| {
            let subtree = below.next().expect("there is one for each child");
            (subtree.bounds, subtree.costs[0])
        });
    }

    fn fit_single(&mut self, boxes: &[Aabb]) {
        let mut bounds = vec![Aabb::EMPTY; self.nodes.len()];
        for at in (0..self.nodes.len()).rev() {
            let (around, cost) = fit_node(&mut self.nodes[at], boxes, |index| {
                (bounds[index - self.base], self.costs[index - self.base])
            });
            (bounds[at], self.costs[at]) = (around, cost);
        }
        self.bounds = bounds[0];
    }
}

/// All of them, by several threads.
fn side_by_side<T: Send>(all: &mut [T], each: &(impl Fn(&mut T) + Sync)) {
    match all {
        [] => {}
        [one] => each(one),
        _ => {
            let (left, right) = all.split_at_mut(all.len() / 2);
            both(true, || side_by_side(left, each), || side_by_side(right, each));
        }
    }
}

/// The boxes of a node's children, the nodes among which are requested in order; returns the box around all
/// and the cost.
#[inline(always)]
fn fit_node(node: &mut Node8, boxes: &[Aabb], mut below: impl FnMut(usize) -> (Aabb, f32)) -> (Aabb, f32) {
    let mut sum = Sum::NONE;
    for lane in 0..WIDTH {
        let child = node.child(lane);
        if child == Child::NONE {
            continue;
        }
        let (bounds, cost) = if child.is_leaf() {
            match boxes[child.blocks()] {
                [one] => (one, 0.0),
                ref several => (several.iter().fold(Aabb::EMPTY, |all, one| all.union(one)), 0.0),
            }
        } else {
            below(child.index())
        };
        node.set(lane, &bounds, child);
        sum.add(child, &bounds, |_| cost);
    }
    (sum.whole, sum.cost())
}

/// The cost below a node, times half the surface of boxes.
pub(crate) struct Sum {
    steps: f64,
    /// Around all.
    pub(crate) whole: Aabb,
}

impl Sum {
    pub(crate) const NONE: Self = Self { steps: 0.0, whole: Aabb::EMPTY };

    #[inline(always)]
    pub(crate) fn add(&mut self, child: Child, bounds: &Aabb, cost: impl Fn(usize) -> f32) {
        if child == Child::NONE {
            return;
        }
        let steps = if child.is_leaf() { child.blocks().len() as f32 } else { 1.0 + cost(child.index()) };
        self.steps += half_area(bounds) * f64::from(steps);
        for k in 0..3 {
            self.whole.min[k] = least(self.whole.min[k], bounds.min[k]);
            self.whole.max[k] = most(self.whole.max[k], bounds.max[k]);
        }
    }

    /// Where boxes have no surface all of them are met.
    #[inline(always)]
    pub(crate) fn cost(&self) -> f32 {
        let area = half_area(&self.whole);
        if area > 0.0 { (self.steps / area) as f32 } else { 1.0 }
    }
}

/// That of a box which is not empty.
#[inline(always)]
fn half_area(bounds: &Aabb) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(bounds.max[k] - bounds.min[k]));
    x * y + y * z + z * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::build;
    use gnurt_accel_core::{Quality, Threads};
    use gnurt_testkit::Random;

    /// Against the definition: a box is the tightest around its subtree.
    #[test]
    fn boxes_are_tight_and_costs_are_measured() {
        let mut random = Random::new(1);
        let mut boxes = |n: usize| -> Vec<Aabb> {
            (0..n).map(|_| Aabb::around(&[random.point(), random.point()])).collect()
        };
        for n in [1, 8, 9, 500, 3000] {
            let built = build(&&boxes(n)[..], Quality::Medium, Threads::Single).expect("few enough");
            let of_blocks = boxes(built.blocks.len());
            let (mut single, mut joint) = (built.clone(), built.clone());
            let (mut costs, mut same_costs) = (Vec::new(), Vec::new());
            let cost = single.refit(&of_blocks, false, &mut costs);
            joint.refit(&of_blocks, true, &mut same_costs);
            assert_eq!((&single, &costs), (&joint, &same_costs), "threads make no difference to {n}");
            assert_eq!(costs, single.costs(), "costs as they are measured later, {n}");
            let measured = single.measure().sah_cost;
            assert!((cost - measured).abs() < 1e-5 * measured, "{cost} and {measured} of {n}");
            for at in 0..single.count() {
                for lane in 0..WIDTH {
                    let (child, bounds) = single.child(at, lane);
                    assert_eq!(child, built.child(at, lane).0, "what is where stays");
                    let below = match child {
                        Child::NONE => Aabb::EMPTY,
                        leaf if leaf.is_leaf() => of_blocks[leaf.blocks().start],
                        node => (0..WIDTH)
                            .map(|lane| single.child(node.index(), lane).1)
                            .fold(Aabb::EMPTY, |a, b| a.union(&b)),
                    };
                    assert_eq!(bounds, below, "place {lane} of node {at} of {n}");
                }
            }
            let whole = of_blocks.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
            assert_eq!(single.bounds, whole, "around all of {n}");
        }
    }
}
