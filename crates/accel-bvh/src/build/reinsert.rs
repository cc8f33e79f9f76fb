// SPDX-License-Identifier: GPL-3.0-or-later
//! Makes a binary tree cheaper: nodes are removed and inserted again where they add the least surface.
//! Source: [MB18], with the searches of [BHH13]. Differs: all searches of a round see the tree at its start.
//! Then moves are made in succession, the greatest gain first, and each only if it still makes the tree
//! cheaper. Only large nodes are searched for, fewer in each round: they bring almost all of the gain.
//!
//! ```text
//!        g              g             a               a
//!       / \            / \           / \             / \
//!      p   .    =>    s   .         t   .    =>     p   .      x moves to t, and takes its parent p along
//!     / \                                          / \
//!    x   s                                        x   t
//!
//!    saved: area(p), and what boxes from g on upwards lose      added: area(t and x), and what boxes from a on upwards win
//! ```
//!
//! Space: areas are scaled as in `bins`. Invariants: leaves are unchanged and boxes enclose their subtrees;
//! the sum of areas never rises; no path gets longer than the longest was, or than [`DEEPEST`]; independent
//! of threads. Tests: `tests`, `super::tests`.

mod cost;
#[cfg(test)]
mod tests;

use gnurt_accel_core::threads::map;
use gnurt_simd::{Simd, dispatch_two, f32x4, f32x8, prelude::*};

use super::binary_node::BinaryNode;
use super::reference::Lanes;
use super::task_pool::TaskPool;
use crate::tree::DEEPEST;

/// Shares of all nodes, the largest ones, that are searched for in each round: for the default trees,
pub(super) const QUICK: &[f32] = &[0.05];

/// and for those of high quality behind it.
pub(super) const THOROUGH: &[f32] = &[0.5, 0.25, 0.12];

/// Represents an absent node.
const NONE: u32 = u32::MAX;

/// Searches that are done by one thread. Tests have small scenes.
const PIECE: usize = if cfg!(test) { 1 << 4 } else { 1 << 10 };

/// Steps of progress for each search, one for the search and one for its move; every two nodes take another
/// step for the setup. A step is the time to build over one primitive; measured with conference and dragon.
const STEPS: usize = 2;

/// One of this many areas is sampled to find the largest ones.
const SAMPLE: usize = 16;

/// The state of a node that may move: a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct MovableNode {
    bounds: Lanes,
    /// None of a leaf.
    children: [u32; 2],
    /// None of the root.
    parent: u32,
    /// Nodes on the longest path down; 0 for a leaf.
    height: u32,
}

/// Where a node would be better off.
#[derive(Clone, Copy, Debug)]
struct Move {
    gain: f32,
    node: u32,
    target: u32,
}

/// A tree whose nodes may move. Nodes keep their numbers, the root as well.
struct MovableTree<'a> {
    movables: Vec<MovableNode>,
    root: u32,
    /// No path may be longer.
    longest: u32,
    tasks: TaskPool<'a>,
}

/// Improves the tree whose root is the last of `nodes`; returns the expected cost of its wide tree. Does
/// nothing after the build was stopped.
pub(super) fn reinsert(nodes: &mut [BinaryNode], rounds: &[f32], tasks: TaskPool) -> f32 {
    let bytes = nodes.len() * size_of::<MovableNode>();
    if nodes.is_empty() || !tasks.watch.take(bytes) {
        return f32::INFINITY;
    }
    let mut tree = MovableTree::new(nodes, tasks);
    tasks.watch.advance(nodes.len() / 2);
    for &share in rounds {
        let some = tree.largest(share);
        let moves = tree.search(&some);
        tree.make(moves, some.len());
    }
    let cost = tree.write(nodes);
    tasks.watch.give(bytes);
    cost
}

/// Steps of progress that it takes for `nodes`, about.
pub(super) fn steps(nodes: usize, rounds: &[f32]) -> usize {
    nodes / 2 + (rounds.iter().sum::<f32>() * (STEPS * nodes) as f32) as usize
}

/// Half the surface of a box.
#[inline(always)]
fn area<S: Simd>(simd: S, bounds: f32x8<S>, scale: f32) -> f32 {
    let (low, high) = simd.split_f32x8(bounds);
    let sides = (high + low) * f32x4::splat(simd, scale);
    let [x, y, z, _] = *sides.as_array();
    x * y + y * z + z * x
}

