// SPDX-License-Identifier: GPL-3.0-or-later
//! The virtual lights of one pass: a fresh set for each sample per pixel, the same for all tiles.
//! Independent sets make the mean of passes converge [Kel97].
//! Invariant: a function of world, camera, options and the number of the sample, on any number of threads.
//! Tests: crates/render/tests/many_lights.rs.

use std::sync::OnceLock;

use super::bound::{Bound, bound_of};
use super::gather::sources;
use super::interleave;
use super::lanes::Source;
use super::vpl::Vpl;
use crate::options::RenderOptions;
use crate::stats::RenderStats;
use crate::world::World;

/// The virtual lights of a pass, and how they share the work with rays.
#[derive(Clone, Debug)]
pub(crate) struct PassLights {
    pub(crate) vpls: Vec<Vpl>,
    /// By position in the pattern of interleaved pixels, or random subsets if samples use few; else empty.
    pub(crate) shares: Vec<Vec<Vpl>>,
    /// The same, ready to be gathered.
    pub(super) sources: Vec<Vec<Source>>,
    /// All of them, prepared at first use.
    whole: OnceLock<Vec<Source>>,
    /// Those of each position of the pattern, or subsets of all of them without a pattern; prepared at the
    /// first use by indirectly visible points.
    unseen: OnceLock<Vec<Vec<Source>>>,
    pub(crate) bound: Bound,
    /// Rays that leave a point that the eye sees, and the chance of each where that scatters alike to all sides.
    pub(crate) rays: u32,
    pub(super) ray_probability: f32,
    /// The number of lights at the end of such a ray: those of the greatest contribution.
    few: u32,
    /// Light samples at each point that the eye sees.
    light_samples: u32,
    /// Whether visible points use no more lights than others: each sample few of a random subset.
    pub(crate) is_few: bool,
    /// Cost of their creation.
    pub(crate) stats: RenderStats,
}

impl PassLights {
    /// The pass with these lights, and their cost.
    pub(super) fn of(world: &World, options: &RenderOptions, vpls: Vec<Vpl>, stats: RenderStats) -> Self {
        let bound = bound_of(world, options);
        let few = (options.vpls / 64).clamp(1, 16);
        let pattern = options.pattern();
        let rays = if pattern.is_some() { 1 } else { (options.vpls / 256).clamp(1, MOST_RAYS) };
        let shares = pattern.map_or_else(Vec::new, |n| interleave::shares(&vpls, (n * n) as usize));
        // Where pixels are averaged, each needs fewer.
        let per_pixel = |of_window: u32| pattern.map_or(of_window, |n| of_window.div_ceil(n * n));
        let (few, light_samples) = (per_pixel(few).div_ceil(rays.min(2)), per_pixel(few));
        let sources = shares.iter().map(|share| sources(share, &bound)).collect();
        let (whole, unseen) = (OnceLock::new(), OnceLock::new());
        Self {
            vpls,
            shares,
            sources,
            whole,
            unseen,
            bound,
            rays,
            ray_probability: 1.0,
            few,
            light_samples,
            is_few: false,
            stats,
        }
    }

    /// The same for samples that use few lights, those of the greatest contribution in a subset: for pictures
    /// in motion, where noise is filtered afterwards.
    pub(super) fn few(world: &World, options: &RenderOptions, vpls: Vec<Vpl>, stats: RenderStats) -> Self {
        let shares = interleave::shares(&vpls, vpls.len().div_ceil(OF_SHARE).max(1));
        Self {
            shares,
            vpls,
            sources: Vec::new(),
            whole: OnceLock::new(),
            unseen: OnceLock::new(),
            bound: bound_of(world, options),
            rays: 1,
            ray_probability: FEW_RAYS,
            few: 1,
            light_samples: 1,
            is_few: true,
            stats,
        }
    }

    /// All virtual lights, ready to be gathered.
    pub(super) fn whole(&self) -> &[Source] {
        self.whole.get_or_init(|| sources(&self.vpls, &self.bound))
    }

    /// The same in shares, each as strong as all of them, for points that the eye does not see.
    pub(super) fn unseen(&self) -> &[Vec<Source>] {
        self.unseen.get_or_init(|| {
            let ready = |share: &Vec<Vpl>| sources(share, &self.bound_at(false));
            if !self.shares.is_empty() {
                return self.shares.iter().map(ready).collect();
            }
            let whole = ready(&self.vpls);
            // Each has some of every part of the scene, since neighbours follow each other.
            let count = (whole.len() / OF_UNSEEN).max(1);
            let scaled = |source: &Source| source.scaled(count as f32);
            (0..count).map(|first| whole.iter().skip(first).step_by(count).map(scaled).collect()).collect()
        })
    }

    /// The bound on virtual lights at a point.
    pub(crate) fn bound_at(&self, is_directly_visible: bool) -> Bound {
        match is_directly_visible {
            _ if self.is_few => self.bound.times(OF_FEW),
            true => self.bound,
            false => self.bound.times(UNSEEN),
        }
    }

    /// The number of virtual lights at the end of a path of this many edges from the eye, if the end is not
    /// visible.
    pub(super) fn few_at(&self, edges: u32) -> u32 {
        match edges {
            1 if self.is_few => SEEN_FEW,
            ..=2 => self.few,
            _ => self.few.div_ceil(2),
        }
    }

    /// How many light samples a point gets: many where the eye sees it.
    pub(crate) fn light_samples(&self, is_directly_visible: bool) -> u32 {
        if is_directly_visible { self.light_samples } else { 1 }
    }
}

/// The largest number of rays from a visible point: a ray costs little compared with the virtual lights
/// there, and brings most of the error on glossy surfaces.
const MOST_RAYS: u32 = 4;

/// Rays from a matte point if pictures are reused.
const FEW_RAYS: f32 = 0.5;

/// How much more few lights bring than all: each is as strong as its whole subset, and a spot that it makes stays for
/// several frames, so that rays bring more.
const OF_FEW: f32 = 0.25;

/// Approximate number of lights in a subset, of which a sample uses few; the number for visible points.
const OF_SHARE: usize = 32;
const SEEN_FEW: u32 = 2;

/// Approximate number of lights in a subset for invisible points, if all pixels use all lights.
const OF_UNSEEN: usize = 128;

/// How much more virtual lights bring where the eye does not see: spots blur there, and rays that go on are noisier.
const UNSEEN: f32 = 4.0;
