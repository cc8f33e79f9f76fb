// SPDX-License-Identifier: GPL-3.0-or-later
//! Makes nodes of eight children from a binary tree, at the least possible cost.
//! Source: [YKL17] section 3.1: for each node, from the leaves to the root, its least cost in a limited
//! number of slots.
//! Invariant: no node is deeper than [`DEEPEST`], or there is no tree. Tests: `super::tests`.

use gnurt_accel_core::threads::{Pieces, for_each, map};
use gnurt_simd::prefer_huge_pages;

use super::binary_node::BinaryNode;
use super::task_pool::TaskPool;
use crate::node::{Child, Node8, WIDTH};
use crate::tree::{DEEPEST, Tree};

/// Nodes of this depth and their subtrees are made by one thread.
const SINGLE_DEPTH: usize = 3;

/// A pending node, made of `from`, at `lane` of node `parent`.
#[derive(Clone, Copy)]
struct Pending {
    from: usize,
    parent: usize,
    lane: usize,
    depth: usize,
}

/// The input of wide nodes.
struct Source<'a> {
    binary: &'a [BinaryNode],
    made: &'a [Node8],
}

/// Some nodes and the blocks below them, with indices of their own.
#[derive(Default)]
struct Piece {
    nodes: Vec<Node8>,
    blocks: Vec<[u32; WIDTH]>,
}

/// The wide tree; `None` if it would be too deep. `made` are the finished subtrees of binary leaves. Nodes
/// are in depth-first order, first children first, independent of threads.
pub(super) fn collapse(binary: &[BinaryNode], made: &[Node8], tasks: TaskPool) -> Option<Tree> {
    let source = Source { binary, made };
    let root = binary.last()?;
    let bounds = root.bounds.bounds();
    let first = Pending { from: binary.len() - 1, parent: 0, lane: WIDTH, depth: 0 };
    let single_depth = if tasks.parallel { SINGLE_DEPTH } else { 0 };
    let mut parts = Vec::new();
    let mut waiting = vec![first];
    while let Some(next) = waiting.pop() {
        if next.depth == single_depth {
            parts.push((next, None));
            continue;
        }
        let mut piece = Piece::default();
        let from = waiting.len();
        piece.add(&source, next, &mut waiting);
        // Parents of pending subtrees are indices of the parts, as long as these have none.
        waiting[from..].iter_mut().for_each(|below| below.parent = parts.len());
        parts.push((next, Some(piece)));
    }
    let below = |(next, top): &mut (Pending, Option<Piece>)| match top.take() {
        Some(piece) => Some(piece),
        None => Piece::below(&source, *next),
    };
    let in_pieces = Pieces::new(&mut parts, 1);
    let pieces = map(tasks.parallel, in_pieces.count(), |i| below(&mut in_pieces.lock(i)[0]));
    let pieces = pieces.into_iter().collect::<Option<Vec<Piece>>>()?;
    // Where each piece starts in the whole; roots of pieces get known to their parents.
    let mut starts = vec![[0, 0]];
    for piece in &pieces {
        let [nodes, blocks] = starts[starts.len() - 1];
        starts.push([nodes + piece.nodes.len(), blocks + piece.blocks.len()]);
    }
    let mut nodes: Vec<Vec<Node8>> = Vec::with_capacity(pieces.len());
    let mut blocks = Vec::with_capacity(pieces.len());
    for piece in pieces {
        nodes.push(piece.nodes);
        blocks.push(piece.blocks);
    }
    let in_pieces = Pieces::new(&mut nodes, 1);
    for_each(tasks.parallel, in_pieces.count(), &|i| {
        let [node, block] = starts[i];
        in_pieces.lock(i)[0].iter_mut().for_each(|one| one.move_children(node, block));
    });
    for (piece, (next, _)) in parts.iter().enumerate().skip(1) {
        let (bounds, index) = (binary[next.from].bounds.bounds(), starts[piece][0]);
        nodes[next.parent][0].set(next.lane, &bounds, Child::node(index));
    }
    let [node_count, block_count] = starts[starts.len() - 1];
    let mut tree = Tree {
        nodes: Vec::with_capacity(node_count),
        blocks: Vec::with_capacity(block_count),
        ..Tree::new(bounds)
    };
    prefer_huge_pages(&tree.nodes);
    tasks.concat(&nodes, &mut tree.nodes);
    tasks.concat(&blocks, &mut tree.blocks);
    Some(tree)
}

