// SPDX-License-Identifier: GPL-3.0-or-later
//! Normals of hits on a scene, and rays that see one face of surfaces. Source: original; docs/queries.md. Space: world.
//! Bodies are in `facing.rs`. Proof: `tests/surfaces/normals.rs`.

use super::types::SceneTree;
use crate::facing::Face;
use crate::{AnyRay, Hit, HitBatch, Query, RayBatch, Threads};

/// Normals and sides.
impl SceneTree {
    /// See [`ObjectTree::normal`](crate::ObjectTree::normal).
    #[must_use]
    pub fn normal(&self, hit: &Hit) -> Option<[f32; 3]> {
        self.target().normal(hit, None, 0.0)
    }

    /// See [`ObjectTree::normal_at`](crate::ObjectTree::normal_at).
    #[must_use]
    pub fn normal_at(&self, hit: &Hit, point: [f64; 3]) -> Option<[f32; 3]> {
        self.target().normal(hit, Some(point), 0.0)
    }

    /// See [`ObjectTree::normals`](crate::ObjectTree::normals).
    pub fn normals(&self, rays: &RayBatch, hits: &HitBatch, threads: Threads, normals: &mut Vec<[f32; 3]>) {
        self.target().normals(rays, hits, threads, normals);
    }

    /// See [`ObjectTree::intersect_face`](crate::ObjectTree::intersect_face).
    #[must_use]
    pub fn intersect_face(&self, query: &Query, ray: &impl AnyRay, face: Face) -> Option<Hit> {
        self.target().closest_face(query, ray, face)
    }

    /// See [`ObjectTree::occluded_face`](crate::ObjectTree::occluded_face).
    #[must_use]
    pub fn occluded_face(&self, query: &Query, ray: &impl AnyRay, face: Face) -> bool {
        self.target().any_face(query, ray, face)
    }

    /// See [`ObjectTree::intersect_batch_face`](crate::ObjectTree::intersect_batch_face).
    pub fn intersect_batch_face(&self, query: &Query, rays: &RayBatch, face: Face, hits: &mut HitBatch) {
        hits.reset(rays.len());
        for i in 0..rays.len() {
            if let Some(hit) = self.intersect_face(query, &rays.get(i), face) {
                hits.set(i, hit);
            }
        }
    }
}
