// SPDX-License-Identifier: GPL-3.0-or-later
//! A picture that grows from frame to frame as long as nothing of it changes.
//! Paths come from the renderer's accumulation; `ao` and `debug` take one sample after the other here. The channels beside the colour are
//! those of the pixels' middles and are computed once. Tests: tests/{frames,channels,renderers}.rs.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;
use gnurt::ThreadPool;
use gnurt::denoise;
use gnurt::render::{Accumulation, Integrator, Progress, RenderOptions, World};
use gnurt::shading::sampling::{purpose, sample_pair};
use gnurt::shading::{CameraSamples, CameraShader, SampleKey};
use rayon::prelude::*;

use crate::attribute::Color;
use crate::camera::View;
use crate::first_hit::{FirstHit, first_hit, walk};
use crate::output::{Formats, Output};
use crate::pixel::{Layers, Opacities};
use crate::settings::{Method, Settings};
use crate::world::Stage;

/// All that a picture shows.
pub(crate) struct Job {
    pub(crate) stage: Arc<Stage>,
    pub(crate) view: Arc<View>,
    pub(crate) settings: Arc<Settings>,
    pub(crate) size: [u32; 2],
    pub(crate) formats: Formats,
    /// Changes with any of these but the formats.
    pub(crate) key: [u64; 5],
    pub(crate) accumulates: bool,
}

/// Sums of samples.
enum Sums {
    Paths {
        accumulation: Box<Accumulation>,
        opacities: Arc<Opacities>,
    },
    /// Associated, from the uppermost row on.
    Own(Vec<Color>),
}

/// State that stays from frame to frame.
pub(crate) struct Growing {
    key: [u64; 5],
    sums: Sums,
    world: World,
    first_hits: Option<Vec<FirstHit>>,
    samples: u32,
}

/// Stops where the program says so.
struct Stop<'a>(&'a AtomicBool);

