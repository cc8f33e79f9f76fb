// SPDX-License-Identifier: GPL-3.0-or-later
//! Searches for caustics of a picture: its smooth surfaces and lamps, and a pilot that tells where searches are worth their rays: a few
//! samples of the whole picture at a reduced size, by paths, under another seed. The pilot is discarded.
//! Invariant: the chances depend on world, camera and options, neither on threads, crops, pieces nor numbers of samples.
//! Memory: a search of each vertex of the pilot's paths at most, 20 bytes each. Tests: crates/render/tests/caustics.rs.

use std::sync::Arc;
use std::time::Instant;

use gnurt_accel::threads::{self, Pieces};
use gnurt_shading::CameraShader;

use crate::film::TileFilm;
use crate::job::Job;
use crate::options::{Guiding, Integrator, RenderOptions};
use crate::progress::Watch;
use crate::sampler::Sampler;
use crate::stats::RenderStats;
use crate::transport::manifold::{self, Caustics, Places};
use crate::world::World;

/// The seed of the pilot differs in these bits.
const PILOT: u64 = 0x5851_f42d_4c95_7f2d;
/// Its paths, about.
const PATHS: u32 = 80_000;
/// Samples of its pixels, at most.
const MOST_SAMPLES: u32 = 64;

/// Smooth surfaces and lamps with chances, and the rays of the pilot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Learned {
    pub(crate) caustics: Option<Arc<Caustics>>,
    pub(crate) cost: RenderStats,
}

/// Finds smooth surfaces and lamps, if the options ask for them, and renders the pilot. `None` if it was told to stop.
pub(crate) fn learn(
    world: &World,
    camera: &dyn CameraShader,
    options: &RenderOptions,
    (watch, deadline): (&dyn Watch, Option<Instant>),
    pool: &rayon::ThreadPool,
) -> Option<Learned> {
    let Some(caustics) = find(&Job::new(world, camera, options, watch)) else {
        return Some(Learned::default());
    };
    let options = pilot_options(options);
    let mut job = Job::new(world, camera, &options, watch);
    job.deadline = deadline;
    let sampler = Sampler { job: &job, pass: None };
    let mut tiles = TileFilm::cover([0, 0, options.width, options.height], &options);
    let pieces = Pieces::new(&mut tiles, 1);
    let render = |_: &mut (), n: usize| {
        let mut tracer = sampler.tracer();
        (tracer.caustics, tracer.searched) = (Some(&caustics), Some(Vec::new()));
        let tile = &mut pieces.lock(n)[0];
        while tile.samples < options.spp && !job.should_stop() {
            sampler.render_samples(tile, &mut tracer, options.spp);
        }
        (brightness(tile), tracer.searched.take().unwrap_or_default(), tracer.take_stats())
    };
    let of_tiles = pool.install(|| threads::map_with(true, pieces.count(), || (), render));
    if job.should_stop() {
        return None;
    }
    let (mut sum, mut searches, mut cost) = (0.0, Vec::new(), RenderStats::default());
    for (of_tile, searched, stats) in of_tiles {
        sum += of_tile;
        searches.extend(searched);
        cost.add(&stats);
    }
    let pixels = f64::from(options.width) * f64::from(options.height);
    let places = Places::new(&searches, (sum / pixels) as f32);
    // Its rays were traced; its samples are not in the picture.
    let cost = RenderStats { samples: 0, bad_samples: 0, ..cost };
    Some(Learned { caustics: Some(Arc::new(caustics.with_places(Some(places)))), cost })
}

/// Without a pilot.
pub(crate) fn find(job: &Job) -> Option<Caustics> {
    manifold::find(&mut job.tracer(false))
}

fn pilot_options(options: &RenderOptions) -> RenderOptions {
    let of_pilot = options.of_pilot(PILOT);
    let pixels = of_pilot.width.saturating_mul(of_pilot.height).max(1);
    RenderOptions {
        integrator: Integrator::Path,
        guiding: Guiding::Off,
        spp: (PATHS / pixels).clamp(1, MOST_SAMPLES),
        ..of_pilot
    }
}

/// Sum of the brightest channel of all pixels.
fn brightness(tile: &TileFilm) -> f64 {
    let of_pixel = |i| {
        let [r, g, b, _] = tile.mean(i);
        f64::from(r.max(g).max(b))
    };
    (0..tile.first.len()).map(of_pixel).sum()
}
