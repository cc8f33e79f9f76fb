// SPDX-License-Identifier: GPL-3.0-or-later
//! A tree that follows its geometry from frame to frame: refitted while that pays, rebuilt otherwise.
//! Source: [WBS06] for the refit; rebuilds follow the rule of ski rental (rent until the rent has reached the
//! price), with the cost of [MB90] as the rent; docs/explanation/moving.md has its measurements. Space:
//! object.
//! Invariant: a tree with another user is never modified: frames in flight keep theirs. Tests:
//! `tests/moving.rs`.

use std::sync::{Arc, Mutex, PoisonError};

use crate::crowd::MOST_GROWTH;
use crate::{BuildOptions, Geometry, ObjectTree, Quality, Structure, Threads};

/// A hint about the motion of an object's primitives. Instances move as they like with each of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Motion {
    /// No hint: motion is detected.
    #[default]
    Auto,
    /// Not at all. An edit is the exception, and gets a new tree.
    Static,
    /// As a whole, by its instances: the same as `Static` for the object.
    Rigid,
    /// Repeatedly: trees are built without the parts that a refit spoils (spatial splits).
    Deforming,
    /// Among poses that come back: refitted, and never rebuilt for its quality.
    Known,
}

/// The kind of an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// Boxes were fitted; the topology is unchanged.
    Refitted,
    /// All was built again.
    Rebuilt,
}

/// A tree, and how it came to be. A copy shares the tree, and follows its own geometry from then on.
#[derive(Clone, Debug)]
pub struct MovingTree {
    tree: Arc<ObjectTree>,
    motion: Motion,
    /// The tree of the update before last, for reuse of its memory after its last user.
    spare: Arc<Mutex<Option<Arc<ObjectTree>>>>,
    /// Refits since the last build.
    refits: u32,
    /// Nanoseconds that rays are thought to have lost since the last build.
    debt: f64,
}

/// Rays that an object is thought to meet from one update to the next: a frame of a megapixel with some light.
const RAYS: f64 = 4e6;

/// Nanoseconds of a ray per unit of a tree's cost.
const STEP: f64 = 10.0;

/// Nanoseconds that a build takes for each triangle.
const BUILD: f64 = 600.0;

/// Growth of the cost below this is noise, and has no price.
const NOISE: f64 = 1.02;

impl MovingTree {
    /// Builds the first tree. For [`Motion::Deforming`] and [`Motion::Known`] `High` quality is taken for `Medium`.
    #[must_use]
    pub fn build(geometries: &[Geometry], options: &BuildOptions, motion: Motion, threads: Threads) -> Self {
        let tree = Arc::new(ObjectTree::build_from(geometries, &options_for(options, motion), threads));
        Self::of(tree, motion)
    }

    /// Takes over a tree that was built, or loaded.
    #[must_use]
    pub fn of(tree: Arc<ObjectTree>, motion: Motion) -> Self {
        Self { tree, motion, spare: Arc::default(), refits: 0, debt: 0.0 }
    }

    /// The tree as it is now.
    #[must_use]
    pub fn tree(&self) -> &Arc<ObjectTree> {
        &self.tree
    }

    /// Follows the geometry: afterwards [`tree`](Self::tree) is over it. Trees that were handed out stay as they are.
    /// The tree is built with `options` if the geometry differs, or has other good triangles, or the
    /// structure has no refit, or nothing may move.
    pub fn update(&mut self, geometries: &[Geometry], options: &BuildOptions, threads: Threads) -> Update {
        let is_fixed = matches!(self.motion, Motion::Static | Motion::Rigid) || !self.tree.knows_refits();
        let refitted = (!is_fixed).then(|| self.space().refit_from(geometries, threads).ok()).flatten();
        let Some(tree) = refitted else {
            *self = Self::build(geometries, options, self.motion, threads);
            return Update::Rebuilt;
        };
        if tree.is_posed() {
            return self.follow_pose(tree, geometries, options, threads);
        }
        let (growth, cost) = (tree.cost_growth(), tree.stats().sah_cost);
        let lost = if growth > NOISE { cost - cost / growth } else { 0.0 };
        self.debt += RAYS * STEP * lost;
        let price = BUILD * tree.stats().primitives as f64;
        if self.motion != Motion::Known && self.debt > price {
            // A tree that has moved will move again, with any hint.
            let built = Self::build(geometries, options, Motion::Deforming, threads);
            *self = Self { motion: self.motion, ..built };
            return Update::Rebuilt;
        }
        self.replace(Arc::new(tree));
        Update::Refitted
    }

    /// A pose that others share their structure with stays one unless it fits badly: one of a crowd gets few of the rays, and a
    /// tree by itself would take many times the memory. For the same reason none is kept for reuse.
    fn follow_pose(
        &mut self,
        tree: ObjectTree,
        geometries: &[Geometry],
        options: &BuildOptions,
        threads: Threads,
    ) -> Update {
        if self.motion != Motion::Known && tree.cost_growth() > MOST_GROWTH {
            *self = Self::build(geometries, options, self.motion, threads);
            return Update::Rebuilt;
        }
        self.tree = Arc::new(tree);
        Update::Refitted
    }

    /// A tree for reuse: the last but one, if it has no other user, or a copy.
    fn space(&self) -> ObjectTree {
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).take();
        spare.and_then(|spare| Arc::try_unwrap(spare).ok()).unwrap_or_else(|| (*self.tree).clone())
    }

    fn replace(&mut self, tree: Arc<ObjectTree>) {
        let before = std::mem::replace(&mut self.tree, tree);
        self.refits += 1;
        // A single edit need not cost memory.
        if self.motion != Motion::Auto || self.refits > 1 {
            *self.spare.lock().unwrap_or_else(PoisonError::into_inner) = Some(before);
        }
    }
}

/// Spatial splits are worth nothing once triangles have moved.
fn options_for(options: &BuildOptions, motion: Motion) -> BuildOptions {
    let moves = matches!(motion, Motion::Deforming | Motion::Known);
    match options.quality {
        Quality::High if moves && options.structure == Structure::Bvh => {
            BuildOptions { quality: Quality::Medium, ..*options }
        }
        _ => *options,
    }
}
