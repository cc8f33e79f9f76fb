// SPDX-License-Identifier: GPL-3.0-or-later
//! From a point to the nearest triangle under a kd-tree: the nearer child first, cells beyond the best are skipped.
//! Source: [Ben75] for the search; cells are kept whole, so their distance is exact. Space: object.
//! Invariant: the nearest point lies in a cell whose leaf lists its triangle, and cells are enlarged by the
//! possible rounding error of their sides (the planes' two lowest bits, clipped boxes). Tests:
//! `tests/closest_point.rs`.

use crate::node::{KdTree, Node};
use gnurt_accel_core::Aabb;

/// Sides of cells are right up to this share of the greatest coordinate: 5 units of 2^-24 (`slab.rs`), twice.
const SLACK: f64 = 6e-7;

impl KdTree {
    /// Calls `visit` with the leaves within `reach`; it answers with the new reach. The tree is not empty.
    pub(crate) fn near(&self, point: &[f64; 3], mut reach: f64, mut visit: impl FnMut(Node) -> f64) {
        let slack = SLACK * f64::from(self.bounds.greatest());
        let distance = |cell: &Aabb| {
            let outside = |k: usize| {
                let (low, high) = (f64::from(cell.min[k]), f64::from(cell.max[k]));
                (low - slack - point[k]).max(point[k] - high - slack).max(0.0)
            };
            let [x, y, z] = [outside(0), outside(1), outside(2)];
            (x * x + y * y + z * z).sqrt()
        };
        let mut waiting = vec![(0, self.bounds)];
        while let Some((at, cell)) = waiting.pop() {
            if distance(&cell) > reach {
                continue;
            }
            let node = self.nodes[at as usize];
            if node.is_leaf() {
                reach = visit(node);
                continue;
            }
            let [left, right] = cell.split(node.axis(), node.plane());
            let children = [(node.left(), left), (node.left() + 1, right)];
            let right_first = point[node.axis()] > f64::from(node.plane());
            let [near, far] = if right_first { [children[1], children[0]] } else { children };
            waiting.push(far);
            waiting.push(near);
        }
    }
}
