// SPDX-License-Identifier: GPL-3.0-or-later
//! Two levels: a top tree over instances of objects that have trees of their own.
//! Source: [WBS03a]. Space: world. Proof: `tests/instances.rs`.

mod instance;
mod top;
mod walk;

use gnurt_simd::{Level, Simd};
pub use instance::Instance;
use instance::Placed;
use top::TopTree;

use crate::batch::Traceable;
use crate::nearest::{Mode, Nearest};
use crate::tile::{NearestTile, RayTile};
use crate::{Aabb, Counters, Hit, HitBatch, Query, Ray, RayBatch, Record, TreeStats};

/// A scene of instances; cheap to build anew when they move.
#[derive(Debug, Default)]
pub struct SceneTree {
    top: TopTree,
    /// Instances that can be hit, in the order of their ids.
    placed: Vec<Placed>,
    dropped: u64,
}

impl SceneTree {
    /// Builds over `instances`; their places in the list are the `inst_id`s of hits. Those whose transform cannot
    /// be undone in floats are left out and counted; no instance at all is fine.
    #[must_use]
    pub fn build(instances: &[Instance]) -> Self {
        let mut scene = Self::default();
        for (id, instance) in instances.iter().enumerate() {
            match Placed::new(instance, id as u32) {
                Some(placed) if !placed.bounds.is_empty() => scene.placed.push(placed),
                Some(_) => {}
                None => scene.dropped += 1,
            }
        }
        let boxes: Vec<Aabb> = scene.placed.iter().map(|placed| placed.bounds).collect();
        scene.top = TopTree::build(&boxes);
        scene
    }

    /// Box around everything, world space; [`Aabb::EMPTY`] without anything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.top.tree.bounds
    }

    /// Instances whose transform cannot be undone or is not finite.
    #[must_use]
    pub fn dropped_instances(&self) -> u64 {
        self.dropped
    }

    /// Size and shape of the top tree.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        TreeStats { primitive_bytes: size_of_val(&self.placed[..]) as u64, ..self.top.stats() }
    }

    /// The closest hit.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        crate::batch::closest(self, Level::best(), ray)
    }

    /// Whether anything is hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        crate::batch::any(self, Level::best(), ray)
    }

    /// Closest hits of a batch; `hits` is resized to it.
    pub fn intersect_batch(&self, query: &Query, rays: &RayBatch, hits: &mut HitBatch, record: &mut Record) {
        crate::batch::intersect(self, query, rays, hits, record);
    }

    /// Whether anything is hit, ray by ray; `occluded` is resized to the batch.
    pub fn occluded_batch(
        &self,
        query: &Query,
        rays: &RayBatch,
        occluded: &mut Vec<bool>,
        record: &mut Record,
    ) {
        crate::batch::occluded(self, query, rays, occluded, record);
    }
}

impl Traceable for SceneTree {
    #[inline(always)]
    fn single<S: Simd, M: Mode>(&self, simd: S, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters) {
        self.search::<S, M>(simd, ray, nearest, counters);
    }

    #[inline(always)]
    fn tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        self.search_tile::<S, M>(simd, rays, active, nearest, counters);
    }

    fn hit(&self, nearest: &Nearest) -> Hit {
        let placed = &self.placed[nearest.slot as usize];
        placed.object.resolve(nearest, placed.inst_id)
    }

    fn only_mesh(&self) -> Option<u32> {
        match &self.placed[..] {
            [only] if only.object.has_one_mesh() => Some(only.inst_id),
            _ => None,
        }
    }
}