impl Piece {
    /// All that is below a node; `None` where it would be too deep.
    fn below(source: &Source, first: Pending) -> Option<Self> {
        let mut piece = Self::default();
        let mut waiting = vec![Pending { lane: WIDTH, ..first }];
        while let Some(next) = waiting.pop() {
            if next.depth >= DEEPEST {
                return None;
            }
            if next.lane < WIDTH {
                let index = piece.nodes.len();
                let bounds = source.binary[next.from].bounds.bounds();
                piece.nodes[next.parent].set(next.lane, &bounds, Child::node(index));
            }
            piece.add(source, next, &mut waiting);
        }
        Some(piece)
    }

    /// Makes a node and its leaves; its other subtrees go to `waiting`, the first child on top.
    fn add(
        &mut self,
        &Source { binary, made }: &Source,
        Pending { from, depth, .. }: Pending,
        waiting: &mut Vec<Pending>,
    ) {
        let index = self.nodes.len();
        if let Some(child) = binary[from].as_made().filter(|child| !child.is_leaf()) {
            return self.nodes.push(made[child.index()]);
        }
        let mut node = Node8::EMPTY;
        let (mut children, count) = open(binary, from);
        by_priority(binary, &mut children[..count]);
        for (lane, &child) in children[..count].iter().enumerate().rev() {
            let from = &binary[child];
            if !from.is_leaf() {
                waiting.push(Pending { from: child, parent: index, lane, depth: depth + 1 });
            } else if let Some(block) = from.as_made() {
                node.set(lane, &from.bounds.bounds(), block);
            } else {
                node.set(lane, &from.bounds.bounds(), Child::leaf(self.blocks.len(), 1));
                self.blocks.push(from.numbers);
            }
        }
        self.nodes.push(node);
    }
}

/// Orders children for rays without an order, the first to visit last: leaves, where a ray may end, after
/// inner nodes, and large ones, which more rays hit, after small ones.
fn by_priority(binary: &[BinaryNode], children: &mut [usize]) {
    let priority = |child: usize| {
        let node = &binary[child];
        (node.is_leaf(), node.bounds.bounds().half_area() as f32)
    };
    let mut priorities = [(false, 0.0); WIDTH];
    for i in 0..children.len() {
        let (child, mine) = (children[i], priority(children[i]));
        let mut at = i;
        while at > 0 && priorities[at - 1] > mine {
            (children[at], priorities[at]) = (children[at - 1], priorities[at - 1]);
            at -= 1;
        }
        (children[at], priorities[at]) = (child, mine);
    }
}

/// The nodes that become children of the node made of `node`, and how many they are.
fn open(binary: &[BinaryNode], from: usize) -> ([usize; WIDTH], usize) {
    let (mut children, mut count) = ([0; WIDTH], 0);
    // Unopened nodes, with their numbers of slots, eight in total.
    let (mut closed, mut left) = ([(from, WIDTH); WIDTH], 1);
    while left > 0 {
        left -= 1;
        let (from, mut slots) = closed[left];
        while slots > 1 && binary[from].shares[slots] == 0 {
            slots -= 1;
        }
        if slots == 1 {
            children[count] = from;
            count += 1;
            continue;
        }
        let on_left = binary[from].shares[slots] as usize;
        let [left_child, right_child] = binary[from].children(from);
        closed[left] = (right_child, slots - on_left);
        closed[left + 1] = (left_child, on_left);
        left += 2;
    }
    (children, count)
}