impl<'a> MovableTree<'a> {
    fn new(nodes: &[BinaryNode], tasks: TaskPool<'a>) -> Self {
        let movable = |at: usize| {
            let node = &nodes[at];
            let mut bounds = node.bounds;
            // These lanes are unused, but denormals would slow down arithmetic.
            (bounds.0[3], bounds.0[7]) = (0.0, 0.0);
            let children =
                if node.is_leaf() { [NONE; 2] } else { node.children(at).map(|child| child as u32) };
            MovableNode { bounds, children, parent: NONE, height: 0 }
        };
        let mut movables = Vec::new();
        tasks.extend(&mut movables, nodes.len(), movable);
        for at in 0..movables.len() {
            let children = movables[at].children.into_iter().filter(|&child| child != NONE);
            children.for_each(|child| movables[child as usize].parent = at as u32);
        }
        // From each leaf upwards, while that is the longest path.
        for leaf in 0..movables.len() {
            let (mut at, mut height) = (movables[leaf].parent, 1);
            while movables[leaf].is_leaf() && at != NONE && movables[at as usize].height < height {
                let above = &mut movables[at as usize];
                above.height = height;
                (at, height) = (above.parent, height + 1);
            }
        }
        let root = movables.len() - 1;
        let longest = movables[root].height.max(DEEPEST as u32);
        Self { movables, root: root as u32, longest, tasks }
    }

    fn movable(&self, at: u32) -> &MovableNode {
        &self.movables[at as usize]
    }

    /// Nodes that may move: the root and its children stay.
    fn may_move(&self, at: u32) -> bool {
        at != self.root && self.movable(at).parent != self.root
    }

    /// About `share` of all nodes, the largest, in order.
    fn largest(&self, share: f32) -> Vec<u32> {
        let area = |at: u32| self.movable(at).bounds.half_area(self.tasks.scale);
        let count = self.movables.len() as u32;
        let mut areas: Vec<f32> = (0..count).step_by(SAMPLE).map(area).collect();
        let rank = ((1.0 - share) * areas.len() as f32) as usize;
        let rank = rank.min(areas.len() - 1);
        let least = *areas.select_nth_unstable_by(rank, f32::total_cmp).1;
        let may_reinsert = |&at: &u32| area(at) >= least && self.may_move(at);
        let pieces = (count as usize).div_ceil(PIECE);
        let of_piece = |i: usize| -> Vec<u32> {
            let start = (i * PIECE) as u32;
            (start..count.min(start + PIECE as u32)).filter(may_reinsert).collect()
        };
        map(self.tasks.parallel, pieces, of_piece).concat()
    }

    /// The best move of each node that has a good one, in order.
    fn search(&self, nodes: &[u32]) -> Vec<Move> {
        let piece = |nodes: &[u32]| {
            let mut moves = Vec::new();
            if self.tasks.watch.go_on() {
                dispatch_two!(self.tasks.level, simd => self.search_piece(simd, nodes, &mut moves));
                self.tasks.watch.advance(nodes.len());
            }
            moves
        };
        let pieces: Vec<&[u32]> = nodes.chunks(PIECE).collect();
        map(self.tasks.parallel, pieces.len(), |i| piece(pieces[i])).concat()
    }

    #[inline(always)]
    fn search_piece<S: Simd>(&self, simd: S, nodes: &[u32], moves: &mut Vec<Move>) {
        let mut waiting = Vec::new();
        for &node in nodes {
            let best = self.best_move(simd, node, &mut waiting);
            if best.gain > 0.0 {
                moves.push(best);
            }
        }
    }

    /// The best position for a node. From its parent upwards, the sibling's subtree is searched as long as it
    /// may beat the best result; `waiting` is empty before and after.
    #[inline(always)]
    fn best_move<S: Simd>(&self, simd: S, node: u32, waiting: &mut Vec<(f32, u32)>) -> Move {
        let scale = self.tasks.scale;
        let bounds_of = |at: u32| self.movable(at).bounds.load(simd);
        let moved = bounds_of(node);
        let moved_area = area(simd, moved, scale);
        let mut best = Move { gain: 0.0, node, target: NONE };
        let parent = self.movable(node).parent;
        let sibling = self.movable(parent).other_than(node);
        // The area saved by boxes up to `above`, and the box of its subtree without the node.
        let (mut above, mut other) = (parent, sibling);
        let mut saved = area(simd, bounds_of(parent), scale);
        let mut without = bounds_of(sibling);
        loop {
            // The area added to boxes above a node, and that node.
            waiting.push((0.0, other));
            while let Some((added, at)) = waiting.pop() {
                // It costs at least its own area, wherever it is.
                if saved - added - moved_area <= best.gain {
                    continue;
                }
                let here = self.movable(at);
                let bounds = here.bounds.load(simd);
                let both = area(simd, bounds.max(moved), scale);
                let gain = saved - added - both;
                if gain > best.gain && at != sibling {
                    best = Move { gain, node, target: at };
                }
                if !here.is_leaf() {
                    let added = added + both - area(simd, bounds, scale);
                    if saved - added - moved_area > best.gain {
                        waiting.extend(here.children.map(|child| (added, child)));
                    }
                }
            }
            let below = above;
            above = self.movable(above).parent;
            if above == NONE {
                return best;
            }
            other = self.movable(above).other_than(below);
            without = without.max(bounds_of(other));
            saved += area(simd, bounds_of(above), scale) - area(simd, without, scale);
        }
    }

