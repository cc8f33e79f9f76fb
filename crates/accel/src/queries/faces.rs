// SPDX-License-Identifier: GPL-3.0-or-later
//! Normals of hits, and rays that see one face of surfaces. See docs/reference/queries.md. Space: the tree's.
//! Bodies are in `facing.rs`. Tests: `tests/surfaces/normals.rs`.

use crate::facing::Face;
use crate::{AnyRay, Hit, HitBatch, ObjectTree, Query, RayBatch, SceneTree, Threads};

macro_rules! queries {
    ($Tree:ident) => {
        /// Normals and sides.
        impl $Tree {
            /// The geometric normal of the triangle or quad that was hit, of unit length, towards the side from which its
            /// vertices go around counter-clockwise in its object; in the space of this tree. `None` for
            /// spheres, whose [`normal_at`](Self::normal_at) needs the point, for user geometry, and for hits
            /// of other trees.
            ///
            /// For moving geometry it is the normal at time 0: [`normals`](Self::normals) uses each ray's
            /// time, [`at`](Self::at) gives a static copy.
            ///
            /// The first call maps primitives to leaves, in one pass over the tree: 4 bytes a primitive,
            /// which are kept and are not counted by `stats`.
            #[must_use]
            pub fn normal(&self, hit: &Hit) -> Option<[f32; 3]> {
                self.target().normal(hit, None, 0.0)
            }

            /// The same for a hit at a point, which determines a sphere's normal.
            #[must_use]
            pub fn normal_at(&self, hit: &Hit, point: [f64; 3]) -> Option<[f32; 3]> {
                self.target().normal(hit, Some(point), 0.0)
            }

            /// Normals of a batch's hits; `normals` is resized to it, and holds zeros where there is none.
            pub fn normals(
                &self,
                rays: &RayBatch,
                hits: &HitBatch,
                threads: Threads,
                normals: &mut Vec<[f32; 3]>,
            ) {
                self.target().normals(rays, hits, threads, normals);
            }

            /// The closest hit on this face of a surface; the other face is transparent. Which face it is
            /// does not depend on mirroring instances. A surface in the plane of the ray has both faces, and
            /// so has user geometry.
            #[must_use]
            pub fn intersect_face(&self, query: &Query, ray: &impl AnyRay, face: Face) -> Option<Hit> {
                self.target().closest_face(query, ray, face)
            }

            /// Whether this face of anything is hit.
            #[must_use]
            pub fn occluded_face(&self, query: &Query, ray: &impl AnyRay, face: Face) -> bool {
                self.target().any_face(query, ray, face)
            }

            /// Closest hits on this face for a batch; `hits` is resized to it. The rays are traced one by one.
            pub fn intersect_batch_face(
                &self,
                query: &Query,
                rays: &RayBatch,
                face: Face,
                hits: &mut HitBatch,
            ) {
                hits.reset(rays.len());
                for i in 0..rays.len() {
                    if let Some(hit) = self.intersect_face(query, &rays.get(i), face) {
                        hits.set(i, hit);
                    }
                }
            }
        }
    };
}

queries!(ObjectTree);
queries!(SceneTree);
