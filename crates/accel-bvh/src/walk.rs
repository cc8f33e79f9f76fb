// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray through the tree: nearest children first; nodes beyond the best hit are skipped.
//! Source: [WBB08]; stack entries are sorted as numbers, distance in the upper bits, child in the lower.
//! Cost: a node is one test of eight boxes. Zero, one and two hit children are by far the most frequent cases
//! and need no sorting. Tests: `tests/brute_force.rs`.

use std::ops::Range;

use gnurt_simd::{Simd, Stack, StackBuffer, f32x8, prefetch, prelude::*};

use crate::compact::{Children, CompactNode, CompactNodes};
use crate::node::{Child, Node8, WIDTH};
use crate::node_ray::NodeRay;
use crate::tree::{DEEPEST, Tree};

/// The stack of pending nodes: at most seven children of each node on the way down, and a root.
pub(crate) type NodeStack = StackBuffer<u64, MOST_WAIT>;

/// Entries of a stack for the longest way down.
pub(crate) const MOST_WAIT: usize = 8 * DEEPEST;

/// An entry: the ray's entry distance, and the child. Entries compare as their distances do, which are not
/// negative.
#[inline(always)]
pub(crate) fn entry(t: f32, child: Child) -> u64 {
    u64::from(t.to_bits()) << 32 | u64::from(child.0)
}

#[inline(always)]
fn distance(entry: u64) -> f32 {
    f32::from_bits((entry >> 32) as u32)
}

/// Puts a few entries in order: by insertion, which for at most eight is the fastest.
#[inline(always)]
pub(crate) fn farthest_first<T: Copy, K: PartialOrd>(entries: &mut [T], distance: impl Fn(&T) -> K) {
    for i in 1..entries.len() {
        let moved = entries[i];
        let mut at = i;
        while at > 0 && distance(&entries[at - 1]) < distance(&moved) {
            entries[at] = entries[at - 1];
            at -= 1;
        }
        entries[at] = moved;
    }
}

/// The nearest entry that still counts.
#[inline(always)]
pub(crate) fn next(waiting: &mut Stack<u64>, reach: f32) -> Option<Child> {
    while let Some(entry) = waiting.pop() {
        if distance(entry) <= reach {
            return Some(Child(entry as u32));
        }
    }
    None
}

/// Of the children in `bits`, of which there are two or more, and which are entered at `near`: the nearest; the others wait,
/// farthest first. Two children, by far the most frequent, need no sorting.
#[inline(always)]
pub(crate) fn nearest_first(
    mut bits: u32,
    near: &[f32; WIDTH],
    children: &[f32; WIDTH],
    waiting: &mut Stack<u64>,
) -> Child {
    let lane = bits.trailing_zeros() as usize;
    bits &= bits - 1;
    let mut nearest = entry(near[lane & 7], Child::at(children, lane));
    let lane = bits.trailing_zeros() as usize;
    bits &= bits - 1;
    let second = entry(near[lane & 7], Child::at(children, lane));
    waiting.push(nearest.max(second));
    nearest = nearest.min(second);
    if bits != 0 {
        let mut count = 1;
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let other = entry(near[lane & 7], Child::at(children, lane));
            waiting.push(nearest.max(other));
            nearest = nearest.min(other);
            count += 1;
        }
        farthest_first(waiting.top(count), |&entry| entry);
    }
    Child(nearest as u32)
}

/// As [`nearest_first`], but behind the nearest two the others wait in no order: to sort them takes branches that are hard to
/// foresee, and a ray that visits most of what waits gains less by order. `request` gets each of them first.
#[inline(always)]
pub(crate) fn nearest_two_first(
    mut bits: u32,
    near: &[f32; WIDTH],
    children: &[f32; WIDTH],
    waiting: &mut Stack<u64>,
    request: impl Fn(Child),
) -> Child {
    let lane = bits.trailing_zeros() as usize & (WIDTH - 1);
    bits &= bits - 1;
    let child = Child::at(children, lane);
    request(child);
    let mut nearest = entry(near[lane], child);
    let lane = bits.trailing_zeros() as usize & (WIDTH - 1);
    bits &= bits - 1;
    let child = Child::at(children, lane);
    request(child);
    let other = entry(near[lane], child);
    let mut second = nearest.max(other);
    nearest = nearest.min(other);
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize & (WIDTH - 1);
        bits &= bits - 1;
        let child = Child::at(children, lane);
        request(child);
        let other = entry(near[lane], child);
        let farther = nearest.max(other);
        nearest = nearest.min(other);
        waiting.push(second.max(farther));
        second = second.min(farther);
    }
    waiting.push(second);
    Child(nearest as u32)
}