    /// Makes those moves that are still good ones; `searched` nodes were searched for.
    fn make(&mut self, mut moves: Vec<Move>, searched: usize) {
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.node.cmp(&b.node)));
        for piece in moves.chunks(PIECE) {
            if !self.tasks.watch.go_on() {
                return;
            }
            piece.iter().for_each(|&Move { node, target, .. }| self.try_move(node, target));
            self.tasks.watch.advance(piece.len());
        }
        // Nodes without a better position.
        self.tasks.watch.advance(searched - moves.len());
    }

    /// Moves `node` to `target`, where that is possible and makes the tree cheaper.
    fn try_move(&mut self, node: u32, target: u32) {
        let parent = self.movable(node).parent;
        let sibling = self.movable(parent).other_than(node);
        if parent == self.root || [self.root, parent, sibling].contains(&target) {
            return;
        }
        let mut above = 0;
        let mut at = target;
        while at != self.root {
            if at == node {
                return;
            }
            at = self.movable(at).parent;
            above += 1;
        }
        let height = 1 + self.movable(node).height.max(self.movable(target).height);
        if above + height > self.longest {
            return;
        }
        let saved = self.exact_area(&self.movable(parent).bounds) - self.take_out(parent, sibling);
        let added = self.put_in(parent, node, target);
        if added >= saved {
            self.take_out(parent, target);
            self.put_in(parent, node, sibling);
        }
    }

    /// `child` replaces its parent. Returns how much larger areas above are for it.
    fn take_out(&mut self, parent: u32, child: u32) -> f64 {
        let above = self.movable(parent).parent;
        self.replace(above, parent, child);
        self.fit(above)
    }

    /// `parent` replaces `target`, which becomes its child, as does `node`. Returns how much larger areas are
    /// for it, that of `parent` included.
    fn put_in(&mut self, parent: u32, node: u32, target: u32) -> f64 {
        let above = self.movable(target).parent;
        self.replace(above, target, parent);
        self.movables[target as usize].parent = parent;
        self.movables[parent as usize].children = [target, node];
        let (bounds, height) = self.around([target, node]);
        let movable = &mut self.movables[parent as usize];
        (movable.bounds, movable.height) = (bounds, height);
        self.exact_area(&bounds) + self.fit(above)
    }

    fn replace(&mut self, above: u32, old: u32, new: u32) {
        let children = &mut self.movables[above as usize].children;
        children[usize::from(children[0] != old)] = new;
        self.movables[new as usize].parent = above;
    }

    /// Box and height of a node with these children.
    fn around(&self, children: [u32; 2]) -> (Lanes, u32) {
        let [a, b] = children.map(|child| self.movable(child));
        (a.bounds.union(&b.bounds), 1 + a.height.max(b.height))
    }

    /// Boxes and heights from `at` upwards, as far as they change. Returns how much larger areas are.
    fn fit(&mut self, mut at: u32) -> f64 {
        let mut larger = 0.0;
        while at != NONE {
            let now = self.around(self.movable(at).children);
            let movable = self.movable(at);
            if now == (movable.bounds, movable.height) {
                break;
            }
            larger += self.exact_area(&now.0) - self.exact_area(&movable.bounds);
            let movable = &mut self.movables[at as usize];
            (movable.bounds, movable.height) = now;
            at = movable.parent;
        }
        larger
    }

    /// Half the surface in double precision: differences of large ones are small.
    fn exact_area(&self, bounds: &Lanes) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(bounds.side(axis)) * f64::from(self.tasks.scale));
        x * y + y * z + z * x
    }
}

impl MovableNode {
    fn is_leaf(&self) -> bool {
        self.children[0] == NONE
    }

    /// The other child.
    #[inline(always)]
    fn other_than(&self, child: u32) -> u32 {
        let [a, b] = self.children;
        if a == child { b } else { a }
    }
}
