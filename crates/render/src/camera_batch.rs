// SPDX-License-Identifier: GPL-3.0-or-later
//! Camera rays of some samples of some pixels, as they go together.

use gnurt_accel::{HitBatch, RayBatch};
use gnurt_shading::{SampleKey, Vec3s};

use crate::world::HitLanes;

/// Camera rays of some samples, and memory for their results.
#[derive(Default)]
pub(crate) struct CameraBatch {
    /// The pixels of the rays of each sample.
    pub(crate) pixels: Vec<[u32; 2]>,
    pub(crate) rays: RayBatch,
    pub(crate) keys: Vec<SampleKey>,
    /// Where they go through the picture.
    pub(crate) positions: Vec<[f32; 2]>,
    /// And through the lens; empty if it has no extent.
    pub(crate) lens: Vec<[f32; 2]>,
    /// And when, while the shutter is open; empty if nothing moves.
    pub(crate) times: Vec<f32>,
    pub(crate) hits: HitBatch,
    pub(crate) radiance: Vec3s,
}

impl CameraBatch {
    /// The hits of the rays.
    pub(crate) fn met(&self) -> HitLanes<'_> {
        HitLanes { rays: &self.rays, keys: &self.keys, hits: &self.hits, cones: None, depth: 0 }
    }
}
