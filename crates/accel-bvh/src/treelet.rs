// SPDX-License-Identifier: GPL-3.0-or-later
//! A wide BVH over boxes in one piece of memory, which its copies share: the part of a top tree that an edit
//! rebuilds.
//! Source: [WBB08] for the nodes, [WBS06] for the refit. Leaf blocks are eight boxes again, with the numbers
//! of members as children, and follow the nodes; children come after their parents, so that one pass from the
//! end refits. If members move during an open shutter, boxes enclose their whole paths, and `keys.rs` has
//! those at single times.
//! Space: that of the boxes. Invariant: a box of a node is the smallest around its subtree, or empty.
//! Tests: `tests`, `boxes::update::tests`.

mod fit;
mod keys;

use std::sync::Arc;

use gnurt_accel_core::{Aabb, INVALID_ID};

use crate::node::{Child, Node8, WIDTH};
use crate::tree::Tree;
use fit::{below, refit};

pub use keys::BoxesAt;
pub(crate) use keys::NodesAtKeys;

/// Nodes, then blocks.
#[derive(Clone, Debug)]
pub(crate) struct Treelet {
    nodes: Arc<[Node8]>,
    first_block: usize,
    /// The same at times of an open shutter, if members move.
    at_keys: Option<Arc<NodesAtKeys>>,
    /// Half the surfaces of all boxes of nodes together: the expected visits of a ray, times half of the
    /// whole's surface.
    areas: f64,
    /// The expected visits of a ray that hits the whole, at the build.
    built_cost: f64,
}

impl Default for Treelet {
    /// Without members.
    fn default() -> Self {
        Self { nodes: Arc::new([]), first_block: 0, at_keys: None, areas: 0.0, built_cost: 0.0 }
    }
}

/// Nodes lie less deep than this in a treelet that `build::parts` makes: it divides by number from half of it on.
pub(crate) const DEEPEST_TREELET: usize = 32;

/// A tree that costs this much more than when it was built is worth another one.
const WORN: f64 = 1.3;

impl Treelet {
    /// From a tree whose numbers represent these members and their boxes.
    pub(crate) fn new(tree: &Tree, member: impl Fn(u32) -> (u32, Aabb)) -> Self {
        let first_block = tree.nodes.len();
        let behind_nodes = |node: &Node8| {
            let mut node = *node;
            node.move_children(0, first_block);
            node
        };
        let block = |numbers: &[u32; WIDTH]| {
            let mut block = Node8::EMPTY;
            for (lane, &number) in numbers.iter().enumerate().filter(|&(_, &number)| number != INVALID_ID) {
                let (member, bounds) = member(number);
                block.set(lane, &bounds, Child::node(member as usize));
            }
            block
        };
        let nodes = tree.nodes.iter().map(behind_nodes).chain(tree.blocks.iter().map(block)).collect();
        let mut treelet = Self { nodes, first_block, at_keys: None, areas: 0.0, built_cost: 0.0 };
        treelet.areas = treelet.measure();
        treelet.built_cost = treelet.cost();
        treelet
    }

    /// The same with moving members; boxes must enclose their whole paths. Edits drop it.
    pub(crate) fn moving(self, boxes_at: impl Fn(usize) -> Option<Vec<Aabb>>) -> Self {
        let at_keys = NodesAtKeys::new(&self.nodes, self.first_block, boxes_at).map(Arc::new);
        Self { at_keys, ..self }
    }

    /// The nodes at times of an open shutter, if members move.
    #[inline(always)]
    pub(crate) fn at_keys(&self) -> Option<&NodesAtKeys> {
        self.at_keys.as_deref()
    }

    /// All nodes and blocks; a child of a node is an index among them.
    #[inline(always)]
    pub(crate) fn nodes(&self) -> &[Node8] {
        &self.nodes
    }

    /// How many of them are nodes.
    pub(crate) fn node_count(&self) -> usize {
        self.first_block
    }

