// SPDX-License-Identifier: GPL-3.0-or-later
//! Boxes under a wide BVH, supplied by the caller: the top tree over the instances of a scene.
//! Source: [WBS03a] for the two levels. A kd-tree would list large instances many times, and an object costs
//! far more than a triangle to test twice. A leaf block is eight boxes again, with their indices as children,
//! so that a ray tests eight of them at once. Adjacent boxes form one [`Treelet`], and an upper treelet is
//! over those, so that an edit of a box rebuilds one treelet and the upper one, and shares all others with
//! the previous tree. A few boxes form one treelet only. Boxes that move during an open shutter enclose their
//! whole path; rays, which have a time, test their position at that time (`treelet/keys.rs`).
//! Space: that of the boxes, which are relative to an origin. Invariant: a box is in one treelet, and
//! `owners` maps it to that.
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

/// Tree over boxes by their indices in a list. A clone shares all of it.
#[derive(Clone, Debug)]
pub struct BoxIndex {
    treelets: Vec<Treelet>,
    /// Over the boxes of treelets, its members their numbers; empty where there is one treelet, or none.
    upper: Treelet,
    /// By index: the number of the treelet plus 1; 0 without a box.
    owners: SharedList<u32>,
    /// Boxes are relative to it.
    origin: [f32; 3],
    /// Around everything, at all times.
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
    /// The origin of the boxes' coordinates.
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

    /// The index of the only box, if there is just one.
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

    /// Computes its size.
    fn measure(&mut self) {
        let root = self.root();
        let (bounds, at_keys) = (root.bounds(), root.at_keys().map(NodesAtKeys::bounds));
        self.greatest =
            at_keys.iter().flatten().fold(bounds.greatest(), |most, key| most.max(key.greatest()));
        self.bounds = bounds;
    }

    /// The expected visits of a ray that hits the whole, beside the first node: by the surface area
    /// heuristic, a visit of a node or a block costing 1.
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
