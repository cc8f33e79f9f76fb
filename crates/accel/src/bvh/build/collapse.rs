// SPDX-License-Identifier: GPL-3.0-or-later
//! Makes nodes of eight children from a binary tree, at the least cost that it allows.
//! Source: [YKL17] section 3.1: what `i` places at most cost for each knot, from the leaves to the root.
//! Invariant: no node is deeper than [`DEEPEST`], or there is no tree. Proof: `super::tests`.

use super::Tree;
use super::binary::Knot;
use super::grow::DEEPEST;
use crate::bvh::{Child, Node8, WIDTH};

/// Cost of a step through a node, in blocks.
const NODE: f32 = 1.0;

/// How a knot is best represented in so many places of a node.
#[derive(Clone, Copy)]
struct Choice {
    /// Least cost with at most 1, 2 ... 7 places; the first element is not used.
    costs: [f32; WIDTH],
    /// Of so many places, those for the left child; 0 where one place less does as well. With 8 it is the node made of
    /// the knot itself that has them.
    left: [u8; WIDTH + 1],
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
pub(super) fn collapse(knots: &[Knot], scale: f32) -> Option<Tree> {
    let root = knots.last()?;
    let choices = choose(knots, scale);
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
        let (children, count) = open(knots, &choices, knot);
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
fn open(knots: &[Knot], choices: &[Choice], knot: usize) -> ([usize; WIDTH], usize) {
    let (mut children, mut count) = ([0; WIDTH], 0);
    // What is not yet opened, with the places that it may take; these are eight in all.
    let (mut closed, mut left) = ([(knot, WIDTH); WIDTH], 1);
    while left > 0 {
        left -= 1;
        let (knot, mut places) = closed[left];
        while places > 1 && choices[knot].left[places] == 0 {
            places -= 1;
        }
        if places == 1 {
            children[count] = knot;
            count += 1;
            continue;
        }
        let on_left = choices[knot].left[places] as usize;
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

/// The costs of all knots; children come first.
fn choose(knots: &[Knot], scale: f32) -> Vec<Choice> {
    let mut choices: Vec<Choice> = Vec::with_capacity(knots.len());
    for (i, knot) in knots.iter().enumerate() {
        let area = knot.bounds.half_area(scale);
        if knot.count > 0 {
            choices.push(Choice { costs: [area; WIDTH], left: [0; WIDTH + 1] });
            continue;
        }
        let (left, right) = (&choices[left_of(knots, i)], &choices[right_of(i)]);
        let mut choice = Choice { costs: [f32::INFINITY; WIDTH], left: [0; WIDTH + 1] };
        for places in (2..=WIDTH).rev() {
            let (mut least, mut at) = (f32::INFINITY, 1);
            for on_left in 1..places {
                let cost = left.costs[on_left] + right.costs[places - on_left];
                if cost < least {
                    (least, at) = (cost, on_left);
                }
            }
            choice.left[places] = at as u8;
            if places < WIDTH {
                choice.costs[places] = least;
            } else {
                choice.costs[1] = least + NODE * area;
            }
        }
        for places in 2..WIDTH {
            if choice.costs[places - 1] <= choice.costs[places] {
                choice.costs[places] = choice.costs[places - 1];
                choice.left[places] = 0;
            }
        }
        choices.push(choice);
    }
    choices
}
