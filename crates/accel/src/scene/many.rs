// SPDX-License-Identifier: GPL-3.0-or-later
//! Any number of rays into a scene in one call. Source: original; docs/queries.md. Space: world. Bodies are in `many.rs`.
//! Proof: `tests/surfaces/slices.rs`.

use super::types::SceneTree;
use crate::slices::{HitSlices, RaySlices, SliceError};
use crate::{AnyRay, HitBatch, Query, Threads};

/// Any number of rays, from slices, by any number of threads.
impl SceneTree {
    /// See [`ObjectTree::intersect_rays`](crate::ObjectTree::intersect_rays).
    pub fn intersect_rays<R: AnyRay + Sync>(
        &self,
        query: &Query,
        rays: &[R],
        threads: Threads,
        hits: &mut HitBatch,
    ) {
        self.target().hits_of_slice(query, rays, threads, hits);
    }

    /// See [`ObjectTree::occluded_rays`](crate::ObjectTree::occluded_rays).
    pub fn occluded_rays<R: AnyRay + Sync>(
        &self,
        query: &Query,
        rays: &[R],
        threads: Threads,
        occluded: &mut Vec<bool>,
    ) {
        self.target().occlusion_of_slice(query, rays, threads, occluded);
    }

    /// See [`ObjectTree::intersect_slices`](crate::ObjectTree::intersect_slices).
    ///
    /// # Errors
    /// [`SliceError`] where an array for hits has not a place for each ray.
    pub fn intersect_slices(
        &self,
        query: &Query,
        rays: &RaySlices,
        threads: Threads,
        hits: &mut HitSlices,
    ) -> Result<(), SliceError> {
        self.target().hits_of_slices(query, rays, threads, hits)
    }

    /// See [`ObjectTree::occluded_slices`](crate::ObjectTree::occluded_slices).
    ///
    /// # Errors
    /// [`SliceError`] where `occluded` has not a place for each ray.
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
