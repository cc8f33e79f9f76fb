// SPDX-License-Identifier: GPL-3.0-or-later
//! Shares triangles out: a binary tree of boxes whose leaves hold at most eight.
//! Source: [WK06] section 3 for halving space, which looks at no triangle but to see where its middle lies; [MB90] for the
//! surface area heuristic over bins, as for BVHs. Space: object. Cost: O(n log n).
//! Invariant: no leaf has more than [`DEEPEST`] splits above it; threads make no difference. Tests: `tests`.

use gnurt_accel_core::control::Watch;
use gnurt_accel_core::{Aabb, BuildError};

use super::walk::DEEPEST;

/// Most triangles of a leaf.
pub(super) const LEAF: usize = gnurt_accel_core::blocks::WIDTH;

/// A triangle that is to be put somewhere.
#[derive(Clone, Copy)]
pub(super) struct Reference {
    pub(super) bounds: Aabb,
    pub(super) number: u32,
}

impl Reference {
    /// Twice its middle, which is exact enough and needs no product.
    fn middle(&self, axis: usize) -> f32 {
        self.bounds.min[axis] + self.bounds.max[axis]
    }
}

/// Boxes in boxes.
pub(super) enum Binary {
    Leaf { bounds: Aabb, numbers: Vec<u32> },
    Split { bounds: Aabb, axis: usize, children: Box<[Binary; 2]>, cost: f32 },
}

/// How triangles are shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Space is halved, for any contents.
    Halves,
    /// Where a ray is expected to do least.
    Cost,
}

/// The cost of a block, in steps through nodes.
pub(super) const BLOCK: f32 = 2.0;

/// From this depth on triangles are shared out in equal parts, which ends soon: there are fewer than 2^30.
const DEEP: usize = DEEPEST - 32;

/// Bins along each axis.
const BINS: usize = 24;

/// This many triangles are worth a task of their own.
const PIECE: usize = 1 << 12;

impl Binary {
    /// Over triangles, one or more.
    pub(super) fn build(
        references: &mut [Reference],
        rule: Rule,
        parallel: bool,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let bounds = around(references);
        Sharing { rule, parallel, watch }.below(references, bounds, bounds, 0)
    }

    pub(super) fn bounds(&self) -> &Aabb {
        match self {
            Self::Leaf { bounds, .. } | Self::Split { bounds, .. } => bounds,
        }
    }

    /// The expected cost of a ray that hits its box, in steps through nodes.
    pub(super) fn cost(&self) -> f32 {
        match self {
            Self::Leaf { .. } => BLOCK,
            Self::Split { cost, .. } => *cost,
        }
    }
}

struct Sharing<'a, 'b> {
    rule: Rule,
    parallel: bool,
    watch: &'a Watch<'b>,
}

impl Sharing<'_, '_> {
    /// A subtree over all of `references`, which are in `bounds`, with their centres in `cell`.
    fn below(
        &self,
        references: &mut [Reference],
        bounds: Aabb,
        cell: Aabb,
        depth: usize,
    ) -> Result<Binary, BuildError> {
        let count = references.len();
        let found = match self.rule {
            _ if depth >= DEEP => None,
            Rule::Halves if count > LEAF => halve(references, cell),
            Rule::Halves => None,
            Rule::Cost => cheapest(references, &bounds),
        };
        if count <= LEAF && found.is_none() {
            let numbers = references.iter().map(|reference| reference.number).collect();
            return Ok(Binary::Leaf { bounds, numbers });
        }
        let (axis, at, cells) = found.unwrap_or_else(|| equal_parts(references, &bounds, cell));
        let (left, right) = references.split_at_mut(at);
        let boxes = [around(left), around(right)];
        let (a, b) = if count > PIECE {
            self.watch.result()?;
            let mut left = || self.below(left, boxes[0], cells[0], depth + 1);
            let mut right = || self.below(right, boxes[1], cells[1], depth + 1);
            if self.parallel { rayon::join(left, right) } else { (left(), right()) }
        } else {
            (
                self.below(left, boxes[0], cells[0], depth + 1),
                self.below(right, boxes[1], cells[1], depth + 1),
            )
        };
        let children = Box::new([a?, b?]);
        let (area, mut cost) = (bounds.half_area() as f32, 1.0);
        for child in children.iter() {
            let share = if area > 0.0 { child.bounds().half_area() as f32 / area } else { 1.0 };
            cost += share.min(1.0) * child.cost();
        }
        Ok(Binary::Split { bounds, axis, children, cost })
    }
}

pub(super) fn around(references: &[Reference]) -> Aabb {
    references.iter().fold(Aabb::EMPTY, |all, reference| all.union(&reference.bounds))
}

/// An axis, how many triangles come to the left, and the cells of both sides.
type Shared = (usize, usize, [Aabb; 2]);

fn longest(bounds: &Aabb) -> usize {
    let [x, y, z] = bounds.extent();
    if x >= y && x >= z { 0 } else { usize::from(z > y) + 1 }
}

/// Puts those for which it is so first; how many these are.
fn partition(references: &mut [Reference], is_left: impl Fn(&Reference) -> bool) -> usize {
    let mut left = 0;
    for i in 0..references.len() {
        if is_left(&references[i]) {
            references.swap(i, left);
            left += 1;
        }
    }
    left
}

