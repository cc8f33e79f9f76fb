// SPDX-License-Identifier: GPL-3.0-or-later
//! A progressive picture: passes add samples until the caller stops. A stopped pass leaves tiles with
//! different numbers of samples; the next pass first evens them out. Memory: sums of all pixels, independent
//! of the number of samples.
//! Invariant: sample `s` of a pixel is the same in any pass, and sums are added in the order of the samples:
//! after `n` samples the picture equals that of `render` with `spp = n`, bit for bit.
//! Tests: crates/render/tests/accumulation.rs.

use std::sync::Arc;
use std::time::Instant;

use gnurt_accel::threads::{self, Pieces};
use gnurt_image::{Picture, heat_map};
use gnurt_shading::{CameraShader, OutputKind};

use crate::bands::{ColorBand, FilmBand};
use crate::caustics_training;
use crate::error::RenderError;
use crate::film::{self, TileFilm};
use crate::frame::Frame;
use crate::guide::Guide;
use crate::guide_training::{self, Trained};
use crate::integrator_choice::{self, Chosen};
use crate::job::Job;
use crate::layers;
use crate::many_lights::interleave::PatternTexels;
use crate::many_lights::{self, Common, PersistentLights};
use crate::mattes;
use crate::motion::{MotionShare, PictureHistory};
use crate::options::{Integrator, RenderOptions};
use crate::pixel_grid::PixelGrid;
use crate::progress::Watch;
use crate::sampler::{Sampler, SplitLight};
use crate::shader_outputs;
use crate::stats::RenderStats;
use crate::tile::render_tile;
use crate::tracer::BatchTracer;
use crate::transport::manifold::Caustics;
use crate::world::World;

/// Receives the progress of a picture, and may stop it. Called from many threads at once.
pub trait Progress: Sync {
    /// `done` in [0, 1] of all work, `samples` of the whole picture so far. Called after each tile.
    fn update(&self, done: f64, samples: u64) {
        let _ = (done, samples);
    }

    /// Called by one thread between passes, with the picture so far.
    fn passed(&self, picture: &Accumulation) {
        let _ = picture;
    }

    /// Whether to finish now and keep the picture so far. Called between tiles and within them, many times a
    /// second.
    fn should_stop(&self) -> bool {
        false
    }
}

/// Ignores progress and never stops.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {}

/// The renderer's view of a caller's progress.
struct Watched<'a>(&'a dyn Progress);

impl Watch for Watched<'_> {
    fn update(&self, done: f64, samples: u64) {
        self.0.update(done, samples);
    }

    fn should_stop(&self) -> bool {
        self.0.should_stop()
    }
}

/// Samples taken so far of a picture of one world and one camera.
///
/// World and camera are not held but given to each pass, so that the caller may keep them wherever it likes; it gives
/// the same ones until it calls [`restart`](Self::restart).
///
/// ```
/// # use gnurt_render::{Accumulation, CommitOptions, SceneCamera, RenderOptions, ShaderTable, Silent, World};
/// # let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
/// # let scene = gnurt_scene::Scene::new();
/// # let mut world = World::new();
/// # world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool).expect("nothing is missing");
/// # let camera = gnurt_scene::Camera { name: String::new(), eye: [0.0; 3], target: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], fov_y: 40.0, ..gnurt_scene::Camera::default() };
/// # let camera = SceneCamera::new(&camera).expect("a view");
/// let options = RenderOptions { width: 64, height: 48, spp: 8, ..RenderOptions::default() };
/// let mut visible = Accumulation::new(options).expect("sound options");
/// while !visible.is_complete() {
///     visible.pass(&world, &camera, 1, &pool, &Silent);
///     let picture = visible.picture(); // show it
/// #   assert_eq!(picture.pixel_count(), 64 * 48);
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Accumulation {
    pub(crate) options: RenderOptions,
    /// The rendered part of the frame in pixels: `[x0, y0, x1, y1]`.
    pub(crate) region: [u32; 4],
    pub(crate) tiles: Vec<TileFilm>,
    pub(crate) stats: RenderStats,
    /// The form of each layer of light, as the last pass had it.
    kinds: Vec<OutputKind>,
    /// State of virtual lights that all passes share.
    common: Arc<Common>,
    /// The integrator, once it was chosen.
    chosen: Option<Arc<Chosen>>,
    /// The guide, once samples need it.
    trained: Option<Arc<Trained>>,
    /// Smooth surfaces and lamps of searches, once they were found.
    caustics: Option<Option<Arc<Caustics>>>,
    /// When the whole rendering has to end.
    pub(crate) limit: Option<Instant>,
}

