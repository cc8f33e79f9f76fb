// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays, one by one and in batches. docs/reference/queries.md compares these with Embree's calls. Bodies are
//! in `query.rs` and `batch.rs`. Space: the tree's.
//! Tests: `tests/brute_force.rs`, `tests/all_hits.rs`, `tests/instances.rs`, `tests/nested.rs`, `tests/filters.rs`, `tests/masks.rs`.

use crate::{
    AnyRay, Hit, HitBatch, ObjectTree, Packet, Pencil, PointHit, PrimitiveId, Query, Ray, RayBatch, Record,
    SceneTree, batch,
};

macro_rules! queries {
    ($Tree:ident) => {
        /// Ray queries, answered by all that is there, in scenes all that the instances show. A ray is a [`Ray`] or a [`Ray64`](crate::Ray64).
        impl $Tree {
            /// The closest hit; of several at the same `t` the one with the lowest ids.
            #[must_use]
            #[inline]
            pub fn intersect(&self, ray: &impl AnyRay) -> Option<Hit> {
                self.intersect_with(&Query::default(), ray)
            }

            /// Whether anything is hit.
            #[must_use]
            #[inline]
            pub fn occluded(&self, ray: &impl AnyRay) -> bool {
                self.occluded_with(&Query::default(), ray)
            }

            /// The closest hit, with a chosen instruction set and mask.
            #[must_use]
            #[inline]
            pub fn intersect_with(&self, query: &Query, ray: &impl AnyRay) -> Option<Hit> {
                self.target().closest(query, ray)
            }

            /// Whether anything is hit, with a chosen instruction set and mask.
            #[must_use]
            #[inline]
            pub fn occluded_with(&self, query: &Query, ray: &impl AnyRay) -> bool {
                self.target().any(query, ray)
            }

            /// The closest hit; and the corners of the triangle or half of a quad that was hit, in its object's space, as the
            /// tree has them. `None` for other primitives, for those that move, and in objects of several trees or a compact one:
            /// those are not at hand.
            #[must_use]
            #[inline]
            pub fn intersect_with_corners(
                &self,
                query: &Query,
                ray: &impl AnyRay,
            ) -> Option<(Hit, Option<[[f32; 3]; 3]>)> {
                self.target().closest_with_corners(query, ray)
            }

            /// The answer of [`intersect_with_corners`](Self::intersect_with_corners) if it is found by the shortest way: of a valid ray
            /// with an object of one tree, over triangles and not compact. `None` elsewhere, which is decided in few
            /// instructions. Inlined: for callers that are called for each ray.
            #[must_use]
            #[inline(always)]
            pub fn intersect_directly(
                &self,
                query: &Query,
                ray: &impl AnyRay,
            ) -> Option<Option<(Hit, Option<[[f32; 3]; 3]>)>> {
                self.target().closest_directly(query, ray)
            }

            /// The closest hit that `accept` lets pass.
            ///
            /// The callback gets hits in any order, more than once where a tree lists a primitive in several
            /// leaves, and only possible parts of the answer.
            #[must_use]
            pub fn intersect_filtered(
                &self,
                query: &Query,
                ray: &impl AnyRay,
                accept: impl FnMut(&Ray, &Hit) -> bool,
            ) -> Option<Hit> {
                self.target().closest_filtered(query, ray, accept)
            }

            /// Whether anything is hit that `accept` lets pass; see [`intersect_filtered`](Self::intersect_filtered).
            #[must_use]
            pub fn occluded_filtered(
                &self,
                query: &Query,
                ray: &impl AnyRay,
                accept: impl FnMut(&Ray, &Hit) -> bool,
            ) -> bool {
                self.target().any_filtered(query, ray, accept)
            }

            /// The closest hit on another primitive than `ignored`: the one that the ray starts on.
            #[must_use]
            pub fn intersect_ignoring(
                &self,
                query: &Query,
                ray: &impl AnyRay,
                ignored: PrimitiveId,
            ) -> Option<Hit> {
                self.intersect_filtered(query, ray, |_, hit| hit.primitive() != ignored)
            }

            /// Whether another primitive than `ignored` is hit.
            #[must_use]
            pub fn occluded_ignoring(&self, query: &Query, ray: &impl AnyRay, ignored: PrimitiveId) -> bool {
                self.occluded_filtered(query, ray, |_, hit| hit.primitive() != ignored)
            }

            /// All hits in the order of `t`, then of ids; `hits` is emptied first. Every hit is there once; of a quad
            /// that is met on the diagonal between its halves, only one.
            pub fn all_hits(&self, query: &Query, ray: &impl AnyRay, hits: &mut Vec<Hit>) {
                self.first_hits(query, ray, usize::MAX, hits);
            }

            /// The first `n` hits, or all where there are fewer; as [`all_hits`](Self::all_hits), but the
            /// search ends behind the `n`th.
            pub fn first_hits(&self, query: &Query, ray: &impl AnyRay, n: usize, hits: &mut Vec<Hit>) {
                self.target().first_hits(query, ray, n, hits);
            }

            /// How many hits there are.
            #[must_use]
            pub fn count_hits(&self, query: &Query, ray: &impl AnyRay) -> usize {
                let mut hits = Vec::new();
                self.all_hits(query, ray, &mut hits);
                hits.len()
            }

            /// The point of a surface that is nearest to `point`, no farther than `radius`, which may be infinite; of
            /// several at the same distance one of the lowest ids, up to rounding.
            ///
            /// Surfaces are meant: from inside of a sphere it is as far as to its rim. Instances may be scaled
            /// differently along different axes. User geometry is seen as far as it
            /// [answers](crate::UserGeometry::closest_point).
            #[must_use]
            pub fn closest_point(&self, point: [f64; 3], radius: f64) -> Option<PointHit> {
                self.closest_point_with(&Query::default(), point, radius)
            }

            /// The nearest point, with a chosen instruction set and mask.
            #[must_use]
            pub fn closest_point_with(
                &self,
                query: &Query,
                point: [f64; 3],
                radius: f64,
            ) -> Option<PointHit> {
                self.target().closest_point(query, point, radius)
            }

            /// Closest hits of a batch; `hits` is resized to it.
            pub fn intersect_batch(
                &self,
                query: &Query,
                rays: &RayBatch,
                hits: &mut HitBatch,
                record: &mut Record,
            ) {
                batch::intersect(self.target(), query, rays, hits, record);
            }

            /// Whether anything is hit, ray by ray; `occluded` is resized to the batch.
            pub fn occluded_batch(
                &self,
                query: &Query,
                rays: &RayBatch,
                occluded: &mut Vec<bool>,
                record: &mut Record,
            ) {
                batch::occluded(self.target(), query, rays, occluded, record);
            }

            /// The closest hits of a packet's rays: `report` gets the index of each ray that has one, in the
            /// order of `push`, and its hit. `query.coherence` tells whether the rays are coherent.
            pub fn intersect_packet(&self, query: &Query, packet: Packet, report: impl FnMut(usize, Hit)) {
                self.target().closest_of_packet(query, packet, report);
            }

            /// Which rays of a packet hit anything, as bits from the lowest on; see [`intersect_packet`](Self::intersect_packet).
            #[must_use]
            pub fn occluded_packet(&self, query: &Query, packet: Packet) -> u64 {
                self.target().any_of_packet(query, packet)
            }

            /// Which rays of a pencil hit anything, as bits. They are traced together, for any coherence in
            /// `query`; costs of single rays are not recorded. Directions of lanes without a ray are
            /// overwritten.
            pub fn occluded_pencil(&self, query: &Query, pencil: &mut Pencil, record: &mut Record) -> u64 {
                batch::occluded_pencil(self.target(), query, pencil, record)
            }

            /// Closest hits that `accept` lets pass for ray `i` of the batch; `hits` is resized to it. The rays are
            /// traced one by one.
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

            /// Whether ray `i` of the batch hits anything that `accept` lets pass for it; `occluded` is resized to the
            /// batch. The rays are traced one by one.
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
    };
}

queries!(ObjectTree);
queries!(SceneTree);
