// SPDX-License-Identifier: GPL-3.0-or-later
//! Searches for caustics of a picture: its smooth surfaces and lamps, and a pilot that tells where searches are worth their rays: a few
//! samples of the whole picture at a reduced size, by paths, under another seed. The pilot is discarded. By `auto`
//! pictures whose searches would spare next to no variance make none.
//! Invariant: the chances depend on world, camera and options, neither on threads, crops, pieces nor numbers of samples.
//! Memory: a search of each vertex of the pilot's paths at most, 24 bytes each. Tests: crates/render/tests/caustics.rs.

use std::sync::Arc;
use std::time::Instant;

use gnurt_accel::threads::{self, Pieces};
use gnurt_shading::CameraShader;

use crate::film::TileFilm;
use crate::job::Job;
use crate::options::{Caustics as Wanted, Guiding, Integrator, RenderOptions};
use crate::progress::Watch;
use crate::sampler::Sampler;
use crate::stats::RenderStats;
use crate::transport::manifold::{self, Caustics, Places, Searched};
use crate::world::World;

/// The seed of the pilot differs in these bits.
const PILOT: u64 = 0x5851_f42d_4c95_7f2d;
/// Its paths, about.
const PATHS: u32 = 80_000;
/// Samples of its pixels, at most.
const MOST_SAMPLES: u32 = 256;
/// `auto`: the variance of a sample over the picture's squared mean that searches have to spare.
const PAYS: f64 = 0.1;
/// It ends after one in so many samples where they spare less.
const FIRST: u32 = 4;

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
    let mut tiles: Vec<Tile> = TileFilm::cover([0, 0, options.width, options.height], &options)
        .into_iter()
        .map(|film| Tile { film, searches: Vec::new() })
        .collect();
    let pixels = f64::from(options.width) * f64::from(options.height);
    let mut cost = RenderStats::default();
    for last in [options.spp.div_ceil(FIRST), options.spp] {
        let pieces = Pieces::new(&mut tiles, 1);
        let render = |_: &mut (), n: usize| pieces.lock(n)[0].render(&job, &caustics, last);
        let of_tiles = pool.install(|| threads::map_with(true, pieces.count(), || (), render));
        if job.should_stop() {
            return None;
        }
        of_tiles.iter().for_each(|stats| cost.add(stats));
        let brightness = brightness(&tiles, pixels);
        let spared: f64 =
            tiles.iter().flat_map(|tile| &tile.searches).map(|search| f64::from(search.spared)).sum();
        let least = PAYS * brightness * brightness * pixels * f64::from(last);
        let pays = spared > least;
        if !pays && options.caustics != Wanted::On {
            return Some(Learned { caustics: None, cost: cost.without_samples() });
        }
    }
    let brightness = brightness(&tiles, pixels) as f32;
    let searches: Vec<Searched> = tiles.into_iter().flat_map(|tile| tile.searches).collect();
    let caustics = caustics.with_places(Some(Places::new(&searches, brightness)));
    Some(Learned { caustics: Some(Arc::new(caustics)), cost: cost.without_samples() })
}

/// A part of the pilot.
struct Tile {
    film: TileFilm,
    searches: Vec<Searched>,
}

impl Tile {
    /// Takes samples up to `last`.
    fn render(&mut self, job: &Job, caustics: &Caustics, last: u32) -> RenderStats {
        let sampler = Sampler { job, pass: None };
        let mut tracer = sampler.tracer();
        (tracer.caustics, tracer.searched) = (Some(caustics), Some(std::mem::take(&mut self.searches)));
        while self.film.samples < last && !job.should_stop() {
            sampler.render_samples(&mut self.film, &mut tracer, last);
        }
        self.searches = tracer.searched.take().unwrap_or_default();
        tracer.take_stats()
    }

    /// Sum of the brightest channel of all pixels.
    fn brightness(&self) -> f64 {
        let of_pixel = |i| {
            let [r, g, b, _] = self.film.mean(i);
            f64::from(r.max(g).max(b))
        };
        (0..self.film.first.len()).map(of_pixel).sum()
    }
}

/// The mean brightness of all pixels.
fn brightness(tiles: &[Tile], pixels: f64) -> f64 {
    tiles.iter().map(Tile::brightness).sum::<f64>() / pixels
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
