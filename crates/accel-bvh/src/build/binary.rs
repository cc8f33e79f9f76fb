// SPDX-License-Identifier: GPL-3.0-or-later
//! A binary tree, built with care: by the cheaper of dividing references and dividing space, node by node.
//! Source: [SFD09] section 4.3 for when space is tried; binned as in [Wald07].
//! In: references with space for second parts behind them. Out: [`BinaryNode`]s, children before their
//! parents.
//! Invariant: subtrees get space by their numbers of references, so that threads do not matter.
//! Tests: `super::tests`.

use super::binary_node::{BinaryNode, Cluster};
use super::bins::Bins;
use super::costs::{Costs, inner_costs, leaf_costs};
use super::partition::Buffer;
use super::reference::{Lanes, Part, Reference};
use super::task_pool::TaskPool;
use crate::primitives::Primitives;

use crate::node::WIDTH;

/// Subtrees over at most this many references are built by one thread. Tests have small scenes.
const SUBTREE: usize = if cfg!(test) { 1 << 8 } else { 1 << 12 };

/// Space is divided only where the children would overlap by more than this share of the root's area,
const LEAST_OVERLAP: f32 = 1e-5;

/// and by more than this share of their parent's.
const LEAST_OWN_OVERLAP: f32 = 0.05;

/// Memory that is used again and again.
pub(super) struct Workspace {
    bins: Bins,
    buffer: Buffer,
    right: Vec<Reference>,
}

/// The input of a careful build, and its threads.
pub(super) struct Careful<'a> {
    pub(super) primitives: &'a dyn Primitives,
    pub(super) tasks: TaskPool<'a>,
    /// Overlaps of children below this are good enough.
    least_overlap: f32,
    /// From this depth on references are divided by number only.
    by_number: usize,
    /// The clusters that references point to; empty if they point to primitives.
    clusters: &'a [Cluster],
}

impl<'a> Careful<'a> {
    pub(super) fn new(
        primitives: &'a dyn Primitives,
        tasks: TaskPool<'a>,
        root: &Part,
        by_number: usize,
    ) -> Self {
        let least_overlap = LEAST_OVERLAP * root.bounds.half_area(tasks.scale);
        Self { primitives, tasks, least_overlap, by_number, clusters: &[] }
    }

    /// As above, but references are of clusters, which are never split.
    pub(super) fn over(
        clusters: &'a [Cluster],
        primitives: &'a dyn Primitives,
        tasks: TaskPool<'a>,
        root: &Part,
        by_number: usize,
    ) -> Self {
        Self { clusters, ..Self::new(primitives, tasks, root, by_number) }
    }

    /// The tree over the references of `root`, which are the first of `references`.
    pub(super) fn build(&self, references: &mut [Reference], root: Part) -> Vec<BinaryNode> {
        let mut pieces = vec![Vec::new()];
        self.subtree(references, root, 0, &mut Workspace::new(), &mut pieces);
        if pieces.len() == 1 {
            return pieces.swap_remove(0);
        }
        let watch = self.tasks.watch;
        let bytes = pieces.iter().map(|nodes| size_of_val(&nodes[..])).sum();
        let mut nodes = Vec::new();
        if watch.take(bytes) {
            self.tasks.concat(&pieces, &mut nodes);
        }
        watch.give(bytes);
        nodes
    }

