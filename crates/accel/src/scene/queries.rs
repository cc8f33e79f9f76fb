// SPDX-License-Identifier: GPL-3.0-or-later
//! What a scene can be asked: the same as an object. Source: original; docs/queries.md names Embree's calls beside these.
//! Bodies are in `ask.rs` and `batch.rs`. Space: world.
//! Proof: `tests/instances.rs`, `tests/nested.rs`, `tests/filters.rs`, `tests/masks.rs`.

use super::types::SceneTree;
use crate::target::Target;
use crate::{
    AnyRay, Hit, HitBatch, Packet, Pencil, PointHit, PrimitiveId, Query, Ray, RayBatch, Record, batch,
};

/// Ray queries, answered by all that the instances show. A ray is a [`Ray`] or a [`Ray64`](crate::Ray64).
impl SceneTree {
    pub(crate) fn target(&self) -> Target<'_> {
        Target::Scene(self)
    }

    /// See [`ObjectTree::intersect`](crate::ObjectTree::intersect).
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &impl AnyRay) -> Option<Hit> {
        self.intersect_with(&Query::default(), ray)
    }

    /// See [`ObjectTree::occluded`](crate::ObjectTree::occluded).
    #[must_use]
    #[inline]
    pub fn occluded(&self, ray: &impl AnyRay) -> bool {
        self.occluded_with(&Query::default(), ray)
    }

    /// See [`ObjectTree::intersect_with`](crate::ObjectTree::intersect_with).
    #[must_use]
    #[inline]
    pub fn intersect_with(&self, query: &Query, ray: &impl AnyRay) -> Option<Hit> {
        self.target().closest(query, ray)
    }

    /// See [`ObjectTree::occluded_with`](crate::ObjectTree::occluded_with).
    #[must_use]
    #[inline]
    pub fn occluded_with(&self, query: &Query, ray: &impl AnyRay) -> bool {
        self.target().any(query, ray)
    }

    /// See [`ObjectTree::intersect_filtered`](crate::ObjectTree::intersect_filtered).
    #[must_use]
    pub fn intersect_filtered(
        &self,
        query: &Query,
        ray: &impl AnyRay,
        accept: impl FnMut(&Ray, &Hit) -> bool,
    ) -> Option<Hit> {
        self.target().closest_filtered(query, ray, accept)
    }

    /// See [`ObjectTree::occluded_filtered`](crate::ObjectTree::occluded_filtered).
    #[must_use]
    pub fn occluded_filtered(
        &self,
        query: &Query,
        ray: &impl AnyRay,
        accept: impl FnMut(&Ray, &Hit) -> bool,
    ) -> bool {
        self.target().any_filtered(query, ray, accept)
    }

    /// See [`ObjectTree::intersect_ignoring`](crate::ObjectTree::intersect_ignoring).
    #[must_use]
    pub fn intersect_ignoring(&self, query: &Query, ray: &impl AnyRay, ignored: PrimitiveId) -> Option<Hit> {
        self.intersect_filtered(query, ray, |_, hit| hit.primitive() != ignored)
    }

    /// See [`ObjectTree::occluded_ignoring`](crate::ObjectTree::occluded_ignoring).
    #[must_use]
    pub fn occluded_ignoring(&self, query: &Query, ray: &impl AnyRay, ignored: PrimitiveId) -> bool {
        self.occluded_filtered(query, ray, |_, hit| hit.primitive() != ignored)
    }

    /// See [`ObjectTree::all_hits`](crate::ObjectTree::all_hits).
    pub fn all_hits(&self, query: &Query, ray: &impl AnyRay, hits: &mut Vec<Hit>) {
        self.first_hits(query, ray, usize::MAX, hits);
    }

    /// See [`ObjectTree::first_hits`](crate::ObjectTree::first_hits).
    pub fn first_hits(&self, query: &Query, ray: &impl AnyRay, n: usize, hits: &mut Vec<Hit>) {
        self.target().first_hits(query, ray, n, hits);
    }

    /// See [`ObjectTree::count_hits`](crate::ObjectTree::count_hits).
    #[must_use]
    pub fn count_hits(&self, query: &Query, ray: &impl AnyRay) -> usize {
        let mut hits = Vec::new();
        self.all_hits(query, ray, &mut hits);
        hits.len()
    }

    /// See [`ObjectTree::closest_point`](crate::ObjectTree::closest_point).
    #[must_use]
    pub fn closest_point(&self, point: [f64; 3], radius: f64) -> Option<PointHit> {
        self.closest_point_with(&Query::default(), point, radius)
    }

    /// See [`ObjectTree::closest_point_with`](crate::ObjectTree::closest_point_with).
    #[must_use]
    pub fn closest_point_with(&self, query: &Query, point: [f64; 3], radius: f64) -> Option<PointHit> {
        self.target().closest_point(query, point, radius)
    }

    /// See [`ObjectTree::intersect_batch`](crate::ObjectTree::intersect_batch).
    pub fn intersect_batch(&self, query: &Query, rays: &RayBatch, hits: &mut HitBatch, record: &mut Record) {
        batch::intersect(self.target(), query, rays, hits, record);
    }

    /// See [`ObjectTree::occluded_batch`](crate::ObjectTree::occluded_batch).
    pub fn occluded_batch(
        &self,
        query: &Query,
        rays: &RayBatch,
        occluded: &mut Vec<bool>,
        record: &mut Record,
    ) {
        batch::occluded(self.target(), query, rays, occluded, record);
    }

    /// See [`ObjectTree::intersect_packet`](crate::ObjectTree::intersect_packet).
    pub fn intersect_packet(&self, query: &Query, packet: Packet, tell: impl FnMut(usize, Hit)) {
        self.target().closest_of_packet(query, packet, tell);
    }

    /// See [`ObjectTree::occluded_packet`](crate::ObjectTree::occluded_packet).
    #[must_use]
    pub fn occluded_packet(&self, query: &Query, packet: Packet) -> u64 {
        self.target().any_of_packet(query, packet)
    }

    /// See [`ObjectTree::occluded_pencil`](crate::ObjectTree::occluded_pencil).
    pub fn occluded_pencil(&self, query: &Query, pencil: &mut Pencil, record: &mut Record) -> u64 {
        batch::occluded_pencil(self.target(), query, pencil, record)
    }

    /// See [`ObjectTree::intersect_batch_filtered`](crate::ObjectTree::intersect_batch_filtered).
    pub fn intersect_batch_filtered(
        &self,
        query: &Query,
        rays: &RayBatch,
        hits: &mut HitBatch,
        mut accept: impl FnMut(usize, &Hit) -> bool,
    ) {
        hits.reset(rays.len());
        for i in 0..rays.len() {
            if let Some(hit) = self.intersect_filtered(query, &rays.get(i), |_, hit| accept(i, hit)) {
                hits.set(i, hit);
            }
        }
    }

    /// See [`ObjectTree::occluded_batch_filtered`](crate::ObjectTree::occluded_batch_filtered).
    pub fn occluded_batch_filtered(
        &self,
        query: &Query,
        rays: &RayBatch,
        occluded: &mut Vec<bool>,
        mut accept: impl FnMut(usize, &Hit) -> bool,
    ) {
        let any = |i| self.occluded_filtered(query, &rays.get(i), |_, hit| accept(i, hit));
        occluded.clear();
        occluded.extend((0..rays.len()).map(any));
    }
}
