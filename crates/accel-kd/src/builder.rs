// SPDX-License-Identifier: GPL-3.0-or-later
//! Common parts of builders of kd-trees: cells, subtrees, and threads.
//! Source: [WH06] for cells; budgets original. Space: object. Tests: `tests/kd_build.rs` of `gnurt-accel`.

use gnurt_accel_core::Aabb;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::valid_triangles::ValidTriangles;
use gnurt_simd::Level;

use crate::node::{EMPTY_LEAF, Node};
use crate::sah::{Costs, Plane};

/// Nodes of fewer triangles are not worth another thread.
pub(super) const WORTH_A_THREAD: usize = 2048;
/// A node still to be built, without its triangles.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    pub(super) bounds: Aabb,
    pub(super) depth: usize,
    /// Most references that the leaves below may hold.
    pub(super) budget: usize,
    /// Whether this one or an ancestor has few triangles: its progress is not reported, and its memory is not
    /// counted.
    pub(super) small: bool,
}

impl Cell {
    /// The parts on both sides of a plane, given how many triangles each sees; `None` where the budget forbids it.
    pub(super) fn children(&self, plane: &Plane, counts: [usize; 2]) -> Option<[Self; 2]> {
        let references = counts[0] + counts[1];
        let spare = self.budget.checked_sub(references)?;
        let for_left = counts[0] + (spare as u128 * counts[0] as u128 / references.max(1) as u128) as usize;
        let [left, right] = self.bounds.split(plane.axis, plane.at);
        let child = |bounds: Aabb, budget: usize, count: usize| Self {
            bounds,
            depth: self.depth + 1,
            budget,
            small: self.small || count < WORTH_A_THREAD,
        };
        Some([child(left, for_left, counts[0]), child(right, self.budget - for_left, counts[1])])
    }
}

/// A finished subtree: nodes and items with indices of their own.
pub(super) struct Subtree {
    pub(super) nodes: Vec<Node>,
    pub(super) items: Vec<u32>,
    /// Bytes that were counted while it grew, with those of the memory that the builder works in.
    pub(super) counted: usize,
}

pub(super) struct Builder<'a> {
    pub(super) valid_triangles: &'a ValidTriangles<'a>,
    pub(super) costs: Costs,
    pub(super) max_depth: usize,
    pub(super) parallel: bool,
    pub(super) level: Level,
    pub(super) watch: &'a Watch<'a>,
}

impl Builder<'_> {
    /// Runs two jobs, at the same time where a pool was given.
    pub(super) fn both<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        if self.parallel { rayon::join(a, b) } else { (a(), b()) }
    }

    /// Reports the progress of small subtrees below a large node.
    pub(super) fn advance(&self, cell: &Cell, child: &Cell) {
        if child.small && !cell.small {
            self.watch.advance(child.budget);
        }
    }

    /// The same for a separate tree, which is counted.
    pub(super) fn grown(&self, cell: &Cell, child: &Cell, tree: &Subtree) {
        if child.small && !cell.small {
            self.watch.grow(tree.memory_bytes());
        }
        self.advance(cell, child);
    }
}

impl Subtree {
    /// An empty leaf.
    pub(super) fn new() -> Self {
        Self { nodes: vec![EMPTY_LEAF], items: vec![0], counted: 0 }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        size_of::<Node>() * self.nodes.capacity() + size_of::<u32>() * self.items.capacity()
    }

    /// Two children for `slot`; returns the index of the first.
    pub(super) fn set_inner(&mut self, slot: usize, plane: &Plane) -> usize {
        let first = self.nodes.len();
        self.nodes[slot] = Node::inner(first as u32, plane.axis, plane.at);
        self.nodes.extend([EMPTY_LEAF; 2]);
        first
    }

    pub(super) fn set_leaf(&mut self, slot: usize, prims: impl ExactSizeIterator<Item = u32>) {
        if prims.len() == 0 {
            self.nodes[slot] = EMPTY_LEAF;
            return;
        }
        self.nodes[slot] = Node::leaf(self.items.len() as u32);
        self.items.push(prims.len() as u32);
        self.items.extend(prims);
    }

    /// Puts a subtree's root into `slot` and the rest at the end; the empty leaf's list is there already.
    pub(super) fn attach(&mut self, slot: usize, below: Self) {
        let (nodes, items) = (self.nodes.len() as u32 - 1, self.items.len() as u32 - 1);
        let mut moved = below.nodes.into_iter().map(|node| node.moved(nodes, items));
        self.nodes[slot] = moved.next().unwrap_or(EMPTY_LEAF);
        self.nodes.extend(moved);
        self.items.extend_from_slice(&below.items[1..]);
    }
}
