// SPDX-License-Identifier: GPL-3.0-or-later
//! SAH kd-tree construction by sweeping sorted plane events, in O(n log n).
//! Source: [WH06] section 4.3; greedy cost [MB90]. Differs: triangles are numbered anew in every node, so that
//! events stay 8 bytes, the classification array stays as small as the node, and subtrees share nothing.
//! In: screened triangles, object space. Out: [`KdTree`]; children of a node lie next to each other, followed by all
//! that is below the left one, then all below the right one, whoever built them.
//! Cost: events are sorted once; a node's are filtered and merged. At most two generations of a path are alive.
//! Invariant: the tree does not depend on the threads; its leaves hold at most `reference_budget` times n references,
//! shared out to subtrees by their size. Tests: `tests/kd_build.rs`.

use gnurt_simd::{Level, dispatch_two};
use rayon::prelude::*;

use crate::builder::{Builder, Cell, Subtree, WORTH_A_THREAD};
use crate::divide::{Scratch, Seen, Start};
use crate::event::{Event, push_events};
use crate::node::{DEEPEST, KdTree};
use crate::sah::{Costs, Plane, best_across, cheapest};
use crate::sampled::BoxRef;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::screened::Screened;
use gnurt_accel_core::{Aabb, BuildError, BuildOptions, Quality, Threads};

/// In nodes of more triangles than this each axis is worth a thread.
const WORTH_THREE_THREADS: usize = 65_536;

impl KdTree {
    /// Builds over the good triangles of `screened`.
    ///
    /// What the tree takes stays counted.
    pub(crate) fn build(
        screened: &Screened,
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
            Builder { screened, costs, max_depth, parallel, level: Level::best(), watch }.run(options)
        })
    }
}

impl Builder<'_> {
    fn run(&self, options: &BuildOptions) -> Result<KdTree, BuildError> {
        let n = self.screened.good.len();
        let budget = (f64::from(options.reference_budget.max(1.0)) * n as f64) as usize;
        let bounds = self.screened.bounds;
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
                let seen = Seen { events: self.root_events(), prims: self.screened.good.clone() };
                self.grow_wide(seen, cell, &mut tree, 0);
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
        let one = |&number: &u32| BoxRef::new(&Aabb::around(&self.screened.corners(number)), number);
        if self.parallel {
            self.screened.good.par_iter().map(one).collect()
        } else {
            self.screened.good.iter().map(one).collect()
        }
    }

    /// All triangles' events, sorted.
    fn root_events(&self) -> [Vec<Event>; 3] {
        let sorted = |axis: usize| {
            let mut events = Vec::with_capacity(2 * self.screened.good.len());
            for (i, &number) in self.screened.good.iter().enumerate() {
                push_events(&mut events, &Aabb::around(&self.screened.corners(number)), axis, i as u32);
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

    /// Builds a node and what is below it into `slot` of `tree`, by several threads as long as it is large enough.
    fn grow_wide(&self, mut seen: Seen, cell: Cell, tree: &mut Subtree, slot: usize) {
        let mut scratch = Scratch::default();
        if !self.parallel || seen.prims.len() < WORTH_A_THREAD {
            let before = seen.memory_bytes();
            tree.counted = before;
            self.grow(&mut seen, Start::default(), cell, &mut scratch, tree, slot);
            self.watch.recount(&mut tree.counted, before);
            return;
        }
        let Some((plane, [left, right])) = self.step(&mut seen, Start::default(), cell, &mut scratch) else {
            return tree.set_leaf(slot, seen.prims.iter().copied());
        };
        let first = tree.set_inner(slot, &plane);
        let lefts = scratch.into_left();
        let aside = lefts.memory_bytes();
        self.watch.take(aside);
        let apart = |seen: Seen, child: Cell| {
            let mut apart = Subtree::new();
            self.grow_wide(seen, child, &mut apart, 0);
            self.grown(&cell, &child, &apart);
            apart
        };
        let on_left = || {
            let grown = apart(lefts, left);
            self.watch.give(aside);
            grown
        };
        let (left, right) = rayon::join(on_left, || apart(seen, right));
        tree.attach(first, left);
        tree.attach(first + 1, right);
    }

    /// Builds what is behind `start` in `seen` into `slot` of `tree`, and what is below it behind all that is there.
    /// Only what lies before `start` is left in `seen`.
    fn grow(
        &self,
        seen: &mut Seen,
        start: Start,
        cell: Cell,
        scratch: &mut Scratch,
        tree: &mut Subtree,
        slot: usize,
    ) {
        match self.step(seen, start, cell, scratch) {
            None => tree.set_leaf(slot, seen.prims[start.prims..].iter().copied()),
            Some((plane, [left, right])) => {
                let first = tree.set_inner(slot, &plane);
                let behind = seen.end();
                seen.append_left(scratch);
                if !cell.small {
                    let now = seen.memory_bytes() + scratch.memory_bytes() + tree.memory_bytes();
                    self.watch.recount(&mut tree.counted, now);
                }
                self.grow(seen, behind, left, scratch, tree, first);
                self.advance(&cell, &left);
                self.grow(seen, start, right, scratch, tree, first + 1);
                self.advance(&cell, &right);
            }
        }
        seen.truncate(start);
    }

    /// Divides what is behind `start`: the right child's triangles stay there, the left child's go to `scratch.left`.
    /// `None` where a leaf is cheaper or the budget forbids to divide; then nothing is changed.
    fn step(
        &self,
        seen: &mut Seen,
        start: Start,
        cell: Cell,
        scratch: &mut Scratch,
    ) -> Option<(Plane, [Cell; 2])> {
        let n = seen.prims.len() - start.prims;
        let as_leaf = self.costs.leaf(n);
        if cell.depth >= self.max_depth || as_leaf <= self.costs.cheapest_split() {
            return None;
        }
        if !cell.small && !self.watch.go_on() {
            return None;
        }
        let across = |axis: usize| {
            let events = &seen.events[axis][start.events[axis]..];
            dispatch_two!(self.level, simd => best_across(simd, &cell.bounds, axis, events, n, &self.costs))
        };
        let planes = if n >= WORTH_THREE_THREADS {
            let (x, (y, z)) = self.both(|| across(0), || self.both(|| across(1), || across(2)));
            [x, y, z]
        } else {
            [across(0), across(1), across(2)]
        };
        let plane = cheapest(planes).filter(|plane| plane.cost < as_leaf)?;

        let counts = seen.classify(start, self.screened, &cell.bounds, &plane, scratch);
        let children = cell.children(&plane, counts)?;
        seen.divide(start, scratch, self.parallel && n >= WORTH_THREE_THREADS);
        Some((plane, children))
    }
}