impl Progress for Stop<'_> {
    fn should_stop(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl Job {
    fn aspect(&self) -> f32 {
        self.size[0] as f32 / self.size[1] as f32
    }

    fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    fn begin(&self, pool: &ThreadPool) -> Result<Growing, String> {
        let ambient = self.settings.ambient;
        let (sums, world) = if let Method::Path { max_depth, denoise } = self.settings.method {
            let options = RenderOptions {
                width: self.size[0],
                height: self.size[1],
                // Passes say how many.
                spp: u32::MAX / 2,
                integrator: Integrator::Path,
                max_depth,
                aovs: denoise,
                seen: denoise,
                ..RenderOptions::default()
            };
            let accumulation = Box::new(Accumulation::new(options).map_err(|error| error.to_string())?);
            let opacities = Arc::new(Opacities::new(self.pixels()));
            let layers = Layers { table: self.stage.table.clone(), opacities: opacities.clone() };
            let world = self.stage.world(ambient, Some(Arc::new(layers)), self.view.moves(), pool)?;
            (Sums::Paths { accumulation, opacities }, world)
        } else {
            (Sums::Own(vec![[0.0; 4]; self.pixels()]), self.stage.world(ambient, None, false, pool)?)
        };
        Ok(Growing { key: self.key, sums, world, first_hits: None, samples: 0 })
    }

    /// Adds a frame's samples; false where the program stopped it.
    fn grow(&self, growing: &mut Growing, pool: &ThreadPool, stop: &AtomicBool) -> Result<bool, String> {
        let (first, more) = (growing.samples, self.settings.samples(self.accumulates));
        let whole = match &mut growing.sums {
            Sums::Paths { accumulation, .. } => {
                accumulation.pass(&growing.world, &*self.view, more, pool, &Stop(stop))
            }
            Sums::Own(sums) if self.moves() => {
                for sample in first..first + more {
                    // Halves, quarters and so on: each number of samples is spread over the time.
                    let share = sample.reverse_bits() as f32 / u32::MAX as f32;
                    let world = self.stage.moment(self.settings.ambient, share, pool)?;
                    self.add(&world, sample..sample + 1, Some(share), sums, pool, stop);
                }
                !stop.load(Ordering::Relaxed)
            }
            Sums::Own(sums) => self.add(&growing.world, first..first + more, None, sums, pool, stop),
        };
        growing.samples += more;
        Ok(whole)
    }

    /// Whether something moves while the shutter is open.
    fn moves(&self) -> bool {
        self.stage.moves() || self.view.moves()
    }

    /// Adds samples at a share of the time that the shutter is open; false where the program stopped it.
    fn add(
        &self,
        world: &World,
        samples: std::ops::Range<u32>,
        share: Option<f32>,
        sums: &mut [Color],
        pool: &ThreadPool,
        stop: &AtomicBool,
    ) -> bool {
        pool.install(|| {
            let rows = sums.par_chunks_mut(self.size[0] as usize).enumerate();
            rows.for_each(|(row, sums)| {
                if !stop.load(Ordering::Relaxed) {
                    self.add_row(world, row as u32, samples.clone(), share, sums);
                }
            });
            !stop.load(Ordering::Relaxed)
        })
    }

    /// Adds samples of a row, counted from the top.
    fn add_row(
        &self,
        world: &World,
        row: u32,
        samples: std::ops::Range<u32>,
        share: Option<f32>,
        sums: &mut [Color],
    ) {
        let [width, height] = self.size;
        let (table, settings) = (&*self.stage.table, &self.settings);
        let ambient = Vec3::from(settings.ambient);
        let mut rays = gnurt::accel::RayBatch::default();
        let times: Vec<f32> = share.into_iter().cycle().take(width as usize).collect();
        for sample in samples {
            let key = |x: u32| SampleKey { pixel: row * width + x, sample, branch: 0 };
            let position = |x: u32| {
                let [dx, dy] = sample_pair(0, key(x), 0, purpose::PIXEL);
                [(x as f32 + dx) / width as f32, 1.0 - (row as f32 + dy) / height as f32]
            };
            let positions: Vec<[f32; 2]> = (0..width).map(position).collect();
            let lens: Vec<[f32; 2]> = (0..width).map(|x| sample_pair(0, key(x), 0, purpose::LENS)).collect();
            rays.clear();
            let camera = CameraSamples { positions: &positions, lens: &lens, times: &times };
            self.view.rays(&camera, self.aspect(), &mut rays);
            for (x, sum) in sums.iter_mut().enumerate() {
                let key = key(x as u32);
                let [random, _] = sample_pair(0, key, 0, purpose::CHOICE);
                let ray = rays.get(x);
                let (light, stopped) = walk((world, table), &ray, &settings.method, ambient, key, random);
                let all = [light.x, light.y, light.z, stopped];
                sum.iter_mut().zip(all).for_each(|(sum, x)| *sum += if x.is_finite() { x } else { 0.0 });
            }
        }
    }

    /// Means of the samples over the background, from the lowest row on.
    fn pixels_of(&self, growing: &Growing, pool: &ThreadPool) -> Result<Vec<Color>, String> {
        let count = growing.samples.max(1) as f32;
        let associated: Vec<Color> = match &growing.sums {
            Sums::Own(sums) => sums.iter().map(|sum| sum.map(|x| x / count)).collect(),
            Sums::Paths { accumulation, opacities } => {
                let mut picture = accumulation.picture();
                if accumulation.options().aovs {
                    let options = denoise::Options::default();
                    denoise::denoise(&mut picture, &options, pool).map_err(|error| error.to_string())?;
                }
                let opacity = |i: usize| (opacities.sum(i) / count).clamp(0.0, 1.0);
                picture.color.iter().enumerate().map(|(i, &[r, g, b, _])| [r, g, b, opacity(i)]).collect()
            }
        };
        let [width, height] = self.size;
        let over = |i: usize| {
            let (x, row) = (i as u32 % width, i as u32 / width);
            // Rows count from the top there, from below here.
            let [r, g, b, a] = associated[((height - 1 - row) * width + x) as usize];
            let position = [(x as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32];
            let [br, bg, bb, ba] = self.settings.background.at(position);
            let rest = 1.0 - a;
            let shown = if self.settings.premultiplies { rest * ba } else { rest };
            [r + br * shown, g + bg * shown, b + bb * shown, a + ba * rest]
        };
        let pixels = (0..self.pixels()).map(over);
        Ok(pixels.collect())
    }

    fn first_hits(&self, world: &World, pool: &ThreadPool) -> Vec<FirstHit> {
        let [width, height] = self.size;
        let one = |i: usize| {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let position = [(x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32];
            first_hit(world, &self.stage.table, &self.view.ray(position, self.aspect()))
        };
        pool.install(|| (0..self.pixels()).into_par_iter().with_min_len(256).map(one).collect())
    }

    /// Renders a frame; `kept` holds the growing state between frames. `None` where the program stopped it.
    pub(crate) fn run(
        &self,
        kept: &mut Option<Growing>,
        pool: &ThreadPool,
        stop: &AtomicBool,
    ) -> Result<Option<Output>, String> {
        let goes_on = |growing: &Growing| self.accumulates && growing.key == self.key;
        let mut growing = match kept.take().filter(goes_on) {
            Some(growing) => growing,
            None => self.begin(pool)?,
        };
        if !self.grow(&mut growing, pool, stop)? {
            return Ok(None);
        }
        let pixels = self.pixels_of(&growing, pool)?;
        if self.formats[1..].iter().any(Option::is_some) && growing.first_hits.is_none() {
            let middle =
                self.moves().then(|| self.stage.moment(self.settings.ambient, 0.5, pool)).transpose()?;
            growing.first_hits = Some(self.first_hits(middle.as_ref().unwrap_or(&growing.world), pool));
        }
        let first_hits = growing.first_hits.as_deref().unwrap_or_default();
        let mut output = Output::new(self.size, &self.formats, &pixels, first_hits);
        output.samples = growing.samples;
        *kept = Some(growing);
        Ok(Some(output))
    }
}
