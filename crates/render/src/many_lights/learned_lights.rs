// SPDX-License-Identifier: GPL-3.0-or-later
//! Learns which lights matter to the camera: light paths of instant radiosity start there more often.
//! Source: [WBS03b]: a first pass of particles finds the lights that contribute. Differs: the weights apply
//! to the number that chooses a light, cut into bins, so any kind of light works; each bin keeps a minimum,
//! so the mean does not change.
//! Tests: crates/render/tests/many_lights.rs.

use super::bound::bound_of;
use super::chunks::in_chunks;
use super::light_choice::LightChoice;
use super::light_path::{self, pair};
use super::pilots::{Pilots, Scratch, VisibleMask};
use crate::job::Job;
use crate::stats::RenderStats;
use crate::world::World;

/// Parts of the range of numbers that choose a light.
const BINS: usize = 256;
/// Particles that the importance is learned from.
const PARTICLES: u32 = 2048;
/// The number of lights below which nothing is learned.
const FEW: usize = 4;

/// The choice of lights for light paths, if it is worth learning; learned once for a job.
pub(super) fn light_choice<'j>(job: &'j Job, stats: &mut RenderStats) -> Option<&'j LightChoice> {
    let light_choices = &job.common.light_choices;
    if light_choices.get().is_none() {
        // Outside of the lock: a thread that waits in the pool executes other tasks, which may need the lock.
        // A second thread has computed the same.
        let _ = light_choices.set(learned(job, stats));
    }
    light_choices.get().and_then(Option::as_ref)
}

/// Learned by particles; `None` where all paths may start by power.
pub(super) fn learned(job: &Job, stats: &mut RenderStats) -> Option<LightChoice> {
    if !has_many_lights(job.world) {
        return None;
    }
    let mut tracer = job.tracer(false);
    let pilots = Pilots::new(job, &mut tracer, u32::MAX, bound_of(job.world, job.options));
    stats.add(&tracer.take_stats());
    let numbers = light_path::numbers(job.options.seed_of_lights(), u32::MAX - 1);
    let max_edges = job.options.max_depth.saturating_sub(2);
    let found = in_chunks(job, PARTICLES, stats, |tracer, range| {
        let vertices = light_path::trace(tracer, range, &numbers, max_edges);
        let points: Vec<_> = vertices.iter().map(|v| (v.vpl.point, &v.vpl.bsdf)).collect();
        let mut scratch = Scratch::default();
        let mask = pilots.visible_from(tracer, &points, &mut scratch);
        let mut importance = |v: &light_path::LightVertex, mask: &VisibleMask| {
            (v.path, f64::from(pilots.importance(&v.vpl, mask, &mut scratch)))
        };
        vertices.iter().zip(&mask).map(|(v, mask)| importance(v, mask)).collect::<Vec<_>>()
    });
    let mut sums = vec![0.0; BINS];
    for (path, importance) in found.into_iter().flatten() {
        let [choice, _] = numbers(path, 0, pair::LOBE);
        sums[((choice * BINS as f32) as usize).min(BINS - 1)] += importance;
    }
    LightChoice::from_sums(&sums)
}

/// Whether there are so many lights that their importance may differ.
pub(super) fn has_many_lights(world: &World) -> bool {
    world.light_set().len() + world.plugin_emitters().len() > FEW
}
