// SPDX-License-Identifier: GPL-3.0-or-later
//! The node of the binary tree that wide nodes are made from.

use gnurt_accel_core::INVALID_ID;

use super::costs::{Costs, Shares};
use super::reference::{Lanes, Reference};
use crate::node::{Child, WIDTH};

/// Instead of a number of primitives.
const MADE: u32 = u32::MAX;

/// A node of a binary tree. Its children are relative to itself, so that trees may be concatenated.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub(super) bounds: Lanes,
    /// In a leaf the numbers of primitives; else the first two are the relative indices of the children.
    pub(super) numbers: [u32; WIDTH],
    /// Primitives of a leaf; 0 for an inner node, [`MADE`] for a finished subtree.
    pub(super) count: u32,
    /// The division of a wide node's slots between the children.
    pub(super) shares: Shares,
}

impl BinaryNode {
    /// Parts of one primitive count as one.
    pub(super) fn leaf(bounds: Lanes, references: &[Reference]) -> Self {
        let mut node = Self { bounds, numbers: [INVALID_ID; WIDTH], count: 0, shares: [0; WIDTH + 1] };
        for number in references.iter().map(Reference::number) {
            if !node.numbers.contains(&number) {
                node.numbers[node.count as usize] = number;
                node.count += 1;
            }
        }
        node
    }

    /// Represents a finished wide node or leaf block.
    pub(super) fn made(bounds: Lanes, child: Child) -> Self {
        let mut numbers = [INVALID_ID; WIDTH];
        numbers[0] = child.0;
        Self { bounds, numbers, count: MADE, shares: [0; WIDTH + 1] }
    }

    /// `back` is how far before it its children are, modulo 2^32.
    pub(super) fn inner(bounds: Lanes, back: [u32; 2], shares: Shares) -> Self {
        let mut numbers = [INVALID_ID; WIDTH];
        numbers[..2].copy_from_slice(&back);
        Self { bounds, numbers, count: 0, shares }
    }

    /// The finished subtree that it represents, if any.
    pub(super) fn as_made(&self) -> Option<Child> {
        (self.count == MADE).then_some(Child(self.numbers[0]))
    }

    /// Whether a leaf block is made of it.
    pub(super) fn is_leaf(&self) -> bool {
        self.as_made().map_or(self.count > 0, Child::is_leaf)
    }

    /// Where the children are of a node, no leaf, that is at `at`.
    pub(super) fn children(&self, at: usize) -> [usize; 2] {
        [0, 1].map(|side: usize| (at as u32).wrapping_sub(self.numbers[side]) as usize)
    }
}

/// Some adjacent primitives, and the subtree over them.
pub(super) struct Cluster {
    pub(super) child: Child,
    pub(super) costs: Costs,
}
