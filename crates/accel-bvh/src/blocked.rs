// SPDX-License-Identifier: GPL-3.0-or-later
//! A wide BVH with leaf blocks of eight primitives: the common part of spheres, user geometry and instances.
//! Space: that of the primitives. Tests: `tests/mixed.rs` of `gnurt-accel`, `boxes::tests`.

use gnurt_accel_core::{Aabb, BuildError, Memory, Quality, Threads, TreeStats};

use crate::build::build;
use crate::node::WIDTH;
use crate::primitives::Primitives;
use crate::tree::Tree;

/// Tree and blocks.
#[derive(Clone, Debug)]
pub(crate) struct Blocked<B> {
    pub(crate) tree: Tree,
    pub(crate) blocks: Vec<B>,
    /// The greatest coordinate of any plane.
    pub(crate) greatest: f32,
    stats: TreeStats,
}

impl<B> Blocked<B> {
    /// Over all primitives; `block` makes a block of the numbers of up to eight, padded with `INVALID_ID`.
    ///
    /// # Errors
    /// That there are too many.
    pub(crate) fn build(
        primitives: &impl Primitives,
        quality: Quality,
        memory: Memory,
        threads: Threads,
        block: impl Fn(&[u32; WIDTH]) -> B,
    ) -> Result<Self, BuildError> {
        let mut tree = build(primitives, quality, threads)?;
        tree.settle(memory);
        let stats = tree.measure();
        let blocks = std::mem::take(&mut tree.blocks).iter().map(block).collect();
        Ok(Self { blocks, greatest: tree.greatest(), tree, stats })
    }

    /// From saved parts; the tree is measured after it was checked.
    pub(crate) fn of_parts(tree: Tree, blocks: Vec<B>) -> Self {
        Self { greatest: tree.greatest(), tree, blocks, stats: TreeStats::default() }
    }

    /// Measures a valid tree, whose blocks hold this number of references.
    pub(crate) fn measure_again(&mut self, references: u64) {
        self.stats = TreeStats { references, ..self.tree.measure() };
    }

    /// Its nodes have other boxes, of this cost.
    pub(crate) fn refitted(&mut self, cost: f64) {
        (self.greatest, self.stats.sah_cost) = (self.tree.greatest(), cost);
    }

    /// Box around everything.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// Size and shape.
    pub(crate) fn stats(&self) -> TreeStats {
        TreeStats {
            primitives: self.stats.references,
            tree_bytes: self.tree.node_bytes() as u64,
            primitive_bytes: size_of_val(&self.blocks[..]) as u64,
            ..self.stats
        }
    }

    /// Whether nodes are the small ones.
    pub(crate) fn is_compact(&self) -> bool {
        self.tree.is_compact()
    }
}
