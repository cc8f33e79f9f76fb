// SPDX-License-Identifier: GPL-3.0-or-later
//! Any number of rays in one call. See docs/reference/queries.md. Space: the tree's. Bodies are in `src/many.rs`.
//! Tests: `tests/surfaces/slices.rs`.

use crate::slices::{HitSlices, RaySlices, SliceError};
use crate::{AnyRay, HitBatch, ObjectTree, Query, SceneTree, Threads};

macro_rules! queries {
    ($Tree:ident) => {
        /// Any number of rays, from slices, by any number of threads.
        impl $Tree {
            /// Closest hits of rays in a slice, [`Ray`](crate::Ray)s or [`Ray64`](crate::Ray64)s; `hits` is resized to it.
            pub fn intersect_rays<R: AnyRay + Sync>(
                &self,
                query: &Query,
                rays: &[R],
                threads: Threads,
                hits: &mut HitBatch,
            ) {
                self.target().hits_of_slice(query, rays, threads, hits);
            }

            /// Whether anything is hit, for rays in a slice; `occluded` is resized to it.
            pub fn occluded_rays<R: AnyRay + Sync>(
                &self,
                query: &Query,
                rays: &[R],
                threads: Threads,
                occluded: &mut Vec<bool>,
            ) {
                self.target().occlusion_of_slice(query, rays, threads, occluded);
            }

            /// Closest hits of rays in borrowed arrays, into borrowed arrays.
            ///
            /// # Errors
            /// [`SliceError`] if the length of an array for hits is not the number of rays.
            pub fn intersect_slices(
                &self,
                query: &Query,
                rays: &RaySlices,
                threads: Threads,
                hits: &mut HitSlices,
            ) -> Result<(), SliceError> {
                self.target().hits_of_slices(query, rays, threads, hits)
            }

            /// Whether anything is hit, for rays in borrowed arrays.
            ///
            /// # Errors
            /// [`SliceError`] if the length of `occluded` is not the number of rays.
            pub fn occluded_slices(
                &self,
                query: &Query,
                rays: &RaySlices,
                threads: Threads,
                occluded: &mut [bool],
            ) -> Result<(), SliceError> {
                self.target().occlusion_of_slices(query, rays, threads, occluded)
            }
        }
    };
}

queries!(ObjectTree);
queries!(SceneTree);
