// SPDX-License-Identifier: GPL-3.0-or-later
//! SAH kd-tree construction by sweeping sorted plane events, in O(n log n).
//! Source: [WH06] section 4.3; greedy cost [MB90]. Differs: triangles are renumbered in every node, so that
//! events stay 8 bytes, the classification array stays as small as the node, and subtrees share nothing. In:
//! screened triangles, object space. Out: [`KdTree`]; children of a node are adjacent, followed by the left
//! subtree, then the right one, independent of threads. Cost: events are sorted once; a node's are filtered
//! and merged. At most two generations of a path are alive.
//! Invariant: the tree does not depend on the threads; its leaves hold at most `reference_budget` times n
//! references, distributed to subtrees by their size. Tests: `tests/kd_build.rs`.

use gnurt_simd::{Level, dispatch_two};
use rayon::prelude::*;

use crate::builder::{Builder, Cell, Subtree, WORTH_A_THREAD};
use crate::divide::{Overlap, Scratch, Start};
use crate::event::{Event, push_events};
use crate::node::{DEEPEST, KdTree};
use crate::sah::{Costs, Plane, best_across, cheapest};
use crate::sampled::BoxRef;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::valid_triangles::ValidTriangles;
use gnurt_accel_core::{Aabb, BuildError, BuildOptions, Quality, Threads};

/// In nodes of more triangles than this each axis is worth a thread.
const WORTH_THREE_THREADS: usize = 65_536;

impl KdTree {
    /// Builds over the good triangles of `valid_triangles`.
    ///
    /// The tree's memory stays counted.
    pub(crate) fn build(
        valid_triangles: &ValidTriangles,
        options: &BuildOptions,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let costs = Costs {
            triangle: f64::from(options.triangle_cost.max(0.0)),
            empty_factor: f64::from(options.empty_factor.clamp(0.0, 1.0)),
        };
        let max_depth = (options.max_depth as usize).min(DEEPEST - 1);
        threads.run(|parallel| {
            Builder { valid_triangles, costs, max_depth, parallel, level: Level::best(), watch }.run(options)
        })
    }
}

