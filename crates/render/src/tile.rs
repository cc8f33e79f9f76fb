// SPDX-License-Identifier: GPL-3.0-or-later
//! Rendering of one tile, up to a number of samples or to a noise target.

use std::sync::atomic::Ordering;

use crate::adaptive::samples_needed;
use crate::cost::TileCosts;
use crate::film::TileFilm;
use crate::sampler::Sampler;
use crate::stats::RenderStats;
use crate::tracer::BatchTracer;

/// Brings a tile to `last` samples, or to fewer if it is time to stop.
pub(crate) fn render_tile(
    sampler: &Sampler,
    tile: &mut TileFilm,
    tracer: &mut BatchTracer,
    last: u32,
) -> RenderStats {
    let job = sampler.job;
    let mut pilot = RenderStats::default();
    if let Some(noise) = job.options.noise.filter(|_| tile.target == 0) {
        if job.should_stop() {
            return pilot;
        }
        tile.target = samples_needed(job, tile.rect, noise, &mut pilot);
    }
    let last = last.min(tile.requested(last));
    tracer.costs = job.options.heatmap.then(|| TileCosts::new(tile.rect, tracer.pixel_order));
    // Samples are taken in order, so that a tile that was interrupted in an earlier pass continues there.
    while tile.samples < last && !job.should_stop() {
        sampler.render_samples(tile, tracer, last);
    }
    if let Some(costs) = tracer.costs.take() {
        tile.costs.resize(costs.costs.len(), 0);
        tile.costs.iter_mut().zip(costs.costs).for_each(|(sum, cost)| *sum += cost);
    }
    let mut stats = tracer.take_stats();
    stats.add(&pilot);
    let done = job.samples_done.fetch_add(stats.samples, Ordering::Relaxed) + stats.samples;
    job.watch.update(done as f64 / job.all_samples as f64, done);
    stats
}
