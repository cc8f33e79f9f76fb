// SPDX-License-Identifier: GPL-3.0-or-later
//! Saving and loading of a kd-tree's nodes. The format is that of `crate::store`.
//! Invariant: a loaded tree has children after their parents, none deeper than the stack allows; the lists of
//! its leaves stay within bounds. Tests: `tests/saved.rs`.

use super::{DEEPEST, EMPTY_LEAF, KdTree, Node};
use gnurt_accel_core::store::{LoadError, StoredRecord};

impl StoredRecord for Node {
    const LENGTH: usize = 2;

    #[inline(always)]
    fn put(&self, words: &mut [u32]) {
        words.copy_from_slice(&[self.left, self.value_or_item]);
    }

    #[inline(always)]
    fn get(words: &[u32]) -> Self {
        Self { left: words[0], value_or_item: words[1] }
    }
}

impl KdTree {
    /// Checks all properties that a traversal relies on, except for non-empty leaves: `leaf` checks those, in
    /// the order of their nodes.
    pub(crate) fn check(&self, mut leaf: impl FnMut(Node) -> Result<(), LoadError>) -> Result<(), LoadError> {
        let damaged = |what| Err(LoadError::Damaged(what));
        let Self { nodes, bounds, .. } = self;
        if nodes.is_empty() || bounds.is_empty() && nodes[..] != [EMPTY_LEAF] {
            return damaged("its bounds are not those of its nodes");
        }
        // One more than the depth of each node whose parent has been seen.
        let mut depths = vec![0u8; nodes.len()];
        depths[0] = 1;
        for (at, &node) in nodes.iter().enumerate() {
            let depth = depths[at];
            if depth == 0 {
                return damaged("a node has no parent before it");
            }
            if node == EMPTY_LEAF {
                continue;
            }
            if node.is_leaf() {
                leaf(node)?;
                continue;
            }
            let left = node.left() as usize;
            if left <= at || depths.get(left..).and_then(|rest| rest.get(..2)) != Some(&[0, 0]) {
                return damaged("a node is the child of several, or does not exist");
            }
            if node.axis() > 2 || !node.plane().is_finite() {
                return damaged("invalid plane");
            }
            if depth as usize >= DEEPEST {
                return damaged("it is too deep");
            }
            depths[left..left + 2].fill(depth + 1);
        }
        Ok(())
    }

    /// The same, with leaves that are lists of triangles, of which there are `count`.
    pub(crate) fn check_lists(&self, count: u32) -> Result<(), LoadError> {
        let damaged = |what| Err(LoadError::Damaged(what));
        let items = &self.items;
        if items.first() != Some(&0) {
            return damaged("it has no list for empty leaves");
        }
        let mut listed = 1;
        self.check(|leaf| {
            let list = items.get(leaf.item()..).and_then(<[u32]>::split_first);
            let Some(numbers) = list.and_then(|(&length, rest)| rest.get(..length as usize)) else {
                return damaged("a leaf's list does not exist");
            };
            if !numbers.iter().all(|&number| number < count) {
                return damaged("a leaf names a triangle that does not exist");
            }
            // Lists that overlap take more time than the file explains.
            listed += 1 + numbers.len();
            if listed > items.len() { damaged("lists of leaves overlap") } else { Ok(()) }
        })?;
        if listed == items.len() { Ok(()) } else { damaged("a list is in no leaf") }
    }
}
