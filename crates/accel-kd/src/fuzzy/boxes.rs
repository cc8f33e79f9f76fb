// SPDX-License-Identifier: GPL-3.0-or-later
//! Kd-trees over boxes: of triangles that move a little, or of parts.
//! Source: [MB90, WH06] for the cost; all planes of boxes are judged, which are sorted in each node. Space: that of the boxes.
//! Invariant: each leaf lists the boxes that its cell meets. Tests: `tests`.

use gnurt_accel_core::Aabb;

use crate::node::{DEEPEST, EMPTY_LEAF, KdTree, Node};

/// Of a box, where a visit of a node costs 1.
const TEST: f64 = 2.0;

/// What a cell without boxes makes of the cost.
const EMPTY: f64 = 0.8;

/// A box, as far as it is in a cell, and its number.
type Item = (Aabb, u32);

struct Builder {
    nodes: Vec<Node>,
    items: Vec<u32>,
}

/// A tree over numbered boxes, none of which is empty.
pub(super) fn over(boxes: impl Iterator<Item = (Aabb, u32)>) -> KdTree {
    let boxes: Vec<Item> = boxes.collect();
    let bounds = boxes.iter().fold(Aabb::EMPTY, |all, (own, _)| all.union(own));
    let mut builder = Builder { nodes: vec![EMPTY_LEAF], items: vec![0] };
    let deepest = 8 + (1.3 * (boxes.len().max(1) as f64).log2()) as usize;
    builder.node(0, &bounds, boxes, deepest.min(DEEPEST - 2));
    KdTree { nodes: builder.nodes, items: builder.items, bounds }
}

impl Builder {
    fn node(&mut self, at: usize, cell: &Aabb, boxes: Vec<Item>, depth: usize) {
        let Some((axis, plane)) = cheapest(cell, &boxes).filter(|_| depth > 0) else {
            return self.leaf(at, &boxes);
        };
        let [left, right] = cell.split(axis, plane);
        let part = |cell: &Aabb, is_in: &dyn Fn(&Aabb) -> bool| -> Vec<Item> {
            let clipped = |(own, number): &Item| (within(own, cell), *number);
            boxes.iter().filter(|(own, _)| is_in(own)).map(clipped).collect()
        };
        // Flat boxes in the plane are on the left.
        let is_left = |own: &Aabb| own.min[axis] < plane || own.max[axis] <= plane;
        let lefts = part(&left, &is_left);
        let rights = part(&right, &|own| own.max[axis] > plane);
        drop(boxes);
        let first = self.nodes.len();
        self.nodes.extend([EMPTY_LEAF; 2]);
        self.nodes[at] = Node::inner(first as u32, axis, plane);
        self.node(first, &left, lefts, depth - 1);
        self.node(first + 1, &right, rights, depth - 1);
    }

    fn leaf(&mut self, at: usize, boxes: &[Item]) {
        if boxes.is_empty() {
            return;
        }
        self.nodes[at] = Node::leaf(self.items.len() as u32);
        self.items.push(boxes.len() as u32);
        self.items.extend(boxes.iter().map(|(_, number)| *number));
    }
}

fn within(own: &Aabb, cell: &Aabb) -> Aabb {
    Aabb {
        min: [0, 1, 2].map(|k| own.min[k].max(cell.min[k])),
        max: [0, 1, 2].map(|k| own.max[k].min(cell.max[k])),
    }
}

/// The axis and the plane of the least cost, if that is below a leaf's.
fn cheapest(cell: &Aabb, boxes: &[Item]) -> Option<(usize, f32)> {
    let (count, whole) = (boxes.len(), cell.half_area());
    let mut best = None;
    let mut least = TEST * count as f64;
    // A cell without an area has no cheaper parts: their share is not a number.
    for axis in 0..3 {
        let sorted = |of: fn(&Aabb) -> &[f32; 3]| {
            let mut all: Vec<f32> = boxes.iter().map(|(own, _)| of(own)[axis]).collect();
            all.sort_unstable_by(f32::total_cmp);
            all
        };
        let (starts, ends) = (sorted(|own| &own.min), sorted(|own| &own.max));
        let (mut started, mut ended) = (0, 0);
        let mut planes = starts.iter().chain(&ends).copied().collect::<Vec<f32>>();
        planes.sort_unstable_by(f32::total_cmp);
        planes.dedup();
        for plane in planes {
            while started < count && starts[started] < plane {
                started += 1;
            }
            while ended < count && ends[ended] <= plane {
                ended += 1;
            }
            if plane <= cell.min[axis] || plane >= cell.max[axis] {
                continue;
            }
            let [left, right] = cell.split(axis, plane);
            let (lefts, rights) = (started as f64, (count - ended) as f64);
            let tests = (left.half_area() * lefts + right.half_area() * rights) / whole;
            let share = if started == 0 || ended == count { EMPTY } else { 1.0 };
            let cost = share * (1.0 + TEST * tests);
            if cost < least {
                (least, best) = (cost, Some((axis, plane)));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    /// The leaves with their cells.
    fn leaves(tree: &KdTree, at: usize, cell: Aabb, visit: &mut dyn FnMut(Aabb, &[u32])) {
        let node = tree.nodes[at];
        if node.is_leaf() {
            return visit(cell, if node.item() == 0 { &[] } else { tree.leaf_items(node) });
        }
        let [left, right] = cell.split(node.axis(), node.plane());
        leaves(tree, node.left() as usize, left, visit);
        leaves(tree, node.left() as usize + 1, right, visit);
    }

    #[test]
    fn leaves_list_what_they_meet() {
        let mut random = Random::new(4);
        for count in [1, 2, 500] {
            let boxes: Vec<Aabb> = (0..count)
                .map(|i| {
                    let from = [random.unit(), random.unit(), random.unit()];
                    // Points and flat boxes, too.
                    let size = [0.0, 0.05, 0.1][i % 3];
                    let to = [0, 1, 2].map(|k| from[k] + if k == i % 2 { 0.0 } else { size * random.unit() });
                    Aabb { min: from, max: to }
                })
                .collect();
            let tree = over(boxes.iter().copied().zip(0..));
            let mut listed = 0;
            leaves(&tree, 0, tree.bounds, &mut |cell, numbers| {
                listed += numbers.len();
                for (number, own) in boxes.iter().enumerate() {
                    // Planes are rounded to their axis.
                    let overlaps =
                        (0..3).all(|k| own.min[k] < cell.max[k] - 1e-5 && own.max[k] > cell.min[k] + 1e-5);
                    assert!(
                        !overlaps || numbers.contains(&(number as u32)),
                        "{number} of {count}: {own:?} in {cell:?}"
                    );
                }
            });
            assert!(listed >= count && listed < 20 * count, "{listed} for {count}");
        }
        assert!(over(std::iter::empty()).nodes[0].is_leaf(), "nothing is an empty leaf");
    }
}
