// SPDX-License-Identifier: GPL-3.0-or-later
//! Which lamps matter to the camera: light paths of instant radiosity start there more often.
//! Source: [WBS03b]: a first pass of particles finds the lamps whose light is seen. Differs: what is weighted is the number
//! that chooses a lamp, cut into bins, so any kind of lamp will do; each bin keeps a share, so the mean does not change.
//! Proof: `tests::weights_undo_the_choice`, crates/render/tests/many_lights.rs.

use gnurt_shading::sampling::Distribution;

use super::instant;
use super::light_path::{self, pair};
use super::pass::{bound_of, in_chunks};
use super::pilots::{Pilots, Scratch, Seen};
use crate::stats::RenderStats;
use crate::tile::Job;
use crate::tracer::BatchTracer;
use crate::world::World;

/// Parts of the range of numbers that choose a lamp.
const BINS: usize = 256;
/// Particles that the importance is learned from.
const PARTICLES: u32 = 2048;
/// Share of paths that is spread over all lamps by power.
const EVENLY: f64 = 0.25;
/// Lamps below which nothing is to be learned.
const FEW: usize = 4;

/// How numbers that choose lamps are bent.
#[derive(Clone, Debug)]
pub(crate) struct LampChoice {
    bins: Distribution,
}

impl LampChoice {
    /// Learned by particles; `None` where all paths may start by power.
    pub(crate) fn new(job: &Job, stats: &mut RenderStats) -> Option<Self> {
        if !Self::is_due(job.world) {
            return None;
        }
        let mut tracer = BatchTracer::new(job.world, job.options, false);
        let pilots = Pilots::new(job, &mut tracer, u32::MAX, bound_of(job.world, job.options));
        stats.add(&tracer.take_stats());
        let numbers = instant::numbers(job.options.seed, u32::MAX - 1);
        let max_edges = job.options.max_depth.saturating_sub(2);
        let found = in_chunks(job, PARTICLES, stats, |tracer, range| {
            let vertices = light_path::trace(tracer, range, &numbers, max_edges);
            let points: Vec<_> = vertices.iter().map(|v| (v.vpl.point, v.vpl.bsdf)).collect();
            let mut scratch = Scratch::default();
            let seen = pilots.seen_from(tracer, &points, &mut scratch);
            let mut importance = |v: &light_path::LightVertex, seen: &Seen| {
                (v.path, f64::from(pilots.importance(&v.vpl, seen, &mut scratch)))
            };
            vertices.iter().zip(&seen).map(|(v, seen)| importance(v, seen)).collect::<Vec<_>>()
        });
        let mut sums = vec![0.0; BINS];
        for (path, importance) in found.into_iter().flatten() {
            let [choice, _] = numbers(path, 0, pair::LOBE);
            sums[((choice * BINS as f32) as usize).min(BINS - 1)] += importance;
        }
        Self::from_sums(&sums)
    }

    /// Whether there are so many lamps that some of them may matter more.
    pub(crate) fn is_due(world: &World) -> bool {
        world.light_set().len() + world.shader_lamps().len() > FEW
    }

    fn from_sums(sums: &[f64]) -> Option<Self> {
        let total: f64 = sums.iter().sum();
        let share = |sum: &f64| (1.0 - EVENLY) * sum / total + EVENLY / sums.len() as f64;
        (total > 0.0).then(|| Distribution::new(sums.iter().map(share)))?.map(|bins| Self { bins })
    }

    /// The number that chooses a lamp in place of `u`, and the weight of its path.
    pub(super) fn bend(&self, u: f32) -> (f32, f32) {
        let choice = self.bins.sample(u);
        let count = self.bins.len() as f32;
        ((choice.index as f32 + choice.rest) / count, 1.0 / (count * choice.probability))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_undo_the_choice() {
        let choice = LampChoice::from_sums(&[0.0, 5.0, 1.0, 0.0]).expect("some matter");
        const N: u32 = 4096;
        let (mut sum, mut hit) = ([0.0_f64; 4], 0);
        for i in 0..N {
            let (u, weight) = choice.bend((i as f32 + 0.5) / N as f32);
            assert!((0.0..1.0).contains(&u), "a number: {u}");
            sum[(u * 4.0) as usize] += f64::from(weight) / f64::from(N);
            hit += u32::from((u * 4.0) as usize == 1);
        }
        assert!(sum.iter().all(|sum| (sum - 0.25).abs() < 0.01), "even on average: {sum:?}");
        assert!(hit > N / 2, "the lamp that matters has most paths: {hit}");
    }
}
