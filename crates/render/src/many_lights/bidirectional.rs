// SPDX-License-Identifier: GPL-3.0-or-later
//! Bidirectional instant radiosity: many candidates from both sides, of which the important ones become
//! virtual lights.
//! Source: [SIMP06]; resampling [TCE05] by a candidate's contribution to the pilot points, weighted by the
//! exact probability of the choice, so that the mean does not change. Space: world. A candidate that is
//! chosen n times becomes one light of n times the power.
//! Tests: crates/render/tests/many_lights.rs.

use std::borrow::Borrow;
use std::ops::Range;

use glam::Vec3;
use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{hash_combine, sample_pair};

use super::bound::Bound;
use super::candidates::{Candidate, EyeSide, LightSide, eye_sides, joined, light_sides};
use super::chunks::in_chunks;
use super::cut::resample;
use super::pilots::Pilots;
use super::vpl::Vpl;
use super::{light_path, neighbours};
use crate::job::Job;
use crate::stats::RenderStats;

/// Paths per requested virtual light, each with several candidates, and the largest number of paths for more
/// than one per light.
const PATHS_PER_LIGHT: u32 = 4;
const ENOUGH: u32 = 8192;
/// Paths whose sides are joined each to each.
const CROWD: u32 = 4;
/// Marks numbers for resampling.
pub(super) const RESAMPLING: u32 = 0x4e5a_3b00;

/// The virtual lights of a pass.
pub(super) fn virtual_lights(job: &Job, sample: u32, bound: Bound, stats: &mut RenderStats) -> Vec<Vpl> {
    let found = Candidates::new(job, sample, bound, stats);
    let lights = found.light.iter().flat_map(|side| &side.own).map(|own| (own, 1.0));
    let eyes = found.eye.iter().filter_map(|side| side.own.as_ref()).map(|own| (own, 1.0));
    let joined = found.joined.iter().map(|([_, eye], own)| (own, found.share_of_pair(*eye)));
    let all: Vec<(&Candidate, f32)> = lights.chain(eyes).chain(joined).collect();
    let key = SampleKey { pixel: hash_combine(RESAMPLING, sample), sample: 0, branch: RESAMPLING };
    let [start, _] = sample_pair(job.options.seed_of_lights(), key, 0, 0);
    let (count, paths) = (job.options.vpls as usize, found.paths as f32);
    spread(&all, count, start).into_iter().map(|(i, weight)| all[i].0.vpl.scaled(weight / paths)).collect()
}

/// Chooses virtual lights in proportion to their weights, by stratified sampling; returns positions in the
/// list and weights.
pub(super) fn spread(all: &[(impl Borrow<Candidate>, f32)], count: usize, u: f32) -> Vec<(usize, f32)> {
    let positions: Vec<Vec3> = all.iter().map(|(own, _)| own.borrow().vpl.point.p).collect();
    let order = neighbours::in_order(&positions, 1);
    let importance = |&i: &u32| {
        let (own, share) = &all[i as usize];
        f64::from(own.borrow().importance * share)
    };
    let chosen = resample(order.iter().map(importance), count, u);
    let position = |(n, weight): (usize, f32)| (order[n] as usize, weight * all[order[n] as usize].1);
    chosen.into_iter().map(position).collect()
}

/// Both sides of the paths of a pass, and where they were joined.
pub(super) struct Candidates {
    pub(super) pilots: Pilots,
    pub(super) paths: u32,
    pub(super) light: Vec<LightSide>,
    pub(super) eye: Vec<EyeSide>,
    /// By the number of the path from the light, and of that from the eye.
    pub(super) joined: Vec<([u32; 2], Candidate)>,
}

impl Candidates {
    pub(super) fn new(job: &Job, sample: u32, bound: Bound, stats: &mut RenderStats) -> Self {
        let mut tracer = job.tracer(false);
        let pilots = Pilots::new(job, &mut tracer, sample, bound);
        stats.add(&tracer.take_stats());
        let vpls = job.options.vpls;
        let paths = vpls.saturating_mul(PATHS_PER_LIGHT).min(ENOUGH).max(vpls).max(64);
        let numbers = light_path::numbers(job.options.seed_of_lights(), sample);
        let chunks = in_chunks(job, paths, stats, |tracer, range| {
            let first = range.start;
            let light = light_sides(tracer, &pilots, range.clone(), &numbers);
            let eye = eye_sides(tracer, &pilots, range.clone(), &numbers);
            let pairs: Vec<[u32; 2]> = range.flat_map(|i| crowd_of(i, paths).map(move |k| [i, k])).collect();
            let both = pairs.iter().map(|[i, k]| (&light[(i - first) as usize], &eye[(k - first) as usize]));
            let joined = joined(tracer, &pilots, both);
            let joined: Vec<_> = joined.into_iter().map(|(pair, own)| (pairs[pair], own)).collect();
            (light, eye, joined)
        });
        let (mut light, mut eye, mut joined) = (Vec::new(), Vec::new(), Vec::new());
        for chunk in chunks {
            light.extend(chunk.0);
            eye.extend(chunk.1);
            joined.extend(chunk.2);
        }
        Self { pilots, paths, light, eye, joined }
    }

    /// The paths whose sides this one's are joined to.
    pub(super) fn crowd_of(&self, path: u32) -> Range<u32> {
        crowd_of(path, self.paths)
    }

    /// The weight of each of them.
    pub(super) fn share_of_pair(&self, path: u32) -> f32 {
        1.0 / self.crowd_of(path).len() as f32
    }
}

fn crowd_of(path: u32, paths: u32) -> Range<u32> {
    let first = path / CROWD * CROWD;
    first..(first + CROWD).min(paths)
}