impl Accumulation {
    /// A picture without samples. `options.spp` samples complete it; `options.time_limit` is ignored.
    ///
    /// # Errors
    /// [`RenderError`] if the options leave nothing to render.
    pub fn new(options: RenderOptions) -> Result<Self, RenderError> {
        let region = options.region()?;
        let tiles = TileFilm::cover(region, &options);
        Ok(Self {
            options,
            region,
            tiles,
            stats: RenderStats::default(),
            kinds: Vec::new(),
            common: Arc::default(),
            chosen: None,
            trained: None,
            caustics: None,
            limit: None,
        })
    }

    /// Drops all samples: for another world, another camera or other options. Memory is used again where the
    /// size stays, so that this may happen for every frame of an animation.
    ///
    /// # Errors
    /// As [`new`](Self::new); nothing has changed then.
    pub fn restart(&mut self, options: RenderOptions) -> Result<(), RenderError> {
        let region = options.region()?;
        if region == self.region
            && (options.aovs, options.seen) == (self.options.aovs, self.options.seen)
            && options.heatmap == self.options.heatmap
            && film::tile_size(&options) == film::tile_size(&self.options)
            && options.piece == self.options.piece
            && options.rows == self.options.rows
            && options.light_layers == self.options.light_layers
            && options.mattes == self.options.mattes
        {
            self.tiles.iter_mut().for_each(TileFilm::clear);
        } else {
            self.tiles = TileFilm::cover(region, &options);
        }
        (self.options, self.region, self.stats) = (options, region, RenderStats::default());
        self.common = Arc::default();
        (self.chosen, self.trained, self.caustics) = (None, None, None);
        Ok(())
    }

    /// Brings every pixel to `samples` more than the one with the fewest has, at most to `options.spp`; fewer
    /// if `progress` stops it. Returns whether it reached that.
    pub fn pass(
        &mut self,
        world: &World,
        camera: &dyn CameraShader,
        samples: u32,
        pool: &rayon::ThreadPool,
        progress: &dyn Progress,
    ) -> bool {
        self.pass_with(None, None, world, camera, samples, pool, progress)
    }

    /// As [`pass`](Self::pass) with one sample, for a picture that will soon be followed by one from elsewhere: virtual
    /// lights, if the integrator has any, are those of the pictures before and a few fresh ones. Not the sample that
    /// `render` takes, but like it one with the right mean.
    pub fn pass_in_motion(
        &mut self,
        persistent: &mut PersistentLights,
        world: &World,
        camera: &dyn CameraShader,
        pool: &rayon::ThreadPool,
        progress: &dyn Progress,
    ) -> bool {
        self.pass_with(Some(persistent), None, world, camera, 1, pool, progress)
    }

    /// As [`pass_in_motion`](Self::pass_in_motion). Where [`PictureHistory::suits`] is true, the picture
    /// reuses the light of the previous pictures, and traces and samples a share of the pixels. Its mean is
    /// right, but it is smoothed, and fireflies are clamped.
    pub fn pass_remembering(
        &mut self,
        persistent: &mut PictureHistory,
        share: MotionShare,
        world: &World,
        camera: &Arc<dyn CameraShader>,
        pool: &rayon::ThreadPool,
        progress: &dyn Progress,
    ) -> bool {
        if !PictureHistory::suits(world, &**camera, &self.options) {
            return self.pass_in_motion(&mut persistent.lights, world, &**camera, pool, progress);
        }
        self.kinds = shader_outputs::kinds(world, &self.options.light_layers);
        if self.is_complete() {
            return true;
        }
        let begin = Instant::now();
        let (options, watched) = (Chosen::of(None, &self.options), Watched(progress));
        if options.integrator.needs_light_set() {
            world.lights().make_set(pool);
        }
        let job = Job::new(world, &**camera, &options, &watched);
        let whole = persistent.next(&job, camera, share, (&mut self.tiles, &mut self.stats), pool);
        self.note_pass(begin, pool);
        progress.passed(self);
        whole
    }

    /// Chooses the integrator, unless that is done. Returns false if it was told to stop.
    fn choose(
        &mut self,
        world: &World,
        camera: &dyn CameraShader,
        watch: &dyn Watch,
        pool: &rayon::ThreadPool,
    ) -> bool {
        if self.options.integrator == Integrator::Auto && self.chosen.is_none() {
            let until = (watch, self.limit);
            let caustics = self.caustics.as_ref().and_then(Option::as_ref);
            let setup = (&self.options, caustics);
            let Some(chosen) = integrator_choice::choose(world, camera, setup, until, pool) else {
                return false;
            };
            self.stats.add(&chosen.cost);
            self.stats.choice = Some(chosen.stats);
            self.chosen = Some(Arc::new(chosen));
        }
        true
    }

