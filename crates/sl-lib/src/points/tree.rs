// SPDX-License-Identifier: GPL-3.0-or-later
//! A k-d tree over points: their numbers in an order in which each range's middle splits it.
//! Source: Bentley, "Multidimensional binary search trees used for associative searching", CACM 18 (1975); original.
//! The axis of a range is its depth modulo three, so that only the order is stored.
//! Tests: `tests/points.rs`, against all points one by one.

use std::collections::BinaryHeap;

/// Points of a range that is not split any more.
const LEAF: usize = 8;

/// A point that was found, and how far away it is.
pub type Found = (u32, f32);

/// Numbers of points, ordered.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    order: Vec<u32>,
}

/// A candidate: squared distance, then number; both count.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Near(f32, u32);

impl Eq for Near {}

impl PartialOrd for Near {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Near {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

struct Search<'a> {
    positions: &'a [[f32; 3]],
    center: [f32; 3],
    most: usize,
    /// Squared.
    radius: f32,
    /// The farthest is on top.
    best: BinaryHeap<Near>,
}

impl Search<'_> {
    /// Squared distance of the farthest point to accept.
    fn reach(&self) -> f32 {
        match self.best.peek() {
            Some(worst) if self.best.len() == self.most => worst.0,
            _ => self.radius,
        }
    }

    fn visit(&mut self, order: &[u32], axis: usize) {
        if order.len() <= LEAF {
            order.iter().for_each(|&number| self.visit_node(number));
            return;
        }
        let middle = order.len() / 2;
        let gap = self.center[axis] - self.positions[order[middle] as usize][axis];
        let (low, high) = (&order[..middle], &order[middle + 1..]);
        let (near, far) = if gap < 0.0 { (low, high) } else { (high, low) };
        let next = (axis + 1) % 3;
        self.visit(near, next);
        self.visit_node(order[middle]);
        if gap * gap <= self.reach() {
            self.visit(far, next);
        }
    }

    fn visit_node(&mut self, number: u32) {
        let position = self.positions[number as usize];
        let squared: f32 =
            (0..3).map(|k| (position[k] - self.center[k]) * (position[k] - self.center[k])).sum();
        if squared > self.radius {
            return;
        }
        self.best.push(Near(squared, number));
        if self.best.len() > self.most {
            self.best.pop();
        }
    }
}

impl Tree {
    pub(super) fn new(positions: &[[f32; 3]]) -> Self {
        let is_number = |&number: &u32| positions[number as usize].iter().all(|x| x.is_finite());
        let mut order: Vec<u32> = (0..positions.len() as u32).filter(is_number).collect();
        split(positions, &mut order, 0);
        Self { order }
    }

    pub(super) fn nearest(
        &self,
        positions: &[[f32; 3]],
        center: [f32; 3],
        radius: f32,
        most: usize,
    ) -> Vec<Found> {
        if most == 0 || radius.is_nan() || radius < 0.0 || center.iter().any(|x| !x.is_finite()) {
            return Vec::new();
        }
        let best = BinaryHeap::new();
        let mut search = Search { positions, center, most, radius: radius * radius, best };
        search.visit(&self.order, 0);
        let sorted = search.best.into_sorted_vec();
        sorted.into_iter().map(|Near(squared, number)| (number, squared.sqrt())).collect()
    }
}

/// Sorts the median of the range into the middle, smaller ones before it, and continues in both halves.
fn split(positions: &[[f32; 3]], order: &mut [u32], axis: usize) {
    if order.len() <= LEAF {
        return;
    }
    let middle = order.len() / 2;
    let position = |number: u32| positions[number as usize][axis];
    order.select_nth_unstable_by(middle, |&a, &b| position(a).total_cmp(&position(b)).then(a.cmp(&b)));
    let (low, high) = order.split_at_mut(middle);
    split(positions, low, (axis + 1) % 3);
    split(positions, &mut high[1..], (axis + 1) % 3);
}