impl Builder<'_> {
    fn run(&self, options: &BuildOptions) -> Result<KdTree, BuildError> {
        let n = self.valid_triangles.good.len();
        let budget = (f64::from(options.reference_budget.max(1.0)) * n as f64) as usize;
        let bounds = self.valid_triangles.bounds;
        let (mut tree, mut held) = (Subtree::new(), 0);
        if n > 0 {
            let cell = Cell { bounds, depth: 0, budget, small: n < WORTH_A_THREAD };
            self.watch.start(budget);
            let each = match options.quality {
                Quality::Fast => size_of::<BoxRef>(),
                _ => 6 * size_of::<Event>() + size_of::<u32>(),
            };
            self.watch.recount(&mut held, each * n);
            self.watch.result()?;
            if options.quality == Quality::Fast {
                self.grow_sampled(self.root_boxes(), cell, &mut tree, 0);
            } else {
                let overlap =
                    Overlap { events: self.root_events(), prims: self.valid_triangles.good.clone() };
                self.grow_wide(overlap, cell, &mut tree, 0);
            }
        }
        self.watch.result()?;
        self.watch.recount(&mut held, 0);
        self.watch.grown();
        tree.nodes.shrink_to_fit();
        tree.items.shrink_to_fit();
        self.watch.take(tree.memory_bytes());
        Ok(KdTree { nodes: tree.nodes, items: tree.items, bounds })
    }

    /// All triangles' boxes.
    fn root_boxes(&self) -> Vec<BoxRef> {
        let one = |&number: &u32| BoxRef::new(&Aabb::around(&self.valid_triangles.corners(number)), number);
        if self.parallel {
            self.valid_triangles.good.par_iter().map(one).collect()
        } else {
            self.valid_triangles.good.iter().map(one).collect()
        }
    }

    /// All triangles' events, sorted.
    fn root_events(&self) -> [Vec<Event>; 3] {
        let sorted = |axis: usize| {
            let mut events = Vec::with_capacity(2 * self.valid_triangles.good.len());
            for (i, &number) in self.valid_triangles.good.iter().enumerate() {
                push_events(
                    &mut events,
                    &Aabb::around(&self.valid_triangles.corners(number)),
                    axis,
                    i as u32,
                );
            }
            if self.parallel {
                events.par_sort_unstable()
            } else {
                events.sort_unstable()
            }
            events
        };
        let (x, (y, z)) = self.both(|| sorted(0), || self.both(|| sorted(1), || sorted(2)));
        [x, y, z]
    }

    /// Builds a node and its subtree into `slot` of `tree`, by several threads if it is large enough.
    fn grow_wide(&self, mut overlap: Overlap, cell: Cell, tree: &mut Subtree, slot: usize) {
        let mut scratch = Scratch::default();
        if !self.parallel || overlap.prims.len() < WORTH_A_THREAD {
            let before = overlap.memory_bytes();
            tree.counted = before;
            self.grow(&mut overlap, Start::default(), cell, &mut scratch, tree, slot);
            self.watch.recount(&mut tree.counted, before);
            return;
        }
        let Some((plane, [left, right])) = self.step(&mut overlap, Start::default(), cell, &mut scratch)
        else {
            return tree.set_leaf(slot, overlap.prims.iter().copied());
        };
        let first = tree.set_inner(slot, &plane);
        let lefts = scratch.into_left();
        let aside = lefts.memory_bytes();
        self.watch.take(aside);
        let split_off = |overlap: Overlap, child: Cell| {
            let mut split_off = Subtree::new();
            self.grow_wide(overlap, child, &mut split_off, 0);
            self.grown(&cell, &child, &split_off);
            split_off
        };
        let on_left = || {
            let grown = split_off(lefts, left);
            self.watch.give(aside);
            grown
        };
        let (left, right) = rayon::join(on_left, || split_off(overlap, right));
        tree.attach(first, left);
        tree.attach(first + 1, right);
    }

    /// Builds a node over the elements behind `start` in `overlap` into `slot` of `tree`, and appends its
    /// subtree. Only elements before `start` stay in `overlap`.
    fn grow(
        &self,
        overlap: &mut Overlap,
        start: Start,
        cell: Cell,
        scratch: &mut Scratch,
        tree: &mut Subtree,
        slot: usize,
    ) {
        match self.step(overlap, start, cell, scratch) {
            None => tree.set_leaf(slot, overlap.prims[start.prims..].iter().copied()),
            Some((plane, [left, right])) => {
                let first = tree.set_inner(slot, &plane);
                let behind = overlap.end();
                overlap.append_left(scratch);
                if !cell.small {
                    let now = overlap.memory_bytes() + scratch.memory_bytes() + tree.memory_bytes();
                    self.watch.recount(&mut tree.counted, now);
                }
                self.grow(overlap, behind, left, scratch, tree, first);
                self.advance(&cell, &left);
                self.grow(overlap, start, right, scratch, tree, first + 1);
                self.advance(&cell, &right);
            }
        }
        overlap.truncate(start);
    }

    /// Divides the elements behind `start`: the right child's triangles stay there, the left child's go to
    /// `scratch.left`. `None` if a leaf is cheaper or the budget forbids the division; then nothing is
    /// changed.
    fn step(
        &self,
        overlap: &mut Overlap,
        start: Start,
        cell: Cell,
        scratch: &mut Scratch,
    ) -> Option<(Plane, [Cell; 2])> {
        let n = overlap.prims.len() - start.prims;
        let as_leaf = self.costs.leaf(n);
        if cell.depth >= self.max_depth || as_leaf <= self.costs.cheapest_split() {
            return None;
        }
        if !cell.small && !self.watch.go_on() {
            return None;
        }
        let across = |axis: usize| {
            let events = &overlap.events[axis][start.events[axis]..];
            dispatch_two!(self.level, simd => best_across(simd, &cell.bounds, axis, events, n, &self.costs))
        };
        let planes = if n >= WORTH_THREE_THREADS {
            let (x, (y, z)) = self.both(|| across(0), || self.both(|| across(1), || across(2)));
            [x, y, z]
        } else {
            [across(0), across(1), across(2)]
        };
        let plane = cheapest(planes).filter(|plane| plane.cost < as_leaf)?;

        let counts = overlap.classify(start, self.valid_triangles, &cell.bounds, &plane, scratch);
        let children = cell.children(&plane, counts)?;
        overlap.divide(start, scratch, self.parallel && n >= WORTH_THREE_THREADS);
        Some((plane, children))
    }
}
