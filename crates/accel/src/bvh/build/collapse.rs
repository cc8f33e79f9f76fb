// SPDX-License-Identifier: GPL-3.0-or-later
//! Makes nodes of eight children from a binary tree, at the least cost that it allows.
//! Source: [YKL17] section 3.1: for each knot, from the leaves to the root, what it costs in so many places at most.
//! Invariant: no node is deeper than [`DEEPEST`], or there is no tree. Proof: `super::tests`.

use gnurt_simd::prefer_huge_pages;
use rayon::prelude::*;

use super::Tree;
use super::binary::Knot;
use super::crew::Crew;
use crate::bvh::{Child, Node8, WIDTH};

/// No node is of this depth or a greater one; the root has depth 0.
pub(crate) const DEEPEST: usize = 52;

/// Nodes of this depth and what is below them are made by one thread.
const ALONE: usize = 3;

/// Cost of a step through a node, in blocks.
const NODE: f32 = 1.0;

/// Least costs of what represents a knot in at most 1, 2 ... 7 places of a node; the first element is not used.
pub(super) type Costs = [f32; WIDTH];

/// Of so many places, those for the left child; 0 where one place less does as well. With 8 it is the node made of the knot
/// itself that has them.
pub(super) type Shares = [u8; WIDTH + 1];

/// Costs of a leaf of one block, given half its surface.
pub(super) fn leaf_costs(area: f32) -> Costs {
    [area; WIDTH]
}

/// Costs of a knot with two children, given half its surface, and how they share its places.
pub(super) fn inner_costs(area: f32, left: &Costs, right: &Costs) -> (Costs, Shares) {
    let (mut costs, mut shares) = ([f32::INFINITY; WIDTH], [0; WIDTH + 1]);
    for places in (2..=WIDTH).rev() {
        let (mut least, mut on_left) = (f32::INFINITY, 1);
        for share in 1..places {
            let cost = left[share] + right[places - share];
            if cost < least {
                (least, on_left) = (cost, share);
            }
        }
        shares[places] = on_left as u8;
        if places < WIDTH {
            costs[places] = least;
        } else {
            costs[1] = least + NODE * area;
        }
    }
    for places in 2..WIDTH {
        if costs[places - 1] <= costs[places] {
            costs[places] = costs[places - 1];
            shares[places] = 0;
        }
    }
    (costs, shares)
}

/// A node to be made of `knot`, to hang at `place` of node `parent`.
#[derive(Clone, Copy)]
struct Waiting {
    knot: usize,
    parent: usize,
    place: usize,
    depth: usize,
}

/// Some nodes and the blocks below them, with places of their own.
#[derive(Default)]
struct Piece {
    nodes: Vec<Node8>,
    blocks: Vec<[u32; WIDTH]>,
}

/// The wide tree; `None` where it would be too deep. Nodes come in the order of a walk that takes first children first,
/// whoever made them.
pub(super) fn collapse(knots: &[Knot], crew: Crew) -> Option<Tree> {
    let root = knots.last()?;
    let bounds = root.bounds.bounds();
    let first = Waiting { knot: knots.len() - 1, parent: 0, place: WIDTH, depth: 0 };
    let alone = if crew.parallel { ALONE } else { 0 };
    let mut parts = Vec::new();
    let mut waiting = vec![first];
    while let Some(next) = waiting.pop() {
        if next.depth == alone {
            parts.push((next, None));
            continue;
        }
        let mut piece = Piece::default();
        let from = waiting.len();
        piece.add(knots, next, &mut waiting);
        // Parents of what is below are places among the parts, as long as these have none.
        waiting[from..].iter_mut().for_each(|below| below.parent = parts.len());
        parts.push((next, Some(piece)));
    }
    let below = |(next, top): &mut (Waiting, Option<Piece>)| match top.take() {
        Some(piece) => Some(piece),
        None => Piece::below(knots, *next),
    };
    let pieces: Option<Vec<Piece>> = if crew.parallel {
        parts.par_iter_mut().map(below).collect()
    } else {
        parts.iter_mut().map(below).collect()
    };
    let pieces = pieces?;
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
    let moved = |(nodes, &[node, block]): (&mut Vec<Node8>, &[usize; 2])| {
        nodes.iter_mut().for_each(|one| one.move_children(node, block));
    };
    if crew.parallel {
        nodes.par_iter_mut().zip(&starts).for_each(moved);
    } else {
        nodes.iter_mut().zip(&starts).for_each(moved);
    }
    for (piece, (next, _)) in parts.iter().enumerate().skip(1) {
        let (bounds, index) = (knots[next.knot].bounds.bounds(), starts[piece][0]);
        nodes[next.parent][0].set(next.place, &bounds, Child::node(index));
    }
    let [node_count, block_count] = starts[starts.len() - 1];
    let mut tree = Tree {
        nodes: Vec::with_capacity(node_count),
        blocks: Vec::with_capacity(block_count),
        ..Tree::new(bounds)
    };
    prefer_huge_pages(&tree.nodes);
    crew.concat(&nodes, &mut tree.nodes);
    crew.concat(&blocks, &mut tree.blocks);
    Some(tree)
}

impl Piece {
    /// All that is below a knot; `None` where it would be too deep.
    fn below(knots: &[Knot], first: Waiting) -> Option<Self> {
        let mut piece = Self::default();
        let mut waiting = vec![Waiting { place: WIDTH, ..first }];
        while let Some(next) = waiting.pop() {
            if next.depth >= DEEPEST {
                return None;
            }
            if next.place < WIDTH {
                let index = piece.nodes.len();
                piece.nodes[next.parent].set(
                    next.place,
                    &knots[next.knot].bounds.bounds(),
                    Child::node(index),
                );
            }
            piece.add(knots, next, &mut waiting);
        }
        Some(piece)
    }

    /// Makes a node and its leaves; what else is below it goes to `waiting`, the first child on top.
    fn add(&mut self, knots: &[Knot], Waiting { knot, depth, .. }: Waiting, waiting: &mut Vec<Waiting>) {
        let index = self.nodes.len();
        let mut node = Node8::EMPTY;
        let (children, count) = open(knots, knot);
        for (place, &child) in children[..count].iter().enumerate().rev() {
            let knot = &knots[child];
            if knot.is_leaf() {
                node.set(place, &knot.bounds.bounds(), Child::leaf(self.blocks.len(), 1));
                self.blocks.push(knot.numbers);
            } else {
                waiting.push(Waiting { knot: child, parent: index, place, depth: depth + 1 });
            }
        }
        self.nodes.push(node);
    }
}

/// The knots that become children of the node made of `knot`, and how many they are.
fn open(knots: &[Knot], knot: usize) -> ([usize; WIDTH], usize) {
    let (mut children, mut count) = ([0; WIDTH], 0);
    // What is not yet opened, with the places that it may take; these are eight in all.
    let (mut closed, mut left) = ([(knot, WIDTH); WIDTH], 1);
    while left > 0 {
        left -= 1;
        let (knot, mut places) = closed[left];
        while places > 1 && knots[knot].shares[places] == 0 {
            places -= 1;
        }
        if places == 1 {
            children[count] = knot;
            count += 1;
            continue;
        }
        let on_left = knots[knot].shares[places] as usize;
        let [left_child, right_child] = knots[knot].children(knot);
        closed[left] = (right_child, places - on_left);
        closed[left + 1] = (left_child, on_left);
        left += 2;
    }
    (children, count)
}
