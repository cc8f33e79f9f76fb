// SPDX-License-Identifier: GPL-3.0-or-later
//! A picture of a camera in motion, and the state for the next one.
//! Source: see `motion/mod.rs`. Space: world.
//! Invariant: a function of the previous pictures and their options, on any number of threads. Tests:
//! crates/render/tests/motion.rs.

use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;
use gnurt_accel::threads::{self, Pieces};
use gnurt_image::srgb::luminance;
use gnurt_shading::CameraShader;
use gnurt_simd::Level;

use super::before::Before;
use super::choose::scale;
use super::frame::{Frame, Spare};
use super::lattice::Lattice;
use super::noise::{Noise, Sample};
use super::smooth::{Given, Smooth, Strength, is_shiny};
use super::surface_key::{SurfaceKey, Tint};
use super::whole::{Traced, Whole};
use crate::film::TileFilm;
use crate::job::Job;
use crate::many_lights::{PersistentLights, alike};
use crate::options::RenderOptions;
use crate::stats::RenderStats;
use crate::world::{World, WorldMark};

/// Fraction of them that is kept per frame while the world changes, and the number of frames of this after a
/// change.
const CHANGING: f32 = 0.7;
const UNREST: u32 = 8;
/// Fresh samples of a first picture, relative to later ones: nothing else is known, and its noise is seen at once.
const FIRST: f32 = 6.0;
/// Pictures of a quarter of the pixels that a first picture consists of.
const QUARTERS: u32 = 4;

/// State that pictures of a camera in motion leave to the next one: light on visible surfaces, and virtual
/// lights; see [`Accumulation::pass_remembering`](crate::Accumulation::pass_remembering).
#[derive(Default)]
pub struct PictureHistory {
    pub(crate) lights: PersistentLights,
    of: Option<(WorldMark, RenderOptions)>,
    before: Option<Before>,
    /// Pictures so far: each has its own random numbers.
    frame: u32,
    /// Frames during which the history fades.
    unrest: u32,
    /// Light on the mean pixel; 0 = unknown.
    mean: f32,
    noise: Noise,
    tints: Vec<Tint>,
    /// Light as it is shown.
    shown: Smooth,
    /// All pixels, where one in four is traced.
    whole: Whole,
    spare: Spare,
    cost: MotionCost,
}

/// Pixels of a picture in motion that are traced and sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionShare {
    /// Share of the traced pixels that get a fresh sample of light, in (0, 1].
    pub fresh: f32,
    /// 1: all pixels are traced. 2: one of each cell of two by two, another one in each frame; the others
    /// show the same surface as in earlier pictures. Greater values count as 2.
    pub stride: u32,
}

/// Cost of the last picture in motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionCost {
    /// Fresh samples of light.
    pub samples: u64,
    /// Seconds that these took.
    pub sampling_seconds: f64,
    /// Pixels whose surface was traced.
    pub traced: u64,
    /// Seconds that these took, and the filter over their light; virtual lights included.
    pub tracing_seconds: f64,
    /// Seconds that the colours of all pixels took.
    pub showing_seconds: f64,
}

impl PictureHistory {
    /// Whether pictures in motion by this integrator and this camera reuse earlier ones: the integrator
    /// samples light at random, and the camera can project points. Other ones take one sample of each pixel.
    #[must_use]
    pub fn suits(world: &World, camera: &dyn CameraShader, options: &RenderOptions) -> bool {
        let by_chance = options.integrator.needs_light_set();
        let is_plain = !options.aovs
            && !options.heatmap
            && options.crop.is_none()
            && options.piece.is_none()
            && options.rows.is_none();
        by_chance && is_plain && world.pixel().is_none() && !world.is_open() && {
            let [eye, forward] = crate::job::middle(camera, options);
            camera.project(eye + forward, options.width as f32 / options.height as f32).is_some()
        }
    }

    /// Cost of the last picture.
    #[must_use]
    pub fn cost(&self) -> MotionCost {
        self.cost
    }

