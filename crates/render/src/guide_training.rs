// SPDX-License-Identifier: GPL-3.0-or-later
//! The pilot that teaches a guide: a few samples of the whole picture at a reduced size, under another seed, in rounds of
//! which each is guided by those before.
//! Source: [MGN17] (rounds that double), [VHH*19] (all rounds teach). The pilot is discarded: samples of the picture do not depend
//! on each other.
//! Invariant: the guide depends on world, camera and options, neither on threads, crops, pieces nor numbers of samples.
//! Memory: at most [`MOST_VERTICES`] vertices, and the map that follows from them.
//! Tests: crates/render/tests/guide.rs.

use std::sync::Arc;
use std::time::Instant;

use gnurt_accel::threads;
use gnurt_shading::CameraShader;

use crate::film::TileFilm;
use crate::guide::{self, Guide, Recorder};
use crate::job::Job;
use crate::options::{Guiding, RenderOptions};
use crate::progress::Watch;
use crate::sampler::Sampler;
use crate::stats::{GuideStats, RenderStats};
use crate::tracer::BatchTracer;
use crate::transport::links::LinkedPaths;
use crate::transport::manifold::Caustics;
use crate::world::World;

/// The seed of the pilot differs in these bits.
const PILOT: u64 = 0x2545_f491_4f6c_dd1d;
/// Width of its parts in pixels.
const TILE: u32 = 32;
/// Vertices that are stored: 120 MB. Directional trees have a node for 30 of them in each of 7 levels at most: 16 MB.
const MOST_VERTICES: usize = 1 << 21;
/// `auto` guides if the second moment of light falls to this share.
const PAYS: f32 = 0.7;
/// The moment seldom falls by more with a doubling of the pilot's samples: a pilot that would have to, to come down to [`PAYS`], is given up.
const FALLS: f32 = 0.08;
/// Vertices by which that is judged.
const ENOUGH: usize = 20_000;

/// A guide, and from which sample on it is used.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trained {
    pub(crate) guide: Option<Guide>,
    pub(crate) stats: GuideStats,
    /// The rays of the pilot.
    pub(crate) cost: RenderStats,
}

/// Renders the pilot and learns from it; `None` if it was told to stop.
pub(crate) fn train(
    world: &World,
    camera: &dyn CameraShader,
    (options, caustics): (&RenderOptions, Option<Arc<Caustics>>),
    (watch, deadline): (&dyn Watch, Option<Instant>),
    pool: &rayon::ThreadPool,
) -> Option<Trained> {
    let begin = Instant::now();
    let options = options.of_pilot(PILOT);
    let mut job = Job::new(world, camera, &options, watch);
    job.deadline = deadline;
    job.caustics = caustics;
    let region = [0, 0, options.width, options.height];
    let rects: Vec<[u32; 4]> = rects(region).collect();
    let most = MOST_VERTICES / rects.len().max(1);
    let mut tiles: Vec<Tile> = rects.into_iter().map(|rect| Tile::new(rect, most)).collect();
    let mut cost = RenderStats::default();
    let (mut guide, mut taken, mut vertices) = (Guide::default(), 0, 0);
    while taken < options.spp {
        taken = (2 * taken).max(1);
        let of_tiles = pool.install(|| {
            let tiles = threads::Pieces::new(&mut tiles, 1);
            let render = |_: &mut (), n: usize| tiles.lock(n)[0].render(&job, &guide, taken);
            threads::map_with(true, tiles.count(), || (), render)
        });
        if job.should_stop() {
            return None;
        }
        of_tiles.iter().for_each(|stats| cost.add(stats));
        tiles.iter_mut().for_each(|tile| tile.recorder.drop_dark());
        vertices = tiles.iter().map(|tile| tile.recorder.vertices.len()).sum();
        let may_end = options.guiding == Guiding::Auto && vertices >= ENOUGH;
        guide = pool.install(|| learn(&tiles, taken >= options.spp || may_end));
        let doublings = (options.spp as f32 / taken as f32).log2();
        if may_end && guide.moment() > PAYS + FALLS * doublings {
            break;
        }
    }
    let is_on = guide.moment() < PAYS || options.guiding == Guiding::On;
    let [cells, nodes] = guide.size();
    let stats = GuideStats {
        is_on,
        moment: guide.moment(),
        vertices,
        cells,
        nodes,
        bytes: guide.bytes(),
        seconds: begin.elapsed().as_secs_f64(),
    };
    Some(Trained { guide: is_on.then_some(guide), stats, cost: cost.without_samples() })
}

/// The parts of the pilot: larger than tiles of pictures, since rounds take few samples.
fn rects([x0, y0, x1, y1]: [u32; 4]) -> impl Iterator<Item = [u32; 4]> {
    let starts = |low: u32, high: u32| (low..high).step_by(TILE as usize);
    let corners = starts(y0, y1).flat_map(move |y| starts(x0, x1).map(move |x| [x, y]));
    corners.map(move |[x, y]| [x, y, (x + TILE).min(x1), (y + TILE).min(y1)])
}

/// A part of the pilot.
struct Tile {
    film: TileFilm,
    recorder: Recorder,
}

impl Tile {
    fn new(rect: [u32; 4], most: usize) -> Self {
        Self { film: TileFilm::new(rect, false, false), recorder: Recorder::new(most) }
    }

    fn render(&mut self, job: &Job, guide: &Guide, last: u32) -> RenderStats {
        let mut tracer = BatchTracer::new(job.world, job.options, false);
        tracer.properties = Some(job.properties);
        tracer.cone = job.cone;
        tracer.wavefront.linked = job.links.clone().map(LinkedPaths::new);
        tracer.wavefront.recorder = Some(std::mem::take(&mut self.recorder));
        tracer.guide_from = Some((guide, 0));
        tracer.caustics = job.caustics.as_deref();
        let sampler = Sampler { job, pass: None };
        while self.film.samples < last && !job.should_stop() {
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
fn learn(tiles: &[Tile], learns: bool) -> Guide {
    let means: Vec<f32> = tiles.iter().map(Tile::mean).collect();
    let mean = means.iter().sum::<f32>() / means.len().max(1) as f32;
    let weighted = tiles.iter().zip(&means).flat_map(|(tile, &own)| {
        let weight = 1.0 / (own + 0.1 * mean).max(f32::MIN_POSITIVE);
        tile.recorder.vertices.iter().map(move |vertex| (vertex, weight))
    });
    let vertices: Vec<guide::Weighted> = weighted.collect();
    guide::build(&vertices, learns)
}
