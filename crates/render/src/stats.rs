// SPDX-License-Identifier: GPL-3.0-or-later
//! Counters of a rendering: traced rays and cost. Counters are per tile and added at the end, in tile order:
//! no thread waits for another one.

use std::fmt;

use crate::options::Integrator;
use crate::state::{SavedState, put_f64, put_u32};

/// The largest counter that is believed.
pub(crate) const MOST: u64 = 1 << 56;

/// What a guide of paths is like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuideStats {
    /// Whether paths are guided.
    pub is_on: bool,
    /// The second moment of light with guide over that without, by samples of the pilot that the map was not built from.
    pub moment: f32,
    /// Vertices of the pilot's paths that it was learned from.
    pub vertices: usize,
    /// Parts of space with a distribution each.
    pub cells: usize,
    /// Nodes of all distributions.
    pub nodes: usize,
    /// Memory of the map.
    pub bytes: usize,
    /// Wall-clock seconds of the pilot.
    pub seconds: f64,
}

impl fmt::Display for GuideStats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { is_on, moment, vertices, cells, nodes, bytes, seconds } = self;
        let on = if *is_on { "on" } else { "off, it would not pay" };
        write!(
            f,
            "{on}: second moment of light times {moment:.2}; {vertices} vertices, {cells} cells, {nodes} nodes, {} KiB, {seconds:.2} s",
            bytes >> 10
        )
    }
}

/// An integrator in a pilot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MethodStats {
    /// Variance of a sample of a pixel over the square of its brightness, in the mean over pixels.
    pub variance: f64,
    /// Cost of a sample of a pixel, in rays; those that gather from virtual lights count less, for they take less time.
    pub cost: f64,
    /// Mean of the pixels over their brightness, as both integrators together show it: about 1.
    pub mean: f64,
    /// Standard error of the mean.
    pub mean_error: f64,
}

impl MethodStats {
    /// Variance for equal cost: the smaller, the better.
    #[must_use]
    pub fn product(&self) -> f64 {
        self.variance * self.cost
    }
}

impl fmt::Display for MethodStats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { variance, cost, mean, mean_error } = self;
        write!(f, "variance {variance:.3} x cost {cost:.1}, mean {mean:.3} +- {mean_error:.3}")
    }
}

/// The choice of [`Integrator::Auto`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChoiceStats {
    /// The integrator that renders the picture.
    pub integrator: Integrator,
    /// Virtual lights of a sample, for `bir`: 32, or enough for a known mean.
    pub virtual_lights: u32,
    /// Paths and virtual lights; `None` without a pilot, where virtual lights do not show all that the picture asks for.
    pub methods: Option<[MethodStats; 2]>,
    /// Wall-clock seconds of the pilot.
    pub seconds: f64,
}

impl fmt::Display for ChoiceStats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { integrator, virtual_lights, methods, seconds } = self;
        match methods {
            Some([paths, lights]) => {
                write!(
                    f,
                    "{integrator}, {seconds:.2} s; path: {paths}; bir with {virtual_lights} virtual lights: {lights}"
                )
            }
            None => write!(f, "{integrator}: virtual lights do not show all that the picture asks for"),
        }
    }
}

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
    /// The guide of paths, if one was asked for; not stored in checkpoints.
    pub guide: Option<GuideStats>,
    /// The choice of the integrator, if it was left to a pilot; not stored in checkpoints.
    pub choice: Option<ChoiceStats>,
}

impl RenderStats {
    /// All rays.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.camera_rays + self.shadow_rays + self.secondary_rays
    }

    /// The rays alone: samples of pilots are not in the picture.
    pub(crate) fn without_samples(self) -> Self {
        Self { samples: 0, bad_samples: 0, ..self }
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
