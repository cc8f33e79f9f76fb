// SPDX-License-Identifier: GPL-3.0-or-later
//! One tile, one sample of each of its pixels: camera rays, hits, radiance, film.
//! Source: original; samples placed by the filter [EST06].
//! A batch is one sample of all pixels of a tile, or several, where many rays together are worth more than few. What a ray
//! brings does not depend on the others, and samples are added in order: pictures do not depend on batches.

use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, Ray, RayBatch};
use gnurt_image::Filter;
use gnurt_shading::sampling::{purpose, sample_pair, sample_pairs};
use gnurt_shading::{CameraShader, SampleKey, Vec3s};
use gnurt_simd::dispatch_wide;

use crate::adaptive::samples_needed;
use crate::cone::Cone;
use crate::cost::TileCosts;
use crate::film::TileFilm;
use crate::integrators;
use crate::many_lights::interleave::{Seen, Texel};
use crate::many_lights::{self, LampChoice, PassLights};
use crate::options::{Integrator, RenderOptions};
use crate::progress::Progress;
use crate::stats::RenderStats;
use crate::tracer::BatchTracer;
use crate::world::{HitLanes, World};

/// What all tiles of a rendering share.
pub(crate) struct Job<'a> {
    pub(crate) world: &'a World,
    pub(crate) camera: &'a dyn CameraShader,
    pub(crate) options: &'a RenderOptions,
    pub(crate) filter: Filter,
    pub(crate) progress: &'a dyn Progress,
    pub(crate) deadline: Option<Instant>,
    /// Samples that the whole rendering will take.
    pub(crate) all_samples: u64,
    pub(crate) samples_done: AtomicU64,
    /// Once somebody was told to stop, all stop.
    pub(crate) stopped: AtomicBool,
    /// Unit direction of view, for depths along it.
    pub(crate) forward: Vec3,
    /// Where the middle of the picture is seen from.
    pub(crate) eye: Vec3,
    /// What pixels stand for.
    pub(crate) cone: Cone,
    /// Virtual lights of the sample that is taken, if the integrator has any.
    pub(crate) pass: Option<PassLights>,
    /// Centres of columns and rows, once somebody has asked.
    centres: OnceLock<[Vec<f32>; 2]>,
    /// Lamps that matter, likewise.
    lamps: OnceLock<Option<LampChoice>>,
}

/// Paths that go together, about: enough to fill lanes when most have ended, few enough for caches.
const WAVEFRONT: usize = 4096;

/// Camera rays of some samples, and memory for what becomes of them.
#[derive(Default)]
pub(crate) struct CameraBatch {
    /// Those that the rays of each sample go through.
    pixels: Vec<[u32; 2]>,
    pub(crate) rays: RayBatch,
    pub(crate) keys: Vec<SampleKey>,
    /// Where they go through the picture.
    places: Vec<[f32; 2]>,
    hits: HitBatch,
    radiance: Vec3s,
}

/// A sample of each pixel of a tile, light and surfaces apart.
pub(crate) struct Apart {
    /// Row by row.
    pub(crate) texels: Vec<Texel>,
    batch: CameraBatch,
    costs: Vec<u64>,
    stats: RenderStats,
}

impl<'a> Job<'a> {
    /// A job without deadline that has nothing done.
    pub(crate) fn new(
        world: &'a World,
        camera: &'a dyn CameraShader,
        options: &'a RenderOptions,
        progress: &'a dyn Progress,
    ) -> Self {
        let [eye, forward] = middle(camera, options);
        Self {
            world,
            camera,
            options,
            filter: Filter::new(options.filter),
            progress,
            deadline: None,
            all_samples: 1,
            samples_done: AtomicU64::new(0),
            stopped: AtomicBool::new(false),
            forward,
            eye,
            cone: Cone::of(camera, options),
            pass: None,
            centres: OnceLock::new(),
            lamps: OnceLock::new(),
        }
    }

    /// Which lamps light paths are to start at, if that is worth asking; learned once.
    pub(crate) fn lamp_choice(&self, stats: &mut RenderStats) -> Option<&LampChoice> {
        self.lamps.get_or_init(|| LampChoice::new(self, stats)).as_ref()
    }