/// Of the children in `bits`, which is not 0: the last; the others go to the stack, the first of them lowest.
/// For any hit, which needs no order: the builder puts the most probable hit last.
#[inline(always)]
pub(crate) fn last_first(mut bits: u32, children: &[f32; WIDTH], mut wait: impl FnMut(Child)) -> Child {
    let mut child = Child::at(children, bits.trailing_zeros() as usize);
    bits &= bits - 1;
    while bits != 0 {
        wait(child);
        child = Child::at(children, bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
    child
}

/// Nodes by their numbers.
pub(crate) trait Nodes {
    /// The boxes of node `index` that `ray` hits before `reach`, as bits; its entry distances; and the boxes'
    /// contents.
    fn meet<S: Simd>(
        &self,
        simd: S,
        index: usize,
        ray: &NodeRay<S>,
        reach: f32,
    ) -> (u32, f32x8<S>, &[f32; WIDTH]);

    /// The child to visit next of those in `bits`, of which there are two or more; the others wait.
    #[inline(always)]
    fn order(
        &self,
        bits: u32,
        near: &[f32; WIDTH],
        children: &[f32; WIDTH],
        waiting: &mut Stack<u64>,
    ) -> Child {
        nearest_first(bits, near, children, waiting)
    }

    /// Called before children are visited in no order, if there are two or more.
    #[inline(always)]
    fn request(&self, _bits: u32, _children: &[f32; WIDTH]) {}
}

/// Of one form: for walks that are compiled for it.
impl Nodes for [Node8] {
    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        index: usize,
        ray: &NodeRay<S>,
        reach: f32,
    ) -> (u32, f32x8<S>, &[f32; WIDTH]) {
        let node = &self[index];
        let (bits, near) = ray.meet(simd, node, reach);
        (bits, near, node.children())
    }
}

/// The same.
impl Nodes for CompactNodes<'_> {
    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        index: usize,
        ray: &NodeRay<S>,
        reach: f32,
    ) -> (u32, f32x8<S>, &[f32; WIDTH]) {
        let (bits, near) = ray.meet(simd, &self.boxes[index], reach);
        (bits, near, &self.children[index])
    }
}

/// Of either form: for walks that are compiled once for both.
impl Nodes for Tree {
    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        index: usize,
        ray: &NodeRay<S>,
        reach: f32,
    ) -> (u32, f32x8<S>, &[f32; WIDTH]) {
        match self.nodes.get(index) {
            Some(node) => {
                let (bits, near) = ray.meet(simd, node, reach);
                (bits, near, node.children())
            }
            None => {
                let (node, children) = self.compact_node(index);
                meet_compact(simd, node, children, ray, reach)
            }
        }
    }
}

/// The same, requesting all that a ray is about to visit: where trees are larger than caches, and rays visit most of what they
/// put on the stack.
pub(crate) struct Ahead<'a, B> {
    pub(crate) tree: &'a Tree,
    pub(crate) blocks: &'a [B],
    /// Whether children behind the nearest two wait in no order.
    pub(crate) two_first: bool,
}

impl<B> Nodes for Ahead<'_, B> {
    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        index: usize,
        ray: &NodeRay<S>,
        reach: f32,
    ) -> (u32, f32x8<S>, &[f32; WIDTH]) {
        self.tree.meet(simd, index, ray, reach)
    }

    #[inline(always)]
    fn order(
        &self,
        bits: u32,
        near: &[f32; WIDTH],
        children: &[f32; WIDTH],
        waiting: &mut Stack<u64>,
    ) -> Child {
        if !self.two_first {
            self.request(bits, children);
            return nearest_first(bits, near, children, waiting);
        }
        nearest_two_first(
            bits,
            near,
            children,
            waiting,
            #[inline(always)]
            |child| self.request_one(child),
        )
    }

    #[inline(always)]
    fn request(&self, mut bits: u32, children: &[f32; WIDTH]) {
        while bits != 0 {
            self.request_one(Child::at(children, bits.trailing_zeros() as usize));
            bits &= bits - 1;
        }
    }
}

impl<B> Ahead<'_, B> {
    /// Requests the first block or the node.
    #[inline(always)]
    fn request_one(&self, child: Child) {
        if child.is_leaf() {
            prefetch(self.blocks, child.blocks().start);
        } else {
            prefetch(&self.tree.nodes, child.index());
        }
    }
}

/// A node of a compact tree. Cold, so that walks of other trees keep their registers: they would be saved around a call that
/// might be.
#[cold]
#[inline(never)]
fn meet_compact<'a, S: Simd>(
    simd: S,
    node: &CompactNode,
    children: &'a Children,
    ray: &NodeRay<S>,
    reach: f32,
) -> (u32, f32x8<S>, &'a [f32; WIDTH]) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (bits, near) = ray.meet(simd, node, reach);
            (bits, near, children)
        },
    )
}

