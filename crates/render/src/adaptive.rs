// SPDX-License-Identifier: GPL-3.0-or-later
//! How many samples a tile needs so that its noise falls below a target.
//! Two-stage sampling after Stein [Ste45]. A pilot rendering under another seed decides the number and is
//! then discarded. The number is thus independent of the samples of the picture, and the means stay unbiased;
//! stopping as soon as samples look quiet would bias them. Noise of a tile: root of the mean variance of its
//! pixels' means, over its mean radiance. Cost: the pilot is 16 samples, and beyond that about an eighth of
//! the following samples at most.
//! Tests: `tests`, crates/render/tests/checkpoint.rs.

use crate::film::TileFilm;
use crate::job::Job;
use crate::mattes::Mattes;
use crate::options::RenderOptions;
use crate::sampler::Sampler;
use crate::stats::RenderStats;
use crate::tracer::BatchTracer;
use crate::transport::links::LinkedPaths;

/// No tile gets fewer samples, and no pilot is smaller.
pub(crate) const FEWEST: u32 = 16;
/// The seed of pilots differs in these bits.
const PILOT: u64 = 0x5851_f42d_4c95_7f2d;

/// Samples that bring the noise of a tile to `noise`, between [`FEWEST`] and all that the options allow.
pub(crate) fn samples_needed(job: &Job, rect: [u32; 4], noise: f32, stats: &mut RenderStats) -> u32 {
    let most = job.options.spp;
    let options =
        RenderOptions { seed: job.options.seed ^ PILOT, aovs: false, heatmap: false, ..job.options.clone() };
    let options = RenderOptions { light_layers: Vec::new(), mattes: Mattes::default(), ..options };
    let pilot = Job::new(job.world, job.camera, &options, job.watch);
    let pilot = Sampler { job: &pilot, pass: None };
    let mut tile = TileFilm::new(rect, false, true);
    let mut tracer = BatchTracer::new(job.world, &options, false);
    tracer.properties = Some(job.properties);
    tracer.wavefront.linked = job.links.clone().map(LinkedPaths::new);
    tracer.caustics = job.caustics.as_deref();
    let mut taken = FEWEST;
    let needed = loop {
        while tile.samples < taken {
            pilot.render_samples(&mut tile, &mut tracer, taken);
        }
        let needed = needed(&tile, noise).clamp(FEWEST.min(most), most);
        if taken.saturating_mul(8) >= needed {
            break needed;
        }
        taken *= 4;
    };
    // Its rays were traced; its samples are not in the picture.
    stats.add(&tracer.take_stats().without_samples());
    needed
}

fn needed(tile: &TileFilm, noise: f32) -> u32 {
    let n = f64::from(tile.samples);
    let (mut variance, mut mean) = (0.0, 0.0);
    for (sum, squares) in tile.sums.iter().zip(&tile.squares) {
        for k in 0..3 {
            variance += (squares[k] - sum[k] * sum[k] / n).max(0.0) / (n - 1.0);
            mean += sum[k] / n;
        }
    }
    let values = 3.0 * tile.sums.len() as f64;
    let (variance, requested) = (variance / values, f64::from(noise) * mean / values);
    if variance > 0.0 {
        (variance / (requested * requested)).ceil().min(f64::from(u32::MAX)) as u32
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use gnurt_accel::HitBatch;
    use gnurt_shading::Vec3s;

    #[test]
    fn noise_falls_with_the_root() {
        let mut tile = TileFilm::new([0, 0, 2, 1], false, true);
        // Mean 1, variance 1 (with n - 1: 100 / 99).
        for i in 0..100 {
            let radiance = Vec3s::splat(2, Vec3::splat(f32::from(u8::from(i % 2 == 0)) * 2.0));
            let mut hits = HitBatch::default();
            hits.reset(2);
            tile.add_sample(&radiance, (&hits, &[], &[]), 0..2);
        }
        let at = needed(&tile, 0.1);
        assert!((100..=102).contains(&at), "1 / 0.1² = {at}");
        assert_eq!(needed(&tile, 1e-20), u32::MAX, "no overflow");
        assert_eq!(
            needed(&TileFilm { samples: 4, ..TileFilm::new([0, 0, 2, 1], false, true) }, 0.1),
            0,
            "dark"
        );
    }
}
