// SPDX-License-Identifier: GPL-3.0-or-later
//! The pilot that teaches a guide: a few samples of the whole picture at a reduced size, under another seed, in rounds of
//! which each is guided by those before.
//! Source: [MGN17] (rounds that double), [MMRGN19] (all rounds teach). The pilot is discarded: samples of the picture do not depend
//! on each other.
//! Invariant: the guide depends on world, camera and options, neither on threads, crops, pieces nor numbers of samples.
//! Memory: at most [`MOST_VERTICES`] vertices and [`MOST_BYTES`] of the map.
//! Tests: crates/render/tests/guide.rs.

use std::time::Instant;

use gnurt_accel::threads;
use gnurt_shading::CameraShader;

use crate::film::TileFilm;
use crate::guide::{self, Guide, Recorder};
use crate::job::Job;
use crate::mattes::Mattes;
use crate::options::{AUTO_FROM, Guiding, Integrator, RenderOptions};
use crate::progress::Unwatched;
use crate::sampler::Sampler;
use crate::stats::{GuideStats, RenderStats};
use crate::tracer::BatchTracer;
use crate::transport::links::LinkedPaths;
use crate::world::World;

/// The seed of the pilot differs in these bits.
const PILOT: u64 = 0x2545_f491_4f6c_dd1d;
/// The pilot has about as many pixels at most.
const MOST_PIXELS: u32 = 20_000;
/// Samples of each round.
const ROUNDS: [u32; 4] = [1, 1, 2, 4];
/// No further round begins with more vertices: 60 MB.
const MOST_VERTICES: usize = 1 << 20;
/// A larger map is not used.
const MOST_BYTES: usize = 64 << 20;
/// `auto` guides if the second moment of light falls to this share.
const PAYS: f32 = 0.75;

/// A guide, and from which sample on it is used.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trained {
    pub(crate) guide: Option<Guide>,
    pub(crate) stats: GuideStats,
    /// What the pilot traced.
    pub(crate) cost: RenderStats,
}

/// The first sample that a guide is asked for; `None` if it never is.
pub(crate) fn guided_from(options: &RenderOptions) -> Option<u32> {
    match (options.integrator, options.guiding) {
        (Integrator::Path, Guiding::On) => Some(0),
        (Integrator::Path, Guiding::Auto) => Some(AUTO_FROM),
        _ => None,
    }
}

/// Renders the pilot and learns from it.
pub(crate) fn train(
    world: &World,
    camera: &dyn CameraShader,
    options: &RenderOptions,
    pool: &rayon::ThreadPool,
) -> Trained {
    let begin = Instant::now();
    let options = pilot_options(options);
    let mut job = Job::new(world, camera, &options, &Unwatched);
    job.light_paths = None;
    let Ok(region) = options.region() else { return Trained::default() };
    let rects: Vec<[u32; 4]> = TileFilm::rects(region, &options).collect();
    let mut tiles: Vec<Tile> = rects.into_iter().map(Tile::new).collect();
    let mut cost = RenderStats::default();
    let (mut guide, mut taken) = (Guide::default(), 0);
    for round in ROUNDS {
        let last = taken + round;
        let of_tiles = pool.install(|| {
            let tiles = threads::Pieces::new(&mut tiles, 1);
            let render = |_: &mut (), n: usize| tiles.lock(n)[0].render(&job, &guide, last);
            threads::map_with(true, tiles.count(), || (), render)
        });
        of_tiles.iter().for_each(|stats| cost.add(stats));
        taken = last;
        guide = pool.install(|| learn(&tiles));
        if tiles.iter().map(|tile| tile.recorder.vertices.len()).sum::<usize>() >= MOST_VERTICES {
            break;
        }
    }
    let pays = guide.moment() < PAYS || options.guiding == Guiding::On;
    let fits = guide.bytes() <= MOST_BYTES;
    let [cells, nodes] = guide.size();
    let stats = GuideStats {
        is_on: pays && fits,
        is_too_large: !fits,
        moment: guide.moment(),
        cells,
        nodes,
        bytes: guide.bytes(),
        seconds: begin.elapsed().as_secs_f64(),
    };
    // Its rays were traced; its samples are not in the picture.
    let cost = RenderStats { samples: 0, bad_samples: 0, ..cost };
    Trained { guide: (pays && fits).then_some(guide), stats, cost }
}

/// Options of the whole picture, smaller, and of nothing but light.
fn pilot_options(options: &RenderOptions) -> RenderOptions {
    let pixels = f64::from(options.width) * f64::from(options.height);
    let scale = (f64::from(MOST_PIXELS) / pixels).sqrt().min(1.0);
    let scaled = |size: u32| ((f64::from(size) * scale).round() as u32).max(1);
    RenderOptions {
        width: scaled(options.width),
        height: scaled(options.height),
        seed: options.seed ^ PILOT,
        crop: None,
        piece: None,
        rows: None,
        noise: None,
        time_limit: None,
        aovs: false,
        seen: false,
        heatmap: false,
        pixel_centres: false,
        light_layers: Vec::new(),
        mattes: Mattes::default(),
        spp: ROUNDS.iter().sum(),
        ..options.clone()
    }
}

/// A part of the pilot.
struct Tile {
    film: TileFilm,
    recorder: Recorder,
}

impl Tile {
    fn new(rect: [u32; 4]) -> Self {
        Self { film: TileFilm::new(rect, false, false), recorder: Recorder::default() }
    }

    fn render(&mut self, job: &Job, guide: &Guide, last: u32) -> RenderStats {
        let mut tracer = BatchTracer::new(job.world, job.options, false);
        tracer.properties = Some(job.properties);
        tracer.cone = job.cone;
        tracer.wavefront.linked = job.links.clone().map(LinkedPaths::new);
        tracer.wavefront.recorder = Some(std::mem::take(&mut self.recorder));
        tracer.guide_from = Some((guide, 0));
        let sampler = Sampler { job, pass: None };
        while self.film.samples < last {
            sampler.render_samples(&mut self.film, &mut tracer, last);
        }
        self.recorder = tracer.wavefront.recorder.take().unwrap_or_default();
        tracer.take_stats()
    }

    /// The mean radiance.
    fn mean(&self) -> f32 {
        let count = self.film.first.len().max(1);
        let sum: f64 = (0..self.film.first.len())
            .map(|i| {
                let [r, g, b, _] = self.film.mean(i);
                f64::from(r + g + b) / 3.0
            })
            .sum();
        (sum / count as f64) as f32
    }
}

/// Builds the guide from all vertices so far.
fn learn(tiles: &[Tile]) -> Guide {
    let means: Vec<f32> = tiles.iter().map(Tile::mean).collect();
    let mean = means.iter().sum::<f32>() / means.len().max(1) as f32;
    let weighted = tiles.iter().zip(&means).flat_map(|(tile, &own)| {
        let weight = 1.0 / (own + 0.1 * mean).max(f32::MIN_POSITIVE);
        tile.recorder.vertices.iter().map(move |vertex| (vertex, weight))
    });
    let vertices: Vec<guide::Weighted> = weighted.collect();
    guide::build(&vertices)
}
