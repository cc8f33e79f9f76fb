// SPDX-License-Identifier: GPL-3.0-or-later
//! Growing wide nodes: of a node's parts the largest is divided until there are eight.
//! Source: [WBB08] for the choice of the part; original in that no binary tree is made first.
//! Invariant: no leaf lies deeper than [`DEEPEST`]; nodes are in depth-first order. Proof: `super::tests`.

use gnurt_simd::Simd;

use super::Tree;
use super::bins::{Bins, bin};
use super::partition::{Buffer, partition};
use super::reference::{Part, Reference};
use crate::INVALID_ID;
use crate::bvh::{Child, Node8, WIDTH};

/// From this depth on nodes divide by number alone.
pub(super) const BY_NUMBER: usize = 40;

/// No node is of this depth or a greater one; the root has depth 0.
pub(crate) const DEEPEST: usize = BY_NUMBER + 12;

/// The parts that become the children of a node.
#[derive(Clone, Copy)]
pub(super) struct Spread {
    parts: [Part; WIDTH],
    count: usize,
}

/// Memory that growing uses again and again.
pub(super) struct Workspace {
    bins: Bins,
    buffer: Buffer,
}

impl Workspace {
    pub(super) const EMPTY: Self = Self { bins: Bins::EMPTY, buffer: Buffer::EMPTY };
}

impl Spread {
    pub(super) fn parts(&self) -> &[Part] {
        &self.parts[..self.count]
    }

    /// Divides `part` until there are eight parts, or nothing left to divide; `divide` cuts one in two.
    #[inline(always)]
    pub(super) fn new(
        part: Part,
        depth: usize,
        scale: f32,
        mut divide: impl FnMut(&Part) -> [Part; 2],
    ) -> Self {
        let mut spread = Self { parts: [Part::EMPTY; WIDTH], count: 1 };
        let mut sizes = [f32::NEG_INFINITY; WIDTH];
        let size = |part: &Part| {
            // Where depth has run out the fullest is divided.
            let size = if depth < BY_NUMBER { part.bounds.half_area(scale) } else { part.count() as f32 };
            if is_leaf(part) { f32::NEG_INFINITY } else { size }
        };
        spread.parts[0] = part;
        sizes[0] = size(&part);
        while spread.count < WIDTH {
            let mut largest = 0;
            for i in 1..spread.count {
                largest = if sizes[i] > sizes[largest] { i } else { largest };
            }
            if sizes[largest] == f32::NEG_INFINITY {
                break;
            }
            let [left, right] = divide(&spread.parts[largest]);
            for (place, part) in [(largest, left), (spread.count, right)] {
                spread.parts[place] = part;
                sizes[place] = size(&part);
            }
            spread.count += 1;
        }
        spread
    }
}

/// Cuts `part` of `references` in two.
#[inline(always)]
pub(super) fn divide<S: Simd>(
    simd: S,
    references: &mut [Reference],
    part: &Part,
    depth: usize,
    scale: f32,
    workspace: &mut Workspace,
) -> [Part; 2] {
    let Part { start, end, .. } = *part;
    let inside = &mut references[start..end];
    if depth < BY_NUMBER {
        let Workspace { bins, buffer } = workspace;
        let mapping = bin(simd, inside, part, bins);
        if let Some(split) = bins.best_split(simd, scale) {
            let [left, right] = bins.sides(simd, &split);
            let parted = partition(simd, inside, &mapping, &split, buffer);
            let border = start + parted.left;
            let [left_middles, right_middles] = parted.middles;
            return [
                Part { start, end: border, bounds: left, middles: left_middles },
                Part { start: border, end, bounds: right, middles: right_middles },
            ];
        }
    }
    let border = start + halfway(inside.len());
    [Part::around(simd, references, start, border), Part::around(simd, references, border, end)]
}

/// Half of `count`, in whole blocks; less than `count`, which does not fit one block.
pub(super) fn halfway(count: usize) -> usize {
    (count / 2).next_multiple_of(WIDTH)
}

/// A node to be made of `part` of the references, to hang at `place` of node `parent`.
#[derive(Clone, Copy)]
struct Waiting {
    part: Part,
    parent: usize,
    place: usize,
    depth: usize,
}

/// Appends to `tree` the node of `part` of `references`, which has `depth`, and all that is below it.
#[inline(always)]
pub(super) fn grow<S: Simd>(
    simd: S,
    references: &mut [Reference],
    part: Part,
    depth: usize,
    scale: f32,
    tree: &mut Tree,
) {
    let mut workspace = Workspace::EMPTY;
    let root = tree.nodes.len();
    let mut waiting = vec![Waiting { part, parent: root, place: WIDTH, depth }];
    while let Some(Waiting { part, parent, place, depth }) = waiting.pop() {
        let index = tree.nodes.len();
        if place < WIDTH {
            tree.nodes[parent].set(place, &part.bounds.bounds(), Child::node(index));
        }
        let spread = Spread::new(
            part,
            depth,
            scale,
            #[inline(always)]
            |part| divide(simd, references, part, depth, scale, &mut workspace),
        );
        let mut node = Node8::EMPTY;
        for (place, part) in spread.parts().iter().enumerate().rev() {
            if is_leaf(part) {
                let leaf = push_leaf(&mut tree.blocks, &references[part.start..part.end]);
                node.set(place, &part.bounds.bounds(), leaf);
            } else {
                waiting.push(Waiting { part: *part, parent: index, place, depth: depth + 1 });
            }
        }
        tree.nodes.push(node);
    }
}

/// Appends the blocks of a leaf.
#[inline(always)]
pub(super) fn push_leaf(blocks: &mut Vec<[u32; WIDTH]>, references: &[Reference]) -> Child {
    let first = blocks.len();
    for references in references.chunks(WIDTH) {
        let mut block = [INVALID_ID; WIDTH];
        for (slot, reference) in block.iter_mut().zip(references) {
            *slot = reference.number();
        }
        blocks.push(block);
    }
    Child::leaf(first, blocks.len() - first)
}

/// Whether a part is not to be divided: it fits a block, or nothing tells its primitives apart and it fits a leaf.
#[inline(always)]
pub(super) fn is_leaf(part: &Part) -> bool {
    let count = part.count();
    if count <= WIDTH {
        return true;
    }
    let in_one_place = (0..3).all(|axis| part.middles.side(axis) == 0.0);
    in_one_place && count <= WIDTH * Child::MOST_BLOCKS
}