    /// Finds smooth surfaces and lamps, and learns where searches pay, unless that is done. Returns false if it was told to stop.
    fn learn_caustics(
        &mut self,
        world: &World,
        camera: &dyn CameraShader,
        watch: &dyn Watch,
        pool: &rayon::ThreadPool,
    ) -> bool {
        if self.caustics.is_none() {
            let (options, until) = (Chosen::of(None, &self.options), (watch, self.limit));
            let Some(learned) = caustics_training::learn(world, camera, &options, until, pool) else {
                return false;
            };
            self.stats.add(&learned.cost);
            self.caustics = Some(learned.caustics);
        }
        true
    }

    /// Learns a guide, unless that is done. Returns false if it was told to stop.
    fn train(
        &mut self,
        world: &World,
        camera: &dyn CameraShader,
        options: &RenderOptions,
        watch: &dyn Watch,
        pool: &rayon::ThreadPool,
    ) -> bool {
        if self.trained.is_none() {
            let until = (watch, self.limit);
            let setup = (options, self.caustics.clone().flatten());
            let Some(trained) = guide_training::train(world, camera, setup, until, pool) else {
                return false;
            };
            self.stats.add(&trained.cost);
            self.stats.guide = Some(trained.stats);
            self.trained = Some(Arc::new(trained));
        }
        true
    }

    /// Updates the statistics after a pass.
    fn note_pass(&mut self, begin: Instant, pool: &rayon::ThreadPool) {
        self.stats.spp_min = self.tiles.iter().map(|tile| tile.samples).min().unwrap_or(0);
        self.stats.spp_max = self.tiles.iter().map(|tile| tile.samples).max().unwrap_or(0);
        self.stats.complete = self.is_complete();
        self.stats.threads = pool.current_num_threads();
        self.stats.seconds += begin.elapsed().as_secs_f64();
    }

    /// As [`pass`](Self::pass), but with persistent virtual lights, and with a time limit.
    #[expect(clippy::too_many_arguments, reason = "what all passes have in common")]
    pub(crate) fn pass_with(
        &mut self,
        mut persistent: Option<&mut PersistentLights>,
        deadline: Option<Instant>,
        world: &World,
        camera: &dyn CameraShader,
        samples: u32,
        pool: &rayon::ThreadPool,
        progress: &dyn Progress,
    ) -> bool {
        let begin = Instant::now();
        self.kinds = shader_outputs::kinds(world, &self.options.light_layers);
        let done_before = self.samples();
        let last = done_before.saturating_add(samples).min(self.options.spp);
        let pixels: u64 = self.tiles.iter().map(|tile| tile.first.len() as u64).sum();
        let watched = Watched(progress);
        let seed = self.options.seed;
        if self.options.integrator.needs_light_set() {
            world.lights().make_set(pool);
        }
        // Each ray has its own time, or with moving lights each sample has one.
        let opened = world.needs_times().then(|| world.with_times(seed));
        let at_rest = opened.as_ref().unwrap_or(world);
        let begins = done_before < last && pixels > 0;
        // Pictures in motion have no time for pilots.
        let waits = begins
            && persistent.is_none()
            && !(self.learn_caustics(at_rest, camera, &watched, pool)
                && self.choose(at_rest, camera, &watched, pool));
        let options = Chosen::of(self.chosen.as_deref(), &self.options);
        let guided_from = options.guided_from().filter(|&from| from < last && pixels > 0);
        let waits =
            waits || (guided_from.is_some() && !self.train(at_rest, camera, &options, &watched, pool));
        if waits {
            self.note_pass(begin, pool);
            progress.passed(self);
            return false;
        }
        let has_virtual_lights = options.integrator.has_virtual_lights();
        let is_of_pass = world.needs_times() && (has_virtual_lights || world.lights_move());
        let world = at_rest;
        let trained = self.trained.clone();
        let guide = trained.as_ref().and_then(|trained| trained.guide.as_ref()).zip(guided_from);
        let all_samples = pixels * u64::from(self.options.spp);
        let pass_setup =
            PassSetup { camera, options: &options, watch: &watched, deadline, all_samples, guide };
        let mut shared = pass_setup.job(world, self.stats.samples);
        shared.common = self.common.clone();
        let find = || caustics_training::find(&shared).map(Arc::new);
        shared.caustics = self.caustics.get_or_insert_with(find).clone();
        // Virtual lights are one sample's.
        let at_once = if has_virtual_lights || is_of_pass { 1 } else { u32::MAX };
        let mut done = done_before;
        while done < last && !shared.should_stop() {
            let of_pass = is_of_pass.then(|| world.of_pass(self.options.seed_of_lights(), done, pool));
            let own = of_pass.as_ref().map(|world| {
                if options.integrator.needs_light_set() {
                    world.lights().make_set(pool);
                }
                let mut job = pass_setup.job(world, self.stats.samples);
                // Lamps are elsewhere.
                job.caustics = shared.caustics.as_ref().and_then(|at_rest| {
                    let found = caustics_training::find(&job)?;
                    Some(Arc::new(found.with_places(at_rest.places().cloned())))
                });
                job
            });
            let job = own.as_ref().unwrap_or(&shared);
            done = done.saturating_add(at_once).min(last);
            let pass = pool.install(|| match &mut persistent {
                Some(persistent) => persistent.next(job),
                None => many_lights::pass_lights(job, done - 1),
            });
            if let Some(pass) = &pass {
                self.stats.add(&pass.stats);
            }
            let sampler = Sampler { job, pass: pass.as_ref() };
            let of_tiles: Vec<RenderStats> = if let Some(n) = options.pattern() {
                let Some(of_tiles) =
                    add_interleaved(&sampler, &mut self.tiles, self.region, done - 1, n, pool)
                else {
                    break;
                };
                of_tiles
            } else {
                let tiles = Pieces::new(&mut self.tiles, 1);
                let render = |tracer: &mut BatchTracer, n: usize| {
                    render_tile(&sampler, &mut tiles.lock(n)[0], tracer, done)
                };
                pool.install(|| threads::map_with(true, tiles.count(), || sampler.tracer(), render))
            };
            of_tiles.iter().for_each(|tile| self.stats.add(tile));
        }
        self.note_pass(begin, pool);
        progress.passed(self);
        self.samples() >= last
    }