/// In the middle of the cell, along its longest side; if one side is empty, the other is halved again. `None`
/// if the centres are too close to each other.
fn halve(references: &mut [Reference], mut cell: Aabb) -> Option<Shared> {
    for _ in 0..3 * 64 {
        let axis = longest(&cell);
        let plane = 0.5 * cell.min[axis] + 0.5 * cell.max[axis];
        if !(plane > cell.min[axis] && plane < cell.max[axis]) {
            return None;
        }
        let at = partition(references, |reference| 0.5 * reference.middle(axis) <= plane);
        let cells = cell.split(axis, plane);
        if at != 0 && at != references.len() {
            return Some((axis, at, cells));
        }
        cell = cells[usize::from(at == 0)];
    }
    None
}

/// By half of their number, along the axis along which they reach farthest.
fn equal_parts(references: &mut [Reference], bounds: &Aabb, cell: Aabb) -> Shared {
    let (axis, half) = (longest(bounds), references.len() / 2);
    let key = |r: &Reference| r.middle(axis);
    references.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.number.cmp(&b.number)));
    (axis, half, [cell; 2])
}

/// At the least expected cost by the surface area heuristic; `None` if a leaf costs the same, or centres
/// coincide.
fn cheapest(references: &mut [Reference], bounds: &Aabb) -> Option<Shared> {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for reference in references.iter() {
        for k in 0..3 {
            low[k] = low[k].min(reference.middle(k));
            high[k] = high[k].max(reference.middle(k));
        }
    }
    let mut best: Option<(f64, usize, usize)> = None;
    let bin_of = |reference: &Reference, axis: usize| {
        let share = (reference.middle(axis) - low[axis]) / (high[axis] - low[axis]);
        ((share * BINS as f32) as usize).min(BINS - 1)
    };
    for axis in (0..3).filter(|&k| high[k] > low[k]) {
        let mut bins = [(Aabb::EMPTY, 0); BINS];
        for reference in references.iter() {
            let bin = &mut bins[bin_of(reference, axis)];
            *bin = (bin.0.union(&reference.bounds), bin.1 + 1);
        }
        let mut right = [(0.0, 0); BINS];
        let (mut all, mut count) = (Aabb::EMPTY, 0);
        for i in (1..BINS).rev() {
            (all, count) = (all.union(&bins[i].0), count + bins[i].1);
            right[i] = (if count > 0 { all.half_area() } else { 0.0 }, count);
        }
        (all, count) = (Aabb::EMPTY, 0);
        for i in 1..BINS {
            (all, count) = (all.union(&bins[i - 1].0), count + bins[i - 1].1);
            let (right_area, right_count) = right[i];
            if count == 0 || right_count == 0 {
                continue;
            }
            let cost = all.half_area() * blocks(count) + right_area * blocks(right_count);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, i));
            }
        }
    }
    let (cost, axis, bin) = best?;
    let area = bounds.half_area();
    if references.len() <= LEAF && area + f64::from(BLOCK) * cost >= f64::from(BLOCK) * area {
        return None;
    }
    let at = partition(references, |reference| bin_of(reference, axis) < bin);
    Some((axis, at, [*bounds; 2]))
}

/// Expected blocks of this many triangles: none is full.
fn blocks(count: usize) -> f64 {
    (count as f64 / 6.0).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    fn check(tree: &Binary, depth: usize, found: &mut Vec<u32>) {
        assert!(depth <= DEEPEST, "too deep");
        match tree {
            Binary::Leaf { numbers, .. } => {
                assert!((1..=LEAF).contains(&numbers.len()), "{} in a leaf", numbers.len());
                found.extend(numbers);
            }
            Binary::Split { bounds, children, .. } => {
                let [a, b] = &**children;
                assert_eq!(*bounds, a.bounds().union(b.bounds()), "a box holds its children's, no more");
                children.iter().for_each(|child| check(child, depth + 1, found));
            }
        }
    }

    #[test]
    fn each_triangle_lies_in_one_leaf() {
        let mut random = Random::new(1);
        let mut boxes = |n: usize, size: f32| -> Vec<Aabb> {
            let mut one = || {
                let p = random.point();
                let q = random.point();
                Aabb::around(&[p, [0, 1, 2].map(|k| p[k] + size * q[k])])
            };
            (0..n).map(|_| one()).collect()
        };
        let same = vec![boxes(1, 1.0)[0]; 500];
        // Each half as far from the origin as its predecessor: halving takes them one by one.
        let row: Vec<Aabb> = (0..120).map(|i| Aabb::around(&[[0.5f32.powi(i), 0.0, 0.0]])).collect();
        for all in [boxes(1, 0.1), boxes(9, 1.0), boxes(3000, 0.05), same, row] {
            for rule in [Rule::Halves, Rule::Cost] {
                let references = (0..).zip(&all).map(|(number, &bounds)| Reference { bounds, number });
                let mut references: Vec<Reference> = references.collect();
                let tree =
                    Binary::build(&mut references, rule, false, &Watch::new(&())).expect("nobody stops it");
                let mut found = Vec::new();
                check(&tree, 0, &mut found);
                found.sort_unstable();
                assert!(found.iter().copied().eq(0..all.len() as u32), "{rule:?} of {}", all.len());
            }
        }
    }
}
