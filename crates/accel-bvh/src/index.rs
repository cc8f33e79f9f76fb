// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's triangles under a wide BVH.
//! Space: object. Tests: `tests/brute_force.rs` of `gnurt-accel`.

mod store;

pub(crate) use store::Whole;

use std::sync::{Arc, OnceLock};

use gnurt_accel_core::control::Watch;
use gnurt_accel_core::{Aabb, BuildError, INVALID_ID, Memory, Quality, Threads, TreeStats};

use crate::build::{build_along_curve, try_build};
use crate::leaves::Leaves;
use crate::pose::Structure;
use crate::refit::Moving;
use crate::screen::Screen;
use crate::tree::Tree;

/// Tree and triangles.
#[derive(Clone, Debug)]
pub struct BvhIndex {
    pub(crate) tree: Tree,
    pub(crate) leaves: Leaves,
    /// The greatest coordinate of any plane.
    pub(crate) greatest: f32,
    pub(crate) stats: TreeStats,
    /// Once it has been refitted.
    pub(crate) moving: Option<Box<Moving>>,
    /// The part that it shares with its poses, after the first one was made.
    pub(crate) structure: OnceLock<Arc<Structure>>,
    /// Of a pose: the expected cost of a ray below the root.
    pub(crate) cost: f32,
}

/// Whether two have the same nodes and blocks.
impl PartialEq for BvhIndex {
    fn eq(&self, other: &Self) -> bool {
        (&self.tree, &self.leaves) == (&other.tree, &other.leaves)
    }
}

impl BvhIndex {
    /// Builds over the good triangles.
    ///
    /// # Errors
    /// That `watch` stopped it, or that there are more blocks than leaves can number.
    pub fn build(
        screen: &mut Screen,
        quality: Quality,
        memory: Memory,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        if quality == Quality::Fast {
            let middles = screen.take_middles();
            let leaves = |blocks: &[_]| Leaves::boxed(screen, memory, blocks, threads, watch);
            let built = threads.run(|parallel| build_along_curve(middles, leaves, parallel, watch));
            let (mut tree, leaves) = built?;
            tree.settle(memory);
            let stats = tree.measure();
            watch.give(size_of_val(&tree.blocks[..]));
            tree.blocks = Vec::new();
            return Ok(Self { leaves, ..Self::of_tree(tree, stats) });
        }
        let references = screen.take_references();
        let mut tree = try_build(screen, references, quality, threads, watch)?;
        let mut held = tree.node_bytes();
        tree.settle(memory);
        watch.recount(&mut held, tree.node_bytes());
        let stats = tree.measure();
        let mut in_blocks = std::mem::take(&mut tree.blocks);
        for number in in_blocks.as_flattened_mut().iter_mut().filter(|number| **number != INVALID_ID) {
            *number = screen.good[*number as usize];
        }
        let leaves = Leaves::build(screen, memory, &in_blocks, threads, watch)?;
        watch.give(size_of_val(&in_blocks[..]));
        Ok(Self { leaves, ..Self::of_tree(tree, stats) })
    }

    /// Of a tree whose leaves are to come.
    pub(crate) fn of_tree(tree: Tree, stats: TreeStats) -> Self {
        let (greatest, leaves) = (tree.greatest(), Leaves::default());
        Self { tree, leaves, greatest, stats, moving: None, structure: OnceLock::new(), cost: 0.0 }
    }

    /// Box around all triangles.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        let moving = self.moving.as_deref().map_or(0, Moving::memory_bytes);
        // The part that poses share belongs to none of them.
        let shared = if self.is_posed() { size_of_val(&self.tree.children[..]) } else { 0 };
        TreeStats {
            tree_bytes: (self.tree.node_bytes() + moving - shared) as u64,
            primitive_bytes: self.leaves.memory_bytes() as u64,
            ..self.stats
        }
    }
}

/// Rays with more expected cache misses than this are interleaved: the least of six scenes for which it pays
/// has 8.9, the most for which it does not 7.6.
const WORTH_INTERLEAVING: f32 = 8.0;

/// The part of a tree that a core's own cache holds, in bytes.
const CACHED: f32 = 2e6;

impl BvhIndex {
    /// Whether an incoherent ray misses the cache often: from its expected visits, and the part of the tree
    /// outside of the cache. Compact trees are never interleaved.
    pub(crate) fn waits_for_memory(&self) -> bool {
        let bytes = size_of_val(&self.tree.nodes[..]) + size_of_val(&self.leaves.blocks[..]);
        let elsewhere = 1.0 - CACHED / (bytes as f32).max(CACHED);
        self.stats.sah_cost as f32 * elsewhere > WORTH_INTERLEAVING
    }
}