    /// Fewest samples that a pixel has which shall get more; all samples if none shall.
    #[must_use]
    pub fn samples(&self) -> u32 {
        let spp = self.options.spp;
        let lacking = self.tiles.iter().filter(|tile| tile.samples < tile.requested(spp));
        lacking.map(|tile| tile.samples).min().unwrap_or(spp)
    }

    /// Whether every pixel has all requested samples.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.tiles.iter().all(|tile| tile.samples >= tile.requested(self.options.spp))
    }

    /// The options of the rendering.
    #[must_use]
    pub fn options(&self) -> &RenderOptions {
        &self.options
    }

    /// Counters over all passes since the last restart; `seconds` is the time within passes.
    #[must_use]
    pub fn stats(&self) -> &RenderStats {
        &self.stats
    }

    /// The mean of the samples so far, with the layers of the options; black and transparent where there is none.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let (mut picture, grid) = (self.colors(), PixelGrid::of(&self.options));
        if self.options.aovs {
            layers::add_layers(&mut picture, &self.tiles, grid, self.options.seen);
        }
        mattes::add_mattes(&mut picture, &self.tiles, grid, &self.options.mattes);
        layers::add_light(&mut picture, &self.tiles, grid, &self.options.light_layers, &self.kinds);
        picture
    }

    /// As [`picture`](Self::picture), without layers.
    #[must_use]
    pub fn colors(&self) -> Picture {
        let grid = PixelGrid::of(&self.options);
        let mut picture = Picture::new(grid.width, grid.height);
        for tile in &self.tiles {
            for (i, pixel) in tile.pixels().enumerate() {
                picture.color[grid.at(pixel)] = tile.mean(i);
            }
        }
        picture
    }

    /// Writes the colours of [`picture`](Self::picture) into memory of the caller, row by row from the upper left
    /// pixel, on the threads of `pool`. Pixels outside of the region, and those beyond the end of `out`, stay as they are.
    pub fn write_colors(&self, out: &mut [[f32; 4]], pool: &rayon::ThreadPool) {
        let mut bands: Vec<Option<ColorBand>> = self.color_bands(out).into_iter().map(Some).collect();
        let bands = Pieces::new(&mut bands, 1);
        let write = |n: usize| {
            bands.lock(n)[0].take().map(ColorBand::write);
        };
        pool.install(|| threads::for_each(true, bands.count(), &write));
    }

    /// The same in bands, from top to bottom, so that the caller can process each band while it is in the
    /// cache.
    #[must_use]
    pub fn color_bands<'a>(&'a self, out: &'a mut [[f32; 4]]) -> Vec<ColorBand<'a>> {
        let width = self.options.width as usize;
        let [_, y0, _, y1] = self.region;
        let rows_end = (y1 as usize * width).min(out.len());
        let mut rest = &mut out[(y0 as usize * width).min(rows_end)..rows_end];
        let bands = FilmBand::all_of(&self.tiles);
        let mut row = y0;
        bands
            .map(|film| {
                // Rows of other pieces are left out.
                let skipped = ((film.rows().start - row) as usize * width).min(rest.len());
                let length = (film.rows().len() * width).min(rest.len() - skipped);
                let (colors, below) = std::mem::take(&mut rest)[skipped..].split_at_mut(length);
                (rest, row) = (below, film.rows().end);
                ColorBand::new(film, colors, width)
            })
            .collect()
    }

    /// The same without conversion to colours.
    #[must_use]
    pub fn film_bands(&self) -> Vec<FilmBand<'_>> {
        FilmBand::all_of(&self.tiles).collect()
    }

    /// The cost of each pixel per sample in false colours, if requested.
    #[must_use]
    pub fn heatmap(&self) -> Option<Picture> {
        self.options.heatmap.then(|| {
            let grid = PixelGrid::of(&self.options);
            let mut costs = vec![0.0; grid.count()];
            for tile in &self.tiles {
                let per_sample = 1.0 / f64::from(tile.samples.max(1));
                let [x0, y0, x1, y1] = tile.rect;
                let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| [x, y]));
                for (pixel, &cost) in pixels.zip(&tile.costs) {
                    costs[grid.at(pixel)] = (cost as f64 * per_sample) as f32;
                }
            }
            heat_map(grid.width, grid.height, &costs)
        })
    }

    /// The picture as it is, with its counters and the time since `start`.
    pub(crate) fn into_frame(self, start: Instant) -> Frame {
        let (picture, heatmap) = (self.picture(), self.heatmap());
        // No work remains for a film that was complete or has no pixels.
        let (complete, seconds) = (self.is_complete(), start.elapsed().as_secs_f64());
        Frame { picture, heatmap, stats: RenderStats { complete, seconds, ..self.stats } }
    }
}

