// SPDX-License-Identifier: GPL-3.0-or-later
//! Counters of a rendering: traced rays and cost. Counters are per tile and added at the end, in tile order:
//! no thread waits for another one.

use crate::state::{SavedState, put_f64, put_u32};

/// The largest counter that is believed.
pub(crate) const MOST: u64 = 1 << 56;

/// Counters of a rendering.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Rays from the camera.
    pub camera_rays: u64,
    /// Rays towards lights.
    pub shadow_rays: u64,
    /// Rays that shaders sent: mirrored, refracted, straight on.
    pub secondary_rays: u64,
    /// Of the shadow rays, those towards virtual lights that all seen points gather from.
    pub gather_rays: u64,
    /// Total seconds of all threads in gathering; not stored in checkpoints.
    pub gather_seconds: f64,
    /// Tree nodes visited by all rays.
    pub nodes_visited: u64,
    /// Triangles tested by all rays.
    pub triangles_tested: u64,
    /// Camera samples that were taken, over all pixels.
    pub samples: u64,
    /// Camera samples whose radiance was NaN or infinite and became black.
    pub bad_samples: u64,
    /// Fewest samples that a pixel of the region got.
    pub spp_min: u32,
    /// Most samples that a pixel of the region got.
    pub spp_max: u32,
    /// Whether all samples were taken: neither stopped nor out of time.
    pub complete: bool,
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Threads of the pool.
    pub threads: usize,
}

impl RenderStats {
    /// All rays.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.camera_rays + self.shadow_rays + self.secondary_rays
    }

    /// Whether they can be added to: no computer comes to larger numbers, but a file may hold them.
    pub(crate) fn are_sound(&self) -> bool {
        let rays = [self.camera_rays, self.shadow_rays, self.secondary_rays];
        let others = [self.nodes_visited, self.triangles_tested, self.samples, self.bad_samples];
        self.seconds.is_finite() && rays.iter().chain(&others).all(|&counter| counter <= MOST)
    }

    /// Adds the counters of another tile.
    pub fn add(&mut self, other: &Self) {
        self.camera_rays += other.camera_rays;
        self.shadow_rays += other.shadow_rays;
        self.secondary_rays += other.secondary_rays;
        self.gather_rays += other.gather_rays;
        self.gather_seconds += other.gather_seconds;
        self.nodes_visited += other.nodes_visited;
        self.triangles_tested += other.triangles_tested;
        self.samples += other.samples;
        self.bad_samples += other.bad_samples;
    }
}

impl SavedState for RenderStats {
    fn state(&mut self, with: &mut dyn FnMut(&mut u64)) {
        for counter in [
            &mut self.camera_rays,
            &mut self.shadow_rays,
            &mut self.secondary_rays,
            &mut self.nodes_visited,
            &mut self.triangles_tested,
            &mut self.samples,
            &mut self.bad_samples,
        ] {
            with(counter);
        }
        put_u32(&mut self.spp_min, with);
        put_u32(&mut self.spp_max, with);
        put_f64(&mut self.seconds, with);
    }
}
