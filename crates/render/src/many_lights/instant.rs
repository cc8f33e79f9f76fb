// SPDX-License-Identifier: GPL-3.0-or-later
//! Instant radiosity: virtual lights are the vertices of quasi-random light paths, as many paths as give about the number
//! of lights that was asked for.
//! Source: [Kel97]; paths start at lights that matter to the camera [WBS03b], see `light_choices`; hash-scrambled Sobol' points [Bur20] in place of Halton's. Space: world.
//! Tests: crates/render/tests/many_lights.rs.

use std::ops::Range;

use super::chunks::in_chunks;
use super::learned_lights::light_choice;
use super::light_choice::LightChoice;
use super::light_path::{self, LightVertex, numbers, pair};
use super::vpl::Vpl;
use crate::job::Job;
use crate::stats::RenderStats;

/// Paths that the mean number of vertices per path is learned from.
const PILOTS: u32 = 256;

/// Vertices of some light paths of a set, path by path, edge by edge; `light_choices` are the important
/// lights.
pub(super) fn vertices(
    job: &Job,
    light_choices: Option<&LightChoice>,
    set: u32,
    paths: Range<u32>,
    stats: &mut RenderStats,
) -> Vec<LightVertex> {
    let (first, paths) = (paths.start, paths.len() as u32);
    let of_set = numbers(job.options.seed_of_lights(), set);
    let plain = |path: u32, edge: u32, which: u32| of_set(first + path, edge, which);
    // Only the number that chooses a light is warped towards the important ones.
    let bent = |path: u32| {
        let [choice, rest] = plain(path, 0, pair::LOBE);
        let (choice, weight) =
            light_choices.map_or((choice, 1.0), |light_choices| light_choices.bend(choice));
        ([choice, rest], weight)
    };
    let numbers = |path: u32, edge: u32, which: u32| {
        if (edge, which) == (0, pair::LOBE) { bent(path).0 } else { plain(path, edge, which) }
    };
    // The eye's own edge and the one to the virtual light are not part of the path.
    let max_edges = job.options.max_depth.saturating_sub(2);
    let chunks =
        in_chunks(job, paths, stats, |tracer, range| light_path::trace(tracer, range, &numbers, max_edges));
    let mut all: Vec<LightVertex> = chunks.into_iter().flatten().filter(|v| v.vpl.emits()).collect();
    all.sort_by_key(|v| (v.path, v.vpl.edges));
    all.iter_mut().for_each(|v| v.vpl = v.vpl.scaled(bent(v.path).1));
    all
}

/// The number of paths with about `vertices` emitting vertices: a property of world and options alone.
pub(super) fn paths_for(
    job: &Job,
    light_choices: Option<&LightChoice>,
    count: u32,
    stats: &mut RenderStats,
) -> u32 {
    let found = vertices(job, light_choices, u32::MAX, 0..PILOTS, stats).len().max(1);
    let paths = f64::from(count) * f64::from(PILOTS) / found as f64;
    (paths.ceil() as u32).clamp(1, count.max(1) * 64)
}

/// The virtual lights of a pass.
pub(super) fn virtual_lights(job: &Job, sample: u32, stats: &mut RenderStats) -> Vec<Vpl> {
    let light_choices = light_choice(job, stats);
    // Not inside of the lock, as `light_choice`.
    let known = job.common.paths.get().copied();
    let found = known.unwrap_or_else(|| paths_for(job, light_choices, job.options.vpls, stats));
    let paths = *job.common.paths.get_or_init(|| found);
    let found = vertices(job, light_choices, sample, 0..paths, stats);
    found.iter().map(|v| v.vpl.scaled(1.0 / paths as f32)).collect()
}