/// Setup that the jobs of all passes share.
#[derive(Clone, Copy)]
struct PassSetup<'a> {
    camera: &'a dyn CameraShader,
    options: &'a RenderOptions,
    watch: &'a dyn Watch,
    deadline: Option<Instant>,
    all_samples: u64,
    guide: Option<(&'a Guide, u32)>,
}

impl<'a> PassSetup<'a> {
    /// The job in a world, after this number of samples.
    fn job<'j>(self, world: &'j World, samples_done: u64) -> Job<'j>
    where
        'a: 'j,
    {
        let mut job = Job::new(world, self.camera, self.options, self.watch);
        (job.deadline, job.all_samples, job.guide) = (self.deadline, self.all_samples, self.guide);
        *job.samples_done.get_mut() = samples_done;
        job
    }
}

/// Adds sample `sample` to all tiles, which is averaged over neighbours; to none, and `None`, if it is time to stop.
fn add_interleaved(
    sampler: &Sampler,
    tiles: &mut [TileFilm],
    region: [u32; 4],
    sample: u32,
    n: u32,
    pool: &rayon::ThreadPool,
) -> Option<Vec<RenderStats>> {
    let take = |tracer: &mut BatchTracer, n: usize| {
        (!sampler.job.should_stop()).then(|| sampler.split_sample(&tiles[n], tracer, sample))
    };
    let taken = pool.install(|| threads::map_with(true, tiles.len(), || sampler.tracer(), take));
    let taken: Vec<SplitLight> = taken.into_iter().collect::<Option<_>>()?;
    let rects: Vec<[u32; 4]> = tiles.iter().map(|tile| tile.rect).collect();
    let visible = rects.iter().zip(taken.iter().map(|split| split.texels.as_slice()));
    let visible = PatternTexels::new(visible, region, film::tile_size(sampler.job.options), n);
    let tiles = Pieces::new(tiles, 1);
    let add = |tracer: &mut BatchTracer, n: usize| {
        sampler.add_split(&mut tiles.lock(n)[0], tracer, sample, &taken[n], &visible)
    };
    Some(pool.install(|| threads::map_with(true, tiles.count(), || sampler.tracer(), add)))
}
