// SPDX-License-Identifier: GPL-3.0-or-later
//! Bidirectional instant radiosity: many candidates from both sides, of which the ones that matter become virtual lights.
//! Source: [SIMP06]; resampling [TCE05] by what a candidate brings to pilots, with the exact probability of its choice as
//! weight, so that the mean does not change. Space: world.
//! A candidate that is chosen more than once becomes one light, as many times as strong.
//! Proof: crates/render/tests/many_lights.rs.

use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{hash_combine, sample_pair};

use super::bound::Bound;
use super::candidates::{Candidate, candidates};
use super::cut::resample;
use super::instant;
use super::pass::in_chunks;
use super::pilots::Pilots;
use super::vpl::Vpl;
use crate::stats::RenderStats;
use crate::tile::Job;
use crate::tracer::BatchTracer;

/// Paths per virtual light that was asked for; each has several candidates.
const PATHS_PER_LIGHT: u32 = 1;
/// Says that a number is for resampling.
pub(super) const RESAMPLING: u32 = 0x4e5a_3b00;

/// The virtual lights of a pass.
pub(super) fn virtual_lights(job: &Job, sample: u32, bound: Bound, stats: &mut RenderStats) -> Vec<Vpl> {
    let (pilots, paths, found) = all_candidates(job, sample, bound, stats);
    drop(pilots);
    let found: Vec<Candidate> = found.into_iter().flatten().collect();
    let count = job.options.vpls as usize;
    let key = SampleKey { pixel: hash_combine(RESAMPLING, sample), sample: 0, branch: RESAMPLING };
    let [start, _] = sample_pair(job.options.seed, key, 0, 0);
    let chosen = resample(found.iter().map(|c| f64::from(c.importance)), count, start);
    chosen.into_iter().map(|(i, weight)| found[i].vpl.scaled(weight / paths as f32)).collect()
}

/// Pilots of a pass, the number of paths, and the candidates on each of them.
pub(super) fn all_candidates(
    job: &Job,
    sample: u32,
    bound: Bound,
    stats: &mut RenderStats,
) -> (Pilots, u32, Vec<Vec<Candidate>>) {
    let mut tracer = BatchTracer::new(job.world, job.options, false);
    let pilots = Pilots::new(job, &mut tracer, sample, bound);
    stats.add(&tracer.take_stats());
    let paths = (job.options.vpls * PATHS_PER_LIGHT).max(64);
    let numbers = instant::numbers(job.options.seed, sample);
    let chunks = in_chunks(job, paths, stats, |tracer, range| candidates(tracer, &pilots, range, &numbers));
    (pilots, paths, chunks.into_iter().flatten().collect())
}