    /// Box around all members.
    pub(crate) fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, Node8::whole)
    }

    /// Of nodes and blocks.
    pub(crate) fn memory_bytes(&self) -> usize {
        let keys = self.at_keys.as_ref().map_or(0, |keys| keys.memory_bytes());
        size_of::<Self>() + size_of_val(&self.nodes[..]) + keys
    }

    /// See the field.
    pub(crate) fn areas(&self) -> f64 {
        self.areas
    }

    /// The expected visits of a ray that hits the whole.
    fn cost(&self) -> f64 {
        let whole = self.bounds().half_area();
        if whole > 0.0 { self.areas / whole } else { 0.0 }
    }

    /// Whether edits have degraded it enough to make a rebuild worthwhile.
    pub(crate) fn is_worn(&self) -> bool {
        self.cost() > WORN * self.built_cost
    }

    fn measure(&self) -> f64 {
        let boxes = self.nodes[..self.first_block].iter().flat_map(|node| (0..WIDTH).map(|i| node.bounds(i)));
        boxes.map(|bounds| bounds.half_area()).sum()
    }

    /// All members and their boxes.
    pub(crate) fn members(&self) -> impl Iterator<Item = (u32, Aabb)> {
        let lanes =
            self.nodes[self.first_block..].iter().flat_map(|block| (0..WIDTH).map(move |i| (block, i)));
        let taken = lanes.filter(|(block, lane)| block.child(*lane) != Child::NONE);
        taken.map(|(block, lane)| (block.child(lane).index() as u32, block.bounds(lane)))
    }

    /// Nodes on the longest path down.
    pub(crate) fn depth(&self) -> u32 {
        let mut depths = vec![1; self.nodes.len()];
        for at in 0..self.first_block {
            let depth = depths[at] + 1;
            below(&self.nodes[at]).for_each(|(_, child)| depths[child] = depth);
        }
        depths.into_iter().max().unwrap_or(0)
    }

    /// The same with some members' boxes changed, taken out (`None`) or put in; `edits` ascend by member.
    /// `None` if there is no space for added ones.
    pub(crate) fn edited(&self, edits: &[(u32, Option<Aabb>)]) -> Option<Self> {
        let mut all: Arc<[Node8]> = Arc::from(&*self.nodes);
        let nodes = Arc::get_mut(&mut all)?;
        let mut known = 0;
        for block in &mut nodes[self.first_block..] {
            for lane in 0..WIDTH {
                let child = block.child(lane);
                if child == Child::NONE {
                    continue;
                }
                if let Ok(at) = edits.binary_search_by_key(&(child.index() as u32), |edit| edit.0) {
                    known += 1;
                    match edits[at].1 {
                        Some(bounds) => block.set(lane, &bounds, child),
                        None => block.set(lane, &Aabb::EMPTY, Child::NONE),
                    }
                }
            }
        }
        if known < edits.len() {
            for (member, bounds) in self.strangers(edits) {
                let child = Child::node(member as usize);
                let block = best_block(&mut nodes[self.first_block..], &bounds)?;
                let free = (0..WIDTH).find(|&lane| block.child(lane) == Child::NONE)?;
                block.set(free, &bounds, child);
            }
        }
        refit(nodes, self.first_block);
        let mut treelet = Self { nodes: all, at_keys: None, ..*self };
        treelet.areas = treelet.measure();
        Some(treelet)
    }

    /// The members to be, with their boxes, where edits ascend by member.
    pub(crate) fn members_after(&self, edits: &[(u32, Option<Aabb>)]) -> Vec<(u32, Aabb)> {
        let edit = |member: u32| edits.binary_search_by_key(&member, |edit| edit.0).ok();
        let stay = self.members().filter_map(|(member, bounds)| match edit(member) {
            Some(at) => edits[at].1.map(|bounds| (member, bounds)),
            None => Some((member, bounds)),
        });
        stay.chain(self.strangers(edits)).collect()
    }

    /// Those of `edits` that are no members yet and have a box.
    fn strangers(&self, edits: &[(u32, Option<Aabb>)]) -> Vec<(u32, Aabb)> {
        let mut known = vec![false; edits.len()];
        for (member, _) in self.members() {
            if let Ok(at) = edits.binary_search_by_key(&member, |edit| edit.0) {
                known[at] = true;
            }
        }
        let strange = edits.iter().zip(known).filter(|(_, known)| !known);
        strange.filter_map(|(&(member, bounds), _)| Some((member, bounds?))).collect()
    }

    /// The member whose box grows least when it takes another one in: node by node the child that does. There are members.
    pub(crate) fn best_member(&self, bounds: &Aabb) -> u32 {
        let mut at = 0;
        loop {
            let node = &self.nodes[at];
            let children = (0..WIDTH).filter(|&lane| node.child(lane) != Child::NONE);
            let growth = |&lane: &usize| growth(&node.bounds(lane), bounds);
            let best = children.min_by(|a, b| growth(a).total_cmp(&growth(b)));
            let child = best.map_or(Child::NONE, |lane| node.child(lane));
            if at >= self.first_block {
                return child.0;
            }
            at = if child.is_leaf() { child.blocks().start } else { child.index() };
        }
    }
}

/// How much more surface one box has with another.
pub(crate) fn growth(bounds: &Aabb, other: &Aabb) -> f64 {
    bounds.union(other).half_area() - bounds.half_area()
}