/// From `start` on, calls `leaf` with the blocks of each leaf that the ray meets before `reach`; it answers with the new reach.
/// Returns the number of nodes visited, leaves too. The tree is not empty.
#[inline(always)]
pub(crate) fn walk<S: Simd>(
    nodes: &(impl Nodes + ?Sized),
    simd: S,
    start: Child,
    ray: &NodeRay<S>,
    reach: f32,
    leaf: impl FnMut(Range<usize>) -> f32,
) -> u32 {
    walk_with(NodeStack::new(), nodes, simd, start, ray, reach, leaf)
}

/// The same on a stack for the longest way down.
#[inline(always)]
pub(crate) fn walk_with<S: Simd, const WAIT: usize>(
    mut buffer: StackBuffer<u64, WAIT>,
    nodes: &(impl Nodes + ?Sized),
    simd: S,
    start: Child,
    ray: &NodeRay<S>,
    reach: f32,
    leaf: impl FnMut(Range<usize>) -> f32,
) -> u32 {
    walk_on(&mut buffer.stack(), nodes, simd, start, ray, reach, leaf)
}

/// The nearest child of the root that the ray meets before `reach`, if it meets any; the others wait. So a ray is made ready for
/// primitives after it has met the root, and while it goes on from there.
#[inline(always)]
pub(crate) fn enter<S: Simd>(
    waiting: &mut Stack<u64>,
    nodes: &(impl Nodes + ?Sized),
    simd: S,
    ray: &NodeRay<S>,
    reach: f32,
) -> Option<Child> {
    let (bits, near, children) = nodes.meet(simd, 0, ray, reach);
    if bits == 0 {
        None
    } else if bits & (bits - 1) == 0 {
        Some(Child::at(children, bits.trailing_zeros() as usize))
    } else {
        Some(nearest_first(bits, near.as_array(), children, waiting))
    }
}

/// [`walk`] where some children wait already.
#[inline(always)]
pub(crate) fn walk_on<S: Simd>(
    waiting: &mut Stack<u64>,
    nodes: &(impl Nodes + ?Sized),
    simd: S,
    start: Child,
    ray: &NodeRay<S>,
    mut reach: f32,
    mut leaf: impl FnMut(Range<usize>) -> f32,
) -> u32 {
    let mut visited = 0;
    let mut child = start;
    loop {
        visited += 1;
        if child.is_leaf() {
            reach = leaf(child.blocks());
        } else {
            let (bits, near, children) = nodes.meet(simd, child.index(), ray, reach);
            if bits != 0 {
                child = if bits & (bits - 1) == 0 {
                    Child::at(children, bits.trailing_zeros() as usize)
                } else {
                    nodes.order(bits, near.as_array(), children, waiting)
                };
                continue;
            }
        }
        match next(waiting, reach) {
            Some(next) => child = next,
            None => return visited,
        }
    }
}

/// [`walk`] for any hit: children need no order, and `leaf` returns whether to continue.
#[inline(always)]
pub(crate) fn walk_any<S: Simd>(
    nodes: &(impl Nodes + ?Sized),
    simd: S,
    start: Child,
    ray: &NodeRay<S>,
    reach: f32,
    leaf: impl FnMut(Range<usize>) -> bool,
) -> u32 {
    let mut buffer = StackBuffer::<u32, MOST_WAIT>::new();
    walk_any_on(&mut buffer.stack(), nodes, simd, start, ray, reach, leaf)
}

/// [`enter`] for any hit: the last child.
#[inline(always)]
pub(crate) fn enter_any<S: Simd>(
    waiting: &mut Stack<u32>,
    nodes: &(impl Nodes + ?Sized),
    simd: S,
    ray: &NodeRay<S>,
    reach: f32,
) -> Option<Child> {
    let (bits, _, children) = nodes.meet(simd, 0, ray, reach);
    (bits != 0).then(|| {
        last_first(
            bits,
            children,
            #[inline(always)]
            |child| waiting.push(child.0),
        )
    })
}

/// [`walk_any`] where some children wait already.
#[inline(always)]
pub(crate) fn walk_any_on<S: Simd>(
    waiting: &mut Stack<u32>,
    nodes: &(impl Nodes + ?Sized),
    simd: S,
    start: Child,
    ray: &NodeRay<S>,
    reach: f32,
    mut leaf: impl FnMut(Range<usize>) -> bool,
) -> u32 {
    let mut visited = 0;
    let mut child = start;
    loop {
        visited += 1;
        if child.is_leaf() {
            if !leaf(child.blocks()) {
                return visited;
            }
        } else {
            let (bits, _, children) = nodes.meet(simd, child.index(), ray, reach);
            if bits != 0 {
                if bits & (bits - 1) != 0 {
                    nodes.request(bits, children);
                }
                child = last_first(
                    bits,
                    children,
                    #[inline(always)]
                    |child| waiting.push(child.0),
                );
                continue;
            }
        }
        match waiting.pop() {
            Some(next) => child = Child(next),
            None => return visited,
        }
    }
}
