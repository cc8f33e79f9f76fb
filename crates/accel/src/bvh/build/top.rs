// SPDX-License-Identifier: GPL-3.0-or-later
//! The upper part of a tree, node by node with all threads, and the subtrees below it, each by one thread.
//! Source: original; pieces that are binned on their own are those of [Wald07]'s parallel build.
//! Invariant: what is cut where depends on numbers of references, not of threads, so that all build the same tree:
//! nodes of the upper part level by level, then subtree by subtree. Proof: `super::tests`.

use gnurt_simd::{Level, dispatch};
use rayon::prelude::*;

use super::Tree;
use super::bins::{Bins, Mapping, Split};
use super::grow::{self, Spread, grow, is_leaf, push_leaf};
use super::partition::{Buffer, Parted, partition};
use super::reference::{Part, Reference};
use crate::bvh::{Child, Node8, WIDTH};

/// More references than this are binned and parted in pieces.
const PIECE: usize = 1 << 15;

/// Subtrees over at most this many references are built by one thread.
pub(super) const SUBTREE: usize = 1 << 12;

/// Who builds, and how large things are.
#[derive(Clone, Copy)]
pub(super) struct Crew {
    pub(super) parallel: bool,
    pub(super) level: Level,
    /// Sides of boxes are multiplied with this before their area is taken.
    pub(super) scale: f32,
}

/// A node to be made, to hang at `place` of node `parent`; `part` counts within `references`.
struct Job<'a> {
    references: &'a mut [Reference],
    part: Part,
    hook: Hook,
}

/// Where a node will hang.
#[derive(Clone, Copy)]
struct Hook {
    parent: usize,
    place: usize,
    /// First of the references, counted from the first of all.
    start: usize,
}

impl Crew {
    /// Runs two jobs, at the same time where there are threads.
    pub(super) fn both<A: Send, B: Send>(
        self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        if self.parallel { rayon::join(a, b) } else { (a(), b()) }
    }

    fn each<T: Send, R: Send>(self, jobs: Vec<T>, run: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
        if self.parallel {
            jobs.into_par_iter().with_max_len(1).map(run).collect()
        } else {
            jobs.into_iter().map(run).collect()
        }
    }

    /// All of `references` as one part.
    pub(super) fn around(self, references: &[Reference]) -> Part {
        if references.len() <= PIECE {
            return dispatch!(self.level, simd => Part::around(simd, references, 0, references.len()));
        }
        let (left, right) = references.split_at(references.len() / 2);
        let (left, right) = self.both(|| self.around(left), || self.around(right));
        Part {
            start: 0,
            end: references.len(),
            bounds: left.bounds.union(&right.bounds),
            middles: left.middles.union(&right.middles),
        }
    }

    fn bin(self, references: &[Reference], mapping: &Mapping) -> Bins {
        if references.len() <= PIECE {
            let mut bins = Bins::EMPTY;
            dispatch!(self.level, simd => bins.add(simd, references, mapping));
            return bins;
        }
        let (left, right) = references.split_at(references.len() / 2);
        let (mut bins, others) = self.both(|| self.bin(left, mapping), || self.bin(right, mapping));
        bins.merge(&others);
        bins
    }

    fn partition(self, references: &mut [Reference], mapping: &Mapping, split: &Split) -> Parted {
        if references.len() <= PIECE {
            let mut buffer = Buffer::EMPTY;
            return dispatch!(self.level, simd => partition(simd, references, mapping, split, &mut buffer));
        }
        // Each half is parted; then what the first has on its right changes places with the second's left.
        let (first, second) = references.split_at_mut(references.len() / 2);
        let (a, b) =
            self.both(|| self.partition(first, mapping, split), || self.partition(second, mapping, split));
        let wrong = &mut first[a.left..];
        let swapped = wrong.len().min(b.left);
        self.swap(&mut wrong[..swapped], &mut second[b.left - swapped..b.left]);
        let middles = [0, 1].map(|side: usize| a.middles[side].union(&b.middles[side]));
        Parted { left: a.left + b.left, middles }
    }

    fn swap(self, a: &mut [Reference], b: &mut [Reference]) {
        if a.len() <= PIECE {
            return a.swap_with_slice(b);
        }
        let (a, a_rest) = a.split_at_mut(a.len() / 2);
        let (b, b_rest) = b.split_at_mut(a.len());
        self.both(|| self.swap(a, b), || self.swap(a_rest, b_rest));
    }

    /// Cuts `part` of `references` in two.
    fn divide(
        self,
        references: &mut [Reference],
        part: &Part,
        depth: usize,
        workspace: &mut grow::Workspace,
    ) -> [Part; 2] {
        let Part { start, end, .. } = *part;
        if part.count() <= PIECE || depth >= grow::BY_NUMBER {
            let Self { level, scale, .. } = self;
            return dispatch!(level, simd => grow::divide(simd, references, part, depth, scale, workspace));
        }
        let inside = &mut references[start..end];
        let mapping = Mapping::new(&part.middles);
        let bins = self.bin(inside, &mapping);
        let best = dispatch!(self.level, simd => {
            bins.best_split(simd, self.scale).map(|split| (split, bins.sides(simd, &split)))
        });
        let Some((split, [left, right])) = best else {
            let border = start + grow::halfway(inside.len());
            return [(start, border), (border, end)].map(|(start, end)| {
                let part = self.around(&references[start..end]);
                Part { start, end, ..part }
            });
        };
        let Parted { left: count, middles } = self.partition(inside, &mapping, &split);
        let border = start + count;
        [
            Part { start, end: border, bounds: left, middles: middles[0] },
            Part { start: border, end, bounds: right, middles: middles[1] },
        ]
    }