    /// Makes the next picture and writes it to `tiles`; returns false if it was stopped.
    pub(crate) fn next(
        &mut self,
        job: &Job,
        camera: &Arc<dyn CameraShader>,
        share: MotionShare,
        (tiles, stats): (&mut [TileFilm], &mut RenderStats),
        pool: &rayon::ThreadPool,
    ) -> bool {
        self.follow(job);
        let is_first = self.before.is_none();
        // All pixels of the first picture are traced: nothing else shows what is between them.
        let times = if is_first && share.stride > 1 { QUARTERS } else { 1 };
        let fresh = if is_first { FIRST * share.fresh } else { share.fresh };
        (0..times).all(|_| self.make(job, camera, MotionShare { fresh, ..share }, (tiles, stats), pool))
    }

    /// Makes a picture of the world and the options that are followed.
    fn make(
        &mut self,
        job: &Job,
        camera: &Arc<dyn CameraShader>,
        share: MotionShare,
        (tiles, stats): (&mut [TileFilm], &mut RenderStats),
        pool: &rayon::ThreadPool,
    ) -> bool {
        let begin = Instant::now();
        let lattice = Lattice::new([job.options.width, job.options.height], share.stride, self.frame);
        if lattice.stride > 1 && !self.whole.is_of(lattice.full) {
            self.begin_whole(lattice.full, pool);
        }
        let mut frame = Frame::new(lattice, std::mem::take(&mut self.spare));
        let fading = self.fading();
        let Self { lights, before, tints, .. } = self;
        // Few paths bring virtual lights: they would not be work for all threads.
        let (counts, pass) = pool.install(|| {
            threads::both(
                true,
                || frame.sample_surfaces(job, before.as_ref(), tints, fading, stats),
                || lights.next_few(job),
            )
        });
        let pass = pass.map(|(pass, of_lights)| {
            stats.add(&of_lights);
            pass
        });
        let looked = Instant::now();
        let [width, height] = lattice.size();
        let requested = f64::from(share.fresh.clamp(0.0, 1.0)) * f64::from(width) * f64::from(height);
        let scale = scale(counts, requested);
        let chosen = pool.install(|| frame.choose(scale, self.frame));
        let sampled = pool.install(|| {
            let cut = [self.mean, Strength::of(self.noise.of_whole()).most_of_one()];
            frame.sample(job, pass.as_deref(), (&chosen, self.frame), &self.tints, cut, stats)
        });
        let Some(brightness) = sampled else {
            // The previous picture stays the previous one, but for its tints.
            self.tints.clear();
            self.spare = frame.into();
            return false;
        };
        let sampled = Instant::now();
        pool.install(|| {
            let level = job.options.level;
            let Frame { surface_keys, lights, .. } = &frame;
            let [width, height] = [width, height].map(|n| n as usize);
            loop {
                let given = Given { width, surface_keys, tints: &self.tints, lights, noise: &self.noise };
                self.shown.smooth(&given, Strength::of([self.noise.most(), self.noise.of_whole()[1]]), level);
                self.mean = mean_of(surface_keys, &self.shown, width);
                let sample = |(&[x, y], &brightness): (&[u32; 2], &f32)| {
                    let at = [x, y].map(|n| n as usize);
                    let is_shiny = is_shiny(&self.tints[at[1] * width + at[0]]);
                    let known = luminance(self.shown.light(at[0], at[1]).mean.into());
                    Sample { at, is_shiny, brightness, known }
                };
                let samples = chosen.iter().zip(&brightness).map(sample);
                // The noise of the first picture was unknown.
                if !self.noise.add([width, height], samples, self.mean) {
                    break;
                }
            }
        });
        let filtered = Instant::now();
        pool.install(|| self.show(tiles, &frame, (&**camera, job.eye), job.options.level));
        let Frame { surface_keys, lights, origins, .. } = frame;
        let next = Before { camera: camera.clone(), eye: job.eye, lattice, surface_keys, lights };
        if let Some(old) = self.before.replace(next) {
            self.spare = Spare { surface_keys: old.surface_keys, lights: old.lights, origins };
        }
        self.frame = self.frame.wrapping_add(1);
        self.unrest = self.unrest.saturating_sub(1);
        self.cost = MotionCost {
            samples: chosen.len() as u64,
            sampling_seconds: (sampled - looked).as_secs_f64(),
            traced: u64::from(width) * u64::from(height),
            tracing_seconds: (looked - begin + (filtered - sampled)).as_secs_f64(),
            showing_seconds: filtered.elapsed().as_secs_f64(),
        };
        true
    }

