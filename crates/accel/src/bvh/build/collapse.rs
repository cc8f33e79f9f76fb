// SPDX-License-Identifier: GPL-3.0-or-later
//! Makes nodes of eight children from a binary tree, at the least cost that it allows.
//! Source: [YKL17] section 3.1: for each knot, from the leaves to the root, what it costs in so many places at most.
//! Invariant: no node is deeper than [`DEEPEST`], or there is no tree. Proof: `super::tests`.

use super::Tree;
use super::binary::Knot;
use crate::bvh::{Child, Node8, WIDTH};

/// No node is of this depth or a greater one; the root has depth 0.
pub(crate) const DEEPEST: usize = 52;

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

/// The wide tree; `None` where it would be too deep.
pub(super) fn collapse(knots: &[Knot]) -> Option<Tree> {
    let root = knots.last()?;
    let mut tree = Tree { nodes: Vec::new(), blocks: Vec::new(), bounds: root.bounds.bounds() };
    let mut waiting = vec![Waiting { knot: knots.len() - 1, parent: 0, place: WIDTH, depth: 0 }];
    while let Some(Waiting { knot, parent, place, depth }) = waiting.pop() {
        if depth >= DEEPEST {
            return None;
        }
        let index = tree.nodes.len();
        if place < WIDTH {
            tree.nodes[parent].set(place, &knots[knot].bounds.bounds(), Child::node(index));
        }
        let mut node = Node8::EMPTY;
        let (children, count) = open(knots, knot);
        for (place, &child) in children[..count].iter().enumerate().rev() {
            let knot = &knots[child];
            if knot.count > 0 {
                node.set(place, &knot.bounds.bounds(), Child::leaf(tree.blocks.len(), 1));
                tree.blocks.push(knot.numbers);
            } else {
                waiting.push(Waiting { knot: child, parent: index, place, depth: depth + 1 });
            }
        }
        tree.nodes.push(node);
    }
    tree.nodes.shrink_to_fit();
    tree.blocks.shrink_to_fit();
    Some(tree)
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
        closed[left] = (right_of(knot), places - on_left);
        closed[left + 1] = (left_of(knots, knot), on_left);
        left += 2;
    }
    (children, count)
}

fn right_of(knot: usize) -> usize {
    knot - 1
}

fn left_of(knots: &[Knot], knot: usize) -> usize {
    knot - 1 - knots[knot].numbers[0] as usize
}