    /// What renders one tile after another.
    pub(crate) fn tracer(&self) -> BatchTracer<'_> {
        let mut tracer = BatchTracer::new(self.world, self.options, self.options.heatmap);
        tracer.cone = self.cone;
        tracer.pass = self.pass.as_ref();
        tracer
    }

    /// Brings a tile to `last` samples, or to fewer if it is time to stop.
    pub(crate) fn render_tile(
        &self,
        tile: &mut TileFilm,
        tracer: &mut BatchTracer,
        last: u32,
    ) -> RenderStats {
        let mut pilot = RenderStats::default();
        if let Some(noise) = self.options.noise.filter(|_| tile.target == 0) {
            if self.should_stop() {
                return pilot;
            }
            tile.target = samples_needed(self, tile.rect, noise, &mut pilot);
        }
        let last = last.min(tile.wanted(last));
        tracer.costs = self.options.heatmap.then(|| TileCosts::new(tile.rect, self.options.width));
        // Samples are taken in order, so that a tile that was cut short in an earlier pass goes on where it was.
        while tile.samples < last && !self.should_stop() {
            self.render_samples(tile, tracer, last);
        }
        if let Some(costs) = tracer.costs.take() {
            tile.costs.resize(costs.costs.len(), 0);
            tile.costs.iter_mut().zip(costs.costs).for_each(|(sum, cost)| *sum += cost);
        }
        let mut stats = tracer.take_stats();
        stats.add(&pilot);
        let done = self.samples_done.fetch_add(stats.samples, Ordering::Relaxed) + stats.samples;
        self.progress.update(done as f64 / self.all_samples as f64, done);
        stats
    }

    /// Takes the next samples of all pixels of a tile, as many as go together, up to `last`.
    pub(crate) fn render_samples(&self, tile: &mut TileFilm, tracer: &mut BatchTracer, last: u32) {
        let mut batch = std::mem::take(&mut tracer.camera);
        let pixels = tile.first.len();
        let at_once = match self.options.integrator {
            Integrator::Path => (WAVEFRONT / pixels.max(1)).clamp(1, 16) as u32,
            _ => 1,
        };
        let samples = tile.samples..last.min(tile.samples.saturating_add(at_once));
        self.camera_rays(tile.pixels(), samples.clone(), &mut batch);
        let CameraBatch { rays, keys, hits, radiance, .. } = &mut batch;
        tracer.intersect_into(rays, keys, Coherence::Coherent, hits);
        let epsilon = self.options.ray_epsilon;
        let camera = HitLanes { rays, keys, hits, depth: 0, epsilon };
        integrators::radiance(self.options.integrator, tracer, camera, radiance);
        for (sample, first) in samples.zip((0..).step_by(pixels.max(1))) {
            let lanes = first..first + pixels;
            if let Some(aovs) = &mut tile.aovs {
                aovs.add(tracer, camera, lanes.clone(), sample, self.forward);
            }
            tracer.stats.bad_samples += tile.add_sample(radiance, hits, lanes);
        }
        tracer.stats.camera_rays += rays.len() as u64;
        tracer.stats.samples += rays.len() as u64;
        tracer.camera = batch;
    }

    /// A sample of each pixel of a part of the film, light and surfaces apart; nothing is added to the film.
    pub(crate) fn sample_apart(&self, tile: &TileFilm, tracer: &mut BatchTracer, sample: u32) -> Apart {
        let mut batch = CameraBatch::default();
        self.camera_rays(tile.pixels(), sample..sample + 1, &mut batch);
        tracer.costs = self.options.heatmap.then(|| TileCosts::new(tile.rect, self.options.width));
        let CameraBatch { rays, keys, hits, radiance, .. } = &mut batch;
        tracer.intersect_into(rays, keys, Coherence::Coherent, hits);
        let camera = HitLanes { rays, keys, hits, depth: 0, epsilon: self.options.ray_epsilon };
        let mut lanes = vec![Texel::default(); keys.len()];
        if let Some(pass) = tracer.pass {
            many_lights::radiance_apart(tracer, pass, camera, radiance, &mut lanes);
        }
        tracer.stats.camera_rays += keys.len() as u64;
        tracer.stats.samples += keys.len() as u64;
        let [x0, y0, x1, _] = tile.rect;
        let mut texels = lanes.clone();
        for ([x, y], texel) in tile.pixels().zip(lanes) {
            texels[((y - y0) * (x1 - x0) + (x - x0)) as usize] = texel;
        }
        let costs = tracer.costs.take().map_or_else(Vec::new, |costs| costs.costs);
        Apart { texels, batch, costs, stats: tracer.take_stats() }
    }

    /// Adds a sample that was taken apart to the film; `filter` brings its parts together.
    pub(crate) fn add_apart(
        &self,
        tile: &mut TileFilm,
        tracer: &mut BatchTracer,
        sample: u32,
        apart: &Apart,
        seen: &Seen,
    ) -> RenderStats {
        let mut radiance = Vec3s::default();
        seen.filtered(tile, &mut radiance);
        let CameraBatch { rays, keys, hits, .. } = &apart.batch;
        let camera = HitLanes { rays, keys, hits, depth: 0, epsilon: self.options.ray_epsilon };
        if let Some(aovs) = &mut tile.aovs {
            aovs.add(tracer, camera, 0..keys.len(), sample, self.forward);
        }
        tile.costs.resize(apart.costs.len(), 0);
        tile.costs.iter_mut().zip(&apart.costs).for_each(|(sum, cost)| *sum += cost);
        let bad_samples = tile.add_sample(&radiance, hits, 0..keys.len());
        let mut stats = tracer.take_stats();
        stats.add(&apart.stats);
        stats.bad_samples += bad_samples;
        let done = self.samples_done.fetch_add(stats.samples, Ordering::Relaxed) + stats.samples;
        self.progress.update(done as f64 / self.all_samples as f64, done);
        stats
    }

    /// One ray through each pixel for each sample, at its centre or placed by the filter; sample by sample.
    pub(crate) fn camera_rays(
        &self,
        pixels: impl Iterator<Item = [u32; 2]>,
        samples: Range<u32>,
        batch: &mut CameraBatch,
    ) {
        let (width, height) = (self.options.width, self.options.height);
        let CameraBatch { pixels: all, rays, keys, places, .. } = batch;
        rays.clear();
        keys.clear();
        places.clear();
        all.clear();
        // Loops within loops are loops only from inside.
        pixels.for_each(|pixel| all.push(pixel));
        for sample in samples {
            keys.extend(all.iter().map(|[x, y]| SampleKey { pixel: y * width + x, sample, branch: 0 }));
        }
        if self.options.pixel_centres {
            let [columns, rows] = self.centres.get_or_init(|| centres(width, height));
            let centre = |&[x, y]: &[u32; 2]| [columns[x as usize], rows[y as usize]];
            while places.len() < keys.len() {
                places.extend(all.iter().map(centre));
            }
        } else {
            let (seed, level) = (self.options.seed, self.options.level);
            dispatch_wide!(
                level,
                simd => sample_pairs(simd, seed, keys, 0, purpose::PIXEL, places),
                else places.extend(keys.iter().map(|&key| sample_pair(seed, key, 0, purpose::PIXEL)))
            );
            for (place, &[x, y]) in places.iter_mut().zip(all.iter().cycle()) {
                let [dx, dy] = self.filter.sample(*place).map(f64::from);
                let across = (f64::from(x) + 0.5 + dx) / f64::from(width);
                let up = 1.0 - (f64::from(y) + 0.5 + dy) / f64::from(height);
                *place = [across as f32, up as f32];
            }
        }
        self.camera.rays(places, width as f32 / height as f32, rays);
        // A camera that gives too few rays leaves the rest dark: a ray without direction hits nothing.
        while rays.len() < keys.len() {
            rays.push(Ray::new([0.0; 3], [0.0; 3]));
        }
    }

    /// Whether to finish now; once yes, always yes.
    pub(crate) fn should_stop(&self) -> bool {
        let stop = self.stopped.load(Ordering::Relaxed)
            || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
            || self.progress.should_stop();
        if stop {
            self.stopped.store(true, Ordering::Relaxed);
        }
        stop
    }
}

/// Where the centres of columns and rows lie across the picture and up.
fn centres(width: u32, height: u32) -> [Vec<f32>; 2] {
    let across = |x| ((f64::from(x) + 0.5) / f64::from(width)) as f32;
    let up = |y| (1.0 - (f64::from(y) + 0.5) / f64::from(height)) as f32;
    [(0..width).map(across).collect(), (0..height).map(up).collect()]
}

/// Where the middle of the picture is seen from, and its unit direction.
fn middle(camera: &dyn CameraShader, options: &RenderOptions) -> [Vec3; 2] {
    let mut rays = RayBatch::default();
    camera.rays(&[[0.5, 0.5]], options.width as f32 / options.height as f32, &mut rays);
    if rays.is_empty() {
        return [Vec3::ZERO, Vec3::NEG_Z];
    }
    let ray = rays.get(0);
    [ray.org, ray.dir].map(Vec3::from)
}
