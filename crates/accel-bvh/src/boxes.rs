// SPDX-License-Identifier: GPL-3.0-or-later
//! Boxes under a wide BVH, entered by the caller: the top tree over the instances of a scene.
//! Source: [WBS03a] for the two levels. A kd-tree would list large instances again and again, and an object costs far
//! more than a triangle to test twice. A leaf block is eight boxes again, with their places as children, so that a ray
//! meets eight of them in one test.
//! Boxes that lie near each other are in one [`Treelet`], and an upper one is over those, so that who changes a box makes one
//! treelet and the upper one anew and shares all others with the tree before. A few boxes are one treelet, and no more.
//! Boxes that move while the shutter is open are around all of their way; rays, which know their moment, meet them where they are
//! (`treelet/keys.rs`).
//! Space: that of the boxes, which are relative to an origin. Invariant: a box is in one treelet, and `owners` tells in which.
//! Tests: `build::tests`, `update::tests`, `tests/instances.rs` and `tests/moving_instances.rs` of `gnurt-accel`.

mod build;
mod met;
mod search;
mod tile;
mod update;

use gnurt_accel_core::{Aabb, Quality, SharedList, TreeStats};

use crate::treelet::{NodesAtKeys, Treelet};

pub use met::{EnterMembers, Member, MetBlock};
pub use update::BoxEdit;

/// Slack beyond which every ray meets every box.
const MOST_SLACK: f32 = 1e7;

/// Tree over boxes by their places in a list. A clone shares all of it.
#[derive(Clone, Debug)]
pub struct BoxIndex {
    treelets: Vec<Treelet>,
    /// Over the boxes of treelets, its members their numbers; empty where there is one treelet, or none.
    upper: Treelet,
    /// By place: the number of the treelet and 1; 0 without a box.
    owners: SharedList<u32>,
    /// Boxes are relative to it.
    origin: [f32; 3],
    /// Around everything, at every moment.
    bounds: Aabb,
    /// The greatest coordinate of any plane.
    greatest: f32,
    /// See [`BoxIndex::with_slack`].
    slack: f32,
    quality: Quality,
    /// How many boxes there are.
    count: usize,
    /// Its [`BoxIndex::cost`], and how many treelets there were, when all of it was built.
    built_cost: f64,
    built_treelets: usize,
}

impl BoxIndex {
    /// What boxes are relative to.
    #[must_use]
    pub fn origin(&self) -> [f32; 3] {
        self.origin
    }

    /// Box around everything, relative to the origin.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// How many boxes there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The place of the only box, where there is one only.
    #[must_use]
    pub fn only(&self) -> Option<usize> {
        let mut members = self.treelets.iter().flat_map(Treelet::members);
        if self.count == 1 { members.next().map(|(index, _)| index as usize) } else { None }
    }

    /// How carefully it is built.
    #[must_use]
    pub fn quality(&self) -> Quality {
        self.quality
    }

    pub(crate) fn treelets(&self) -> &[Treelet] {
        &self.treelets
    }

    pub(crate) fn upper(&self) -> &Treelet {
        &self.upper
    }

    /// The greatest coordinate of any plane.
    pub(crate) fn greatest(&self) -> f32 {
        self.greatest
    }

    /// The same tree whose boxes are met so many times as far beside them as rounding by itself asks for: callers that carry
    /// rays into a member's space may round by more than what boxes allow for. At least 1.
    #[must_use]
    pub fn with_slack(self, slack: f32) -> Self {
        Self { slack: slack.clamp(1.0, MOST_SLACK), ..self }
    }

    /// How much slack its boxes have.
    #[must_use]
    pub fn slack(&self) -> f32 {
        self.slack
    }

    /// The greatest coordinate that gives rays, of whose origins `away` is the greatest one, as much slack as they need:
    /// `slab.rs` of `gnurt-accel-core` takes its double and `away` together.
    #[inline(always)]
    pub(crate) fn greatest_for(&self, away: impl FnOnce() -> f32) -> f32 {
        if self.slack > 1.0 {
            self.slack * self.greatest + 0.5 * (self.slack - 1.0) * away()
        } else {
            self.greatest
        }
    }

    /// The treelet over all.
    fn root(&self) -> &Treelet {
        match &self.treelets[..] {
            [only] => only,
            _ => &self.upper,
        }
    }

    /// Looks how large it is.
    fn measure(&mut self) {
        let root = self.root();
        let (bounds, at_keys) = (root.bounds(), root.at_keys().map(NodesAtKeys::bounds));
        self.greatest =
            at_keys.iter().flatten().fold(bounds.greatest(), |most, key| most.max(key.greatest()));
        self.bounds = bounds;
    }

    /// What a ray that meets the whole is expected to visit, beside the first node: by the surface area heuristic, a visit of
    /// a node or a block costing 1.
    fn cost(&self) -> f64 {
        let areas = self.upper.areas() + self.treelets.iter().map(Treelet::areas).sum::<f64>();
        let whole = self.bounds.half_area();
        if whole > 0.0 { areas / whole } else { 0.0 }
    }

    /// Size and shape; blocks count to the tree.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        let mut stats = TreeStats {
            primitives: self.count as u64,
            references: self.count as u64,
            sah_cost: if self.count == 0 { 0.0 } else { 1.0 + self.cost() },
            tree_bytes: self.owners.memory_bytes() as u64,
            ..TreeStats::default()
        };
        for treelet in self.treelets.iter().chain([&self.upper]) {
            let nodes = treelet.nodes();
            stats.nodes += nodes.len() as u64;
            stats.leaves += (nodes.len() - treelet.node_count()) as u64;
            stats.tree_bytes += treelet.memory_bytes() as u64;
        }
        let deepest = self.treelets.iter().map(Treelet::depth).max().unwrap_or(0);
        stats.depth = self.upper.depth() + deepest;
        stats
    }
}
