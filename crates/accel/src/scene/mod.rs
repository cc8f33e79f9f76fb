// SPDX-License-Identifier: GPL-3.0-or-later
//! Two levels: a top tree over instances of objects that have trees of their own.
//! Source: [WBS03a]. Space: world. Proof: `tests/instances.rs`.

mod instance;
mod top;
mod walk;

use gnurt_simd::Simd;
pub use instance::Instance;
use instance::Placed;
use top::TopTree;

use crate::batch::Traceable;
use crate::nearest::{AnyHit, Closest, Mode, Nearest};
use crate::packet::{NearestPacket, RayPacket};
use crate::{Aabb, Counters, Hit, HitBatch, Query, Ray, RayBatch, Record, TreeStats};

/// A scene of instances; cheap to build anew when they move.
#[derive(Debug, Default)]
pub struct SceneTree {
    top: TopTree,
    /// Instances that can be hit, in the order of their ids.
    placed: Vec<Placed>,
    reach: f32,
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
        scene.reach = scene.bounds().reach();
        scene
    }

    /// Box around everything, world space; [`Aabb::EMPTY`] without anything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.top.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds)
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
        crate::batch::closest(self, ray, &mut Counters::default())
    }

    /// Whether anything is hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        crate::batch::any(self, ray, &mut Counters::default())
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
    fn closest(&self, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters) {
        self.search::<Closest>(ray, nearest, counters);
    }

    fn any(&self, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters) {
        self.search::<AnyHit>(ray, nearest, counters);
    }

    #[inline(always)]
    fn packet<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayPacket<S>,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    ) {
        self.search_packet::<S, M>(simd, rays, nearest, counters);
    }

    fn hit(&self, nearest: &Nearest) -> Hit {
        let placed = &self.placed[nearest.slot as usize];
        placed.object.resolve(nearest, placed.inst_id)
    }
}