    /// Appends to the last of `pieces`, or as further pieces; returns the number of nodes and the cost of the
    /// last one.
    fn subtree(
        &self,
        references: &mut [Reference],
        part: Part,
        depth: usize,
        workspace: &mut Workspace,
        pieces: &mut Vec<Vec<BinaryNode>>,
    ) -> (usize, Costs) {
        let count = part.count();
        let area = part.bounds.half_area(self.tasks.scale);
        let last = pieces.len() - 1;
        if !self.clusters.is_empty() {
            if count == 1 {
                let Cluster { child, costs } = self.clusters[references[0].number() as usize];
                pieces[last].push(BinaryNode::made(part.bounds, child));
                return (1, costs);
            }
        } else if count <= WIDTH {
            pieces[last].push(BinaryNode::leaf(part.bounds, &references[..count]));
            return (1, leaf_costs(area));
        }
        let large = count > SUBTREE;
        if large && !self.tasks.watch.go_on() {
            pieces[last].push(BinaryNode::leaf(part.bounds, &[]));
            return (1, leaf_costs(area));
        }
        let [left, right] = self.divide(references, &part, depth, workspace);
        let counts = [left.count(), right.count()];
        let (left_slice, right_slice) = references.split_at_mut(right.start);
        let right = Part { start: 0, end: right.count(), ..right };
        let ((left_size, left_costs), (right_size, right_costs)) = if self.tasks.parallel && large {
            let mut split_off = vec![Vec::new()];
            let both = self.tasks.both(
                || self.subtree(left_slice, left, depth + 1, workspace, pieces),
                || self.subtree(right_slice, right, depth + 1, &mut Workspace::new(), &mut split_off),
            );
            pieces.append(&mut split_off);
            both
        } else {
            let left = self.subtree(left_slice, left, depth + 1, workspace, pieces);
            (left, self.subtree(right_slice, right, depth + 1, workspace, pieces))
        };
        if large && self.clusters.is_empty() {
            for (count, size) in counts.into_iter().zip([left_size, right_size]) {
                if count <= SUBTREE {
                    self.tasks.watch.advance(count);
                    self.tasks.watch.grow(size * size_of::<BinaryNode>());
                }
            }
        }
        let last = pieces.len() - 1;
        let (costs, shares) = inner_costs(area, &left_costs, &right_costs);
        pieces[last].push(BinaryNode::inner(part.bounds, [right_size as u32 + 1, 1], shares));
        (left_size + right_size + 1, costs)
    }

    /// Cuts `part`, the first of `references`, in two; the second starts at its own space.
    pub(super) fn divide(
        &self,
        references: &mut [Reference],
        part: &Part,
        depth: usize,
        workspace: &mut Workspace,
    ) -> [Part; 2] {
        let scale = self.tasks.scale;
        let count = part.count();
        let capacity = references.len();
        let Workspace { bins, buffer, right } = workspace;
        let inside = &mut references[..count];
        let share = |left: usize, right: usize| (capacity - left - right) * left / (left + right);
        let around = |references: &[Reference], start: usize, end: usize| {
            let part = self.tasks.around(&references[start..end]);
            Part { start, end, ..part }
        };
        let found = if depth < self.by_number { self.tasks.find(inside, part, bins) } else { None };
        let Some(found) = found else {
            // Whole blocks, and not all of them: more than one block is there.
            let whole = if self.clusters.is_empty() { WIDTH } else { 1 };
            let left = (count / 2).next_multiple_of(whole);
            let start = left + share(left, count - left);
            references.copy_within(left..count, start);
            return [around(references, 0, left), around(references, start, start + count - left)];
        };
        let least = self.least_overlap.max(LEAST_OWN_OVERLAP * part.bounds.half_area(scale));
        if capacity > count && overlap(&found.bounds, scale) > least {
            let plane = self.tasks.find_plane(inside, &part.bounds, capacity);
            if let Some(plane) = plane.filter(|plane| plane.cost < found.split.cost) {
                let left = self.tasks.cut(self.primitives, inside, &plane, right);
                if left > 0 && !right.is_empty() {
                    let start = left + share(left, right.len());
                    references[start..start + right.len()].copy_from_slice(right);
                    return [around(references, 0, left), around(references, start, start + right.len())];
                }
                // Everything ended up on one side: nothing was cut, only moved.
                let inside = &mut references[..count];
                if left == 0 {
                    inside.copy_from_slice(right);
                }
            }
        }
        let inside = &mut references[..count];
        let parted = self.tasks.part(inside, &found, buffer);
        let left = parted.left;
        let start = left + share(left, count - left);
        if start > left {
            references.copy_within(left..count, start);
        }
        let [left_bounds, right_bounds] = found.bounds;
        [
            Part { start: 0, end: left, bounds: left_bounds, middles: parted.middles[0] },
            Part { start, end: start + count - left, bounds: right_bounds, middles: parted.middles[1] },
        ]
    }
}

impl Workspace {
    pub(super) fn new() -> Self {
        Self { bins: Bins::EMPTY, buffer: Buffer::EMPTY, right: Vec::new() }
    }
}

/// Half the surface of the intersection of two boxes; zero if they are disjoint.
fn overlap([a, b]: &[Lanes; 2], scale: f32) -> f32 {
    let mut shared = *a;
    shared.0.iter_mut().zip(b.0).for_each(|(a, b)| *a = a.min(b));
    if (0..3).any(|axis| shared.side(axis) < 0.0) { 0.0 } else { shared.half_area(scale) }
}
