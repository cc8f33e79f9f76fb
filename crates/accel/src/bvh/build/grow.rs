// SPDX-License-Identifier: GPL-3.0-or-later
//! Growing wide nodes: of a node's children the largest is divided until there are eight.
//! Source: [WBB08] for the choice of the child; original in that no binary tree is made first.
//! Invariant: no leaf lies deeper than [`DEEPEST`]. Proof: `super::tests`.

use super::Tree;
use super::bins::{Mapping, best_split, half_area};
use super::reference::{Part, Reference};
use crate::INVALID_ID;
use crate::bvh::{Child, Node8, WIDTH};

/// From this depth on nodes divide by number alone.
const BY_NUMBER: usize = 40;

/// No leaf hangs at a node of this depth or a greater one; the root has depth 0.
pub(crate) const DEEPEST: usize = BY_NUMBER + 12;

/// What nodes and blocks are made from.
pub(super) struct Grower<'a> {
    pub(super) references: &'a mut [Reference],
    /// Sides of boxes are multiplied with this before their area is taken.
    pub(super) scale: f32,
    pub(super) tree: &'a mut Tree,
}

impl Grower<'_> {
    /// Appends the node of `part` and all that is below; returns its index.
    pub(super) fn grow(&mut self, part: Part, depth: usize) -> usize {
        let mut parts = [Part::empty(0); WIDTH];
        parts[0] = part;
        let mut count = 1;
        while count < WIDTH {
            let Some(chosen) = self.largest(&parts[..count], depth) else { break };
            let halves = self.divide(&parts[chosen], depth);
            [parts[chosen], parts[count]] = halves;
            count += 1;
        }
        let index = self.tree.nodes.len();
        self.tree.nodes.push(Node8::EMPTY);
        for (place, part) in parts[..count].iter().enumerate() {
            let child =
                if is_leaf(part) { self.leaf(part) } else { Child::node(self.grow(*part, depth + 1)) };
            self.tree.nodes[index].set(place, &part.bounds, child);
        }
        index
    }

    /// The part to divide next: that of the largest area, or of the greatest number where depth has run out.
    fn largest(&self, parts: &[Part], depth: usize) -> Option<usize> {
        let size = |part: &Part| match depth < BY_NUMBER {
            true => half_area(&part.bounds, self.scale),
            false => part.count() as f32,
        };
        let divisible = parts.iter().enumerate().filter(|(_, part)| !is_leaf(part));
        divisible.max_by(|a, b| size(a.1).total_cmp(&size(b.1))).map(|(i, _)| i)
    }

    fn divide(&mut self, part: &Part, depth: usize) -> [Part; 2] {
        let Part { start, end, .. } = *part;
        let references = &mut self.references[start..end];
        let split = if depth < BY_NUMBER { best_split(references, part, self.scale) } else { None };
        let left = match split {
            Some(split) => {
                let mapping = Mapping::new(&part.middles);
                partition(references, |reference| mapping.bin(reference, split.axis) < split.border)
            }
            // Whole blocks go left.
            None => references.len().div_ceil(2).next_multiple_of(WIDTH),
        };
        let border = start + left;
        [Part::around(self.references, start, border), Part::around(self.references, border, end)]
    }

    fn leaf(&mut self, part: &Part) -> Child {
        let first = self.tree.blocks.len();
        for references in self.references[part.start..part.end].chunks(WIDTH) {
            let mut block = [INVALID_ID; WIDTH];
            for (slot, reference) in block.iter_mut().zip(references) {
                *slot = reference.number;
            }
            self.tree.blocks.push(block);
        }
        Child::leaf(first, self.tree.blocks.len() - first)
    }
}

/// Whether a part is not to be divided: it fits a block, or nothing tells its primitives apart and it fits a leaf.
fn is_leaf(part: &Part) -> bool {
    let in_one_place = part.middles.min == part.middles.max;
    part.count() <= WIDTH || in_one_place && part.count() <= WIDTH * Child::MOST_BLOCKS
}

/// Moves what belongs left to the front; returns how many that is.
fn partition(references: &mut [Reference], goes_left: impl Fn(&Reference) -> bool) -> usize {
    let (mut left, mut right) = (0, references.len());
    while left < right {
        if goes_left(&references[left]) {
            left += 1;
        } else {
            right -= 1;
            references.swap(left, right);
        }
    }
    left
}