    /// Drops the history that other options or another world have invalidated.
    fn follow(&mut self, job: &Job) {
        match &self.of {
            Some((_, of)) if !alike(of, job.options) => {
                *self = Self::default();
            }
            Some((mark, _)) if !mark.is_of(job.world) => self.unrest = UNREST,
            Some(_) => return,
            None => {}
        }
        self.of = Some((job.world.mark(), job.options.clone()));
    }

    /// The fraction of the history that this frame keeps.
    fn fading(&self) -> f32 {
        if self.unrest > 0 { CHANGING } else { 1.0 }
    }

    /// Starts from the previous picture, if all of its pixels were traced.
    fn begin_whole(&mut self, full: [u32; 2], pool: &rayon::ThreadPool) {
        let Self { before, tints, shown, whole, .. } = self;
        let is_whole = |before: &&Before| before.lattice == Lattice::new(full, 1, 0);
        match before.as_ref().filter(is_whole) {
            Some(before) if before.surface_keys.len() == tints.len() => {
                pool.install(|| whole.take(full, &before.surface_keys, tints, shown));
            }
            _ => whole.forget(),
        }
    }

    /// Writes colours to the film.
    fn show(
        &mut self,
        tiles: &mut [TileFilm],
        frame: &Frame,
        (camera, eye): (&dyn CameraShader, Vec3),
        level: Level,
    ) {
        let unknown = Vec3::splat(self.mean);
        if frame.lattice.stride == 1 {
            self.whole.forget();
            let width = frame.lattice.full[0];
            write(tiles, |[x, y]| {
                let (tint, light) =
                    (&self.tints[(y * width + x) as usize], self.shown.light(x as usize, y as usize));
                let mean = if light.count > 0.0 { light.mean } else { unknown };
                let [r, g, b] = (tint.plain + tint.share * mean).to_array();
                [r, g, b, tint.opacity]
            });
            return;
        }
        let Frame { lattice, surface_keys, origins, .. } = frame;
        let (tints, shown) = (&self.tints, &self.shown);
        let lattice = *lattice;
        let traced = Traced { lattice, surface_keys, tints, shown, unknown, origins, camera, eye };
        self.whole.next(&traced, tiles, level);
    }
}

/// Gives the pixels of the film their colours.
fn write(tiles: &mut [TileFilm], color: impl Fn([u32; 2]) -> [f32; 4] + Sync) {
    let tiles = Pieces::new(tiles, 1);
    threads::for_each(true, tiles.count(), &|n| tiles.lock(n)[0].show(&color));
}

/// Luminance of light on the mean pixel that shows a surface.
fn mean_of(surface_keys: &[SurfaceKey], shown: &Smooth, width: usize) -> f32 {
    let of_row = |y: usize| {
        let surface_keys = &surface_keys[y * width..][..width];
        let surfaces = (0..width).filter(|&x| surface_keys[x].is_surface()).map(|x| shown.light(x, y));
        let known = surfaces.filter(|light| light.count > 0.0);
        known.fold((0.0, 0.0), |(sum, count), light| (sum + luminance(light.mean.into()), count + 1.0))
    };
    let rows: Vec<(f32, f32)> = threads::map(true, surface_keys.len() / width.max(1), of_row);
    let total = |k: fn(&(f32, f32)) -> f32| rows.iter().map(|row| f64::from(k(row))).sum::<f64>();
    (total(|row| row.0) / f64::max(total(|row| row.1), 1.0)) as f32
}