    /// The tree over all of `references`, of which there is one at least.
    pub(super) fn build(self, references: &mut [Reference], root: Part) -> Tree {
        let mut tree = Tree { nodes: Vec::new(), blocks: Vec::new(), bounds: root.bounds.bounds() };
        let mut level = vec![(root, Hook { parent: 0, place: WIDTH, start: 0 })];
        let mut subtrees = Vec::new();
        let mut depth = 0;
        while !level.is_empty() {
            let jobs = cut(references, level);
            let spreads = self.each(jobs, |Job { references, part, hook }| {
                let mut workspace = grow::Workspace::EMPTY;
                let divide = |part: &Part| self.divide(references, part, depth, &mut workspace);
                (Spread::new(part, depth, self.scale, divide), part, hook)
            });
            level = Vec::new();
            depth += 1;
            for (spread, part, hook) in spreads {
                let parent = tree.nodes.len();
                if hook.place < WIDTH {
                    tree.nodes[hook.parent].set(hook.place, &part.bounds.bounds(), Child::node(parent));
                }
                tree.nodes.push(Node8::EMPTY);
                for (place, part) in spread.parts().iter().enumerate() {
                    let start = hook.start + part.start;
                    let end = hook.start + part.end;
                    if is_leaf(part) {
                        let leaf = push_leaf(&mut tree.blocks, &references[start..end]);
                        tree.nodes[parent].set(place, &part.bounds.bounds(), leaf);
                        continue;
                    }
                    let part = Part { start: 0, end: part.count(), ..*part };
                    let next = (part, Hook { parent, place, start });
                    if part.count() > SUBTREE { level.push(next) } else { subtrees.push((next, depth)) }
                }
            }
            level.sort_unstable_by_key(|(_, hook)| hook.start);
        }
        subtrees.sort_unstable_by_key(|((_, hook), _)| hook.start);
        let (subtrees, depths): (Vec<_>, Vec<_>) = subtrees.into_iter().unzip();
        let jobs: Vec<(Job, usize)> = cut(references, subtrees).into_iter().zip(depths).collect();
        if self.parallel { self.grow_apart(jobs, tree) } else { self.grow_on(jobs, tree) }
    }

    /// One subtree after the other, into the tree itself.
    fn grow_on(self, jobs: Vec<(Job, usize)>, mut tree: Tree) -> Tree {
        for (Job { references, part, hook }, depth) in jobs {
            let root = Child::node(tree.nodes.len());
            tree.nodes[hook.parent].set(hook.place, &part.bounds.bounds(), root);
            let Self { level, scale, .. } = self;
            dispatch!(level, simd => grow(simd, references, part, depth, scale, &mut tree));
        }
        tree.nodes.shrink_to_fit();
        tree.blocks.shrink_to_fit();
        tree
    }

    /// Subtrees on their own at first, then all of them behind each other.
    fn grow_apart(self, jobs: Vec<(Job, usize)>, mut top: Tree) -> Tree {
        let grown = self.each(jobs, |(Job { references, part, hook }, depth)| {
            let mut tree = Tree { nodes: Vec::new(), blocks: Vec::new(), bounds: part.bounds.bounds() };
            let Self { level, scale, .. } = self;
            dispatch!(level, simd => grow(simd, references, part, depth, scale, &mut tree));
            (tree, hook)
        });
        let (mut trees, mut starts) = (Vec::with_capacity(grown.len() + 1), vec![(0, 0)]);
        let mut end = (top.nodes.len(), top.blocks.len());
        for (tree, hook) in grown {
            top.nodes[hook.parent].set(hook.place, &tree.bounds, Child::node(end.0));
            starts.push(end);
            end = (end.0 + tree.nodes.len(), end.1 + tree.blocks.len());
            trees.push(tree);
        }
        let bounds = top.bounds;
        trees.insert(0, top);
        let nodes = (0..end.0).into_par_iter().with_min_len(64).map(|i| {
            let tree = starts.partition_point(|start| start.0 <= i) - 1;
            let (nodes, blocks) = starts[tree];
            trees[tree].nodes[i - nodes].moved(nodes, blocks)
        });
        let blocks = (0..end.1).into_par_iter().with_min_len(256).map(|i| {
            let tree = starts.partition_point(|start| start.1 <= i) - 1;
            trees[tree].blocks[i - starts[tree].1]
        });
        Tree { nodes: nodes.collect(), blocks: blocks.collect(), bounds }
    }
}

/// Lends each part its references; parts are in the order of their references.
fn cut(mut references: &mut [Reference], parts: Vec<(Part, Hook)>) -> Vec<Job<'_>> {
    let mut at = 0;
    let mut jobs = Vec::with_capacity(parts.len());
    for (part, hook) in parts {
        let (_, rest) = references.split_at_mut(hook.start - at);
        let (own, rest) = rest.split_at_mut(part.count());
        at = hook.start + part.count();
        references = rest;
        jobs.push(Job { references: own, part, hook });
    }
    jobs
}