/// The block with space whose box grows least.
fn best_block<'a>(blocks: &'a mut [Node8], bounds: &Aabb) -> Option<&'a mut Node8> {
    let has_space = |block: &&mut Node8| (0..WIDTH).any(|lane| block.child(lane) == Child::NONE);
    let growth = |block: &Node8| growth(&block.whole(), bounds);
    blocks.iter_mut().filter(has_space).min_by(|a, b| growth(a).total_cmp(&growth(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::build;
    use gnurt_accel_core::{Quality, Threads};

    fn boxes(count: usize, seed: u64) -> Vec<Aabb> {
        let mut random = gnurt_testkit::Random::new(seed);
        (0..count).map(|_| Aabb::around(&[random.point(), random.point()])).collect()
    }

    fn treelet(boxes: &[Aabb]) -> Treelet {
        let tree = build(&boxes, Quality::Medium, Threads::Single).expect("a few boxes");
        Treelet::new(&tree, |number| (10 * number, boxes[number as usize]))
    }

    fn sorted(members: impl Iterator<Item = (u32, Aabb)>) -> Vec<(u32, Aabb)> {
        let mut members: Vec<(u32, Aabb)> = members.collect();
        members.sort_by_key(|(member, _)| *member);
        members
    }

    /// Every box of a node is the smallest around its subtree.
    fn assert_fits(treelet: &Treelet) {
        for (at, node) in treelet.nodes[..treelet.first_block].iter().enumerate() {
            for (lane, child) in below(node) {
                assert!(child > at, "children come after their parents");
                assert_eq!(node.bounds(lane), treelet.nodes[child].whole(), "node {at}, lane {lane}");
            }
        }
    }

    #[test]
    fn edits_leave_what_they_say() {
        for count in [1, 7, 8, 9, 100] {
            let boxes = boxes(count, count as u64);
            let before = treelet(&boxes);
            assert_fits(&before);
            let other = Aabb { min: [5.0; 3], max: [6.0; 3] };
            let edits = [(0, Some(other)), (10, None), (11, None), (15, Some(boxes[0]))];
            let Some(after) = before.edited(&edits) else {
                assert!(count % WIDTH == 0, "there is room among {count}");
                continue;
            };
            assert_fits(&after);
            let all = boxes.iter().enumerate().map(|(i, bounds)| (10 * i as u32, *bounds));
            let mut expected: Vec<(u32, Aabb)> = all.filter(|(member, _)| *member != 10).collect();
            expected[0].1 = other;
            expected.push((15, boxes[0]));
            let expected = sorted(expected.into_iter());
            assert_eq!(sorted(after.members()), expected, "of {count}");
            assert_eq!(sorted(before.members_after(&edits).into_iter()), expected, "the same as a list");
            assert_eq!(before.members().count(), count, "the one before stays");
            let whole = expected.iter().fold(Aabb::EMPTY, |all, (_, bounds)| all.union(bounds));
            assert_eq!(after.bounds(), whole, "around all");
        }
    }

    #[test]
    fn full_and_empty_ones() {
        let full = treelet(&boxes(8, 1));
        let one_more = [(3, Some(Aabb { min: [0.0; 3], max: [1.0; 3] }))];
        assert!(full.edited(&one_more).is_none(), "no room");
        assert_eq!(full.members_after(&one_more).len(), 9, "but nine members");
        let all: Vec<(u32, Option<Aabb>)> = full.members().map(|(member, _)| (member, None)).collect();
        let mut all = all;
        all.sort_by_key(|(member, _)| *member);
        let empty = full.edited(&all).expect("nothing comes");
        assert!(empty.bounds().is_empty() && empty.members().count() == 0, "nothing is left");
        let again = empty.edited(&one_more).expect("much room");
        assert_eq!(again.members().count(), 1, "it can be filled again");
        assert_fits(&again);
    }

    #[test]
    fn wears_out() {
        let boxes = boxes(100, 3);
        let small: Vec<Aabb> =
            boxes.iter().map(|b| Aabb { min: b.min, max: b.min.map(|x| x + 0.01) }).collect();
        let fresh = treelet(&small);
        assert!(!fresh.is_worn(), "as it was built");
        let moved: Vec<(u32, Option<Aabb>)> =
            (0..100).map(|i| (10 * i as u32, Some(small[(i * 37 + 11) % 100]))).collect();
        let worn = fresh.edited(&moved).expect("nobody comes");
        assert!(worn.is_worn(), "{} after {}", worn.cost(), fresh.cost());
    }

    #[test]
    fn finds_where_to_grow() {
        let boxes = boxes(300, 4);
        let small: Vec<Aabb> =
            boxes.iter().map(|b| Aabb { min: b.min, max: b.min.map(|x| x + 0.01) }).collect();
        let treelet = treelet(&small);
        let found = (0..300).filter(|&i| treelet.best_member(&small[i]) == 10 * i as u32).count();
        assert!(found > 200, "most boxes find themselves, {found} of 300");
    }
}
