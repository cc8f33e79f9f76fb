// SPDX-License-Identifier: GPL-3.0-or-later
//! One sample, or several, of all pixels of a tile: camera rays, hits, radiance, film.
//! A batch is one sample of all pixels of a tile, or several, where many rays together are worth more than few.
//! The result of a ray does not depend on the others, and samples are added in order: pictures do not depend
//! on batches.

use std::sync::atomic::Ordering;

use gnurt_accel::Coherence;
use gnurt_scene::RayMask;
use gnurt_shading::Vec3s;

use crate::behind::Behind;
use crate::camera_batch::CameraBatch;
use crate::cost::TileCosts;
use crate::expressions::Ledger;
use crate::film::TileFilm;
use crate::holdouts;
use crate::integrators;
use crate::job::Job;
use crate::lobe_colors;
use crate::many_lights::interleave::{PatternTexels, Texel};
use crate::many_lights::{self, PassLights};
use crate::mattes;
use crate::options::Integrator;
use crate::pixels;
use crate::seen::closer_look;
use crate::stats::RenderStats;
use crate::tracer::BatchTracer;
use crate::transport::links::LinkedPaths;

/// Paths that go together, about: enough to fill lanes when most have ended, few enough for caches.
const WAVEFRONT: usize = 4096;

/// Takes samples.
#[derive(Clone, Copy)]
pub(crate) struct Sampler<'a> {
    pub(crate) job: &'a Job<'a>,
    /// Virtual lights of the sample that is taken, if the integrator has any.
    pub(crate) pass: Option<&'a PassLights>,
}

/// A sample of each pixel of a tile, with light and surfaces separate.
pub(crate) struct SplitLight {
    /// Row by row.
    pub(crate) texels: Vec<Texel>,
    batch: CameraBatch,
    behind: Vec<Behind>,
    costs: Vec<u64>,
    stats: RenderStats,
}

impl<'a> Sampler<'a> {
    /// A tracer that renders one tile after another.
    pub(crate) fn tracer(&self) -> BatchTracer<'a> {
        let mut tracer = self.job.tracer(self.job.options.heatmap);
        tracer.cone = self.job.cone;
        tracer.guide_from = self.job.guide;
        tracer.caustics = self.job.caustics.as_deref();
        tracer.lights = self.pass.map(|pass| pass as _);
        tracer.wavefront.ledger = self.job.light_paths.clone().map(Ledger::new);
        tracer.wavefront.linked = self.job.links.clone().map(LinkedPaths::new);
        tracer
    }

    /// Takes the next samples of all pixels of a tile, up to the size of a batch and up to `last`.
    pub(crate) fn render_samples(&self, tile: &mut TileFilm, tracer: &mut BatchTracer, last: u32) {
        let (guide, last) = match tracer.guide_from {
            Some((_, from)) if tile.samples < from => (None, last.min(from)),
            guide => (guide.map(|(guide, _)| guide), last),
        };
        tracer.guide = guide;
        let mut batch = std::mem::take(&mut tracer.camera);
        let pixels = tile.first.len();
        let at_once = match self.job.options.integrator {
            Integrator::Path => (WAVEFRONT / pixels.max(1)).clamp(1, 16) as u32,
            _ => 1,
        };
        let samples = tile.samples..last.min(tile.samples.saturating_add(at_once));
        self.job.camera_rays(tile.pixels(), samples.clone(), &mut batch);
        let CameraBatch { rays, keys, hits, .. } = &mut batch;
        tracer.intersect_into(RayMask::CAMERA, rays, keys, Coherence::Coherent, hits);
        let mut radiance = std::mem::take(&mut batch.radiance);
        let camera = batch.met();
        holdouts::begin(tracer, camera.keys.len());
        integrators::radiance(self.job.options.integrator, tracer, self.pass, camera, &mut radiance);
        holdouts::hold_out(tracer, camera, &mut radiance);
        let mut ledger = tracer.wavefront.ledger.take();
        if let Some(ledger) = &mut ledger {
            lobe_colors::fill(tracer, &self.job.options.light_layers, camera, &mut ledger.layers);
        }
        let taken = if ledger.is_some() { radiance.clone() } else { Vec3s::default() };
        self.show(tracer, &batch, &mut radiance);
        for (sample, first) in samples.zip((0..).step_by(pixels.max(1))) {
            let lanes = first..first + pixels;
            if let Some(aovs) = &mut tile.aovs {
                aovs.add(tracer, camera, lanes.clone(), sample, self.job.forward, &radiance);
            }
            closer_look::take(self.job, tile, tracer, sample);
            if !self.job.options.mattes.kinds.is_empty() {
                mattes::gather(
                    tracer,
                    &self.job.options.mattes.kinds,
                    camera,
                    lanes.clone(),
                    &mut tile.mattes,
                );
            }
            if let Some(ledger) = &ledger {
                tile.light.add(&ledger.layers, &taken, lanes.clone());
            }
            let covers = (camera.hits, &tracer.behind[..], &tracer.held[..]);
            tracer.stats.bad_samples += tile.add_sample(&radiance, covers, lanes);
        }
        tracer.wavefront.ledger = ledger;
        tracer.stats.camera_rays += camera.rays.len() as u64;
        tracer.stats.samples += camera.rays.len() as u64;
        batch.radiance = radiance;
        tracer.camera = batch;
    }

    /// Replaces radiance by the colours of a pixel shader, which hold the background in its share.
    fn show(&self, tracer: &mut BatchTracer, batch: &CameraBatch, radiance: &mut Vec3s) {
        if self.job.world.pixel().is_none() {
            return;
        }
        // A pixel shader's rays have lanes of their own.
        let mut behind = std::mem::take(&mut tracer.behind);
        pixels::show(self.job, self.pass, tracer, batch, radiance);
        behind.iter_mut().enumerate().for_each(|(lane, seen)| seen.light = radiance.get(lane) * seen.share);
        tracer.behind = behind;
    }

    /// A sample of each pixel of a part of the film, with light and surfaces separate; nothing is added to
    /// the film.
    pub(crate) fn split_sample(&self, tile: &TileFilm, tracer: &mut BatchTracer, sample: u32) -> SplitLight {
        let mut batch = CameraBatch::default();
        self.job.camera_rays(tile.pixels(), sample..sample + 1, &mut batch);
        tracer.costs = self.job.options.heatmap.then(|| TileCosts::new(tile.rect, tracer.pixel_order));
        let CameraBatch { rays, keys, hits, .. } = &mut batch;
        tracer.intersect_into(RayMask::CAMERA, rays, keys, Coherence::Coherent, hits);
        let mut radiance = std::mem::take(&mut batch.radiance);
        let camera = batch.met();
        let mut lanes = vec![Texel::default(); camera.keys.len()];
        if let Some(pass) = self.pass {
            many_lights::split_radiance(tracer, pass, camera, &mut radiance, &mut lanes);
        }
        tracer.stats.camera_rays += camera.keys.len() as u64;
        tracer.stats.samples += camera.keys.len() as u64;
        batch.radiance = radiance;
        let [x0, y0, x1, _] = tile.rect;
        let mut texels = lanes.clone();
        for ([x, y], texel) in tile.pixels().zip(lanes) {
            texels[((y - y0) * (x1 - x0) + (x - x0)) as usize] = texel;
        }
        let costs = tracer.costs.take().map_or_else(Vec::new, |costs| costs.costs);
        let behind = std::mem::take(&mut tracer.behind);
        SplitLight { texels, batch, behind, costs, stats: tracer.take_stats() }
    }

    /// Adds a split sample to the film; `filter` combines its parts.
    pub(crate) fn add_split(
        &self,
        tile: &mut TileFilm,
        tracer: &mut BatchTracer,
        sample: u32,
        split: &SplitLight,
        visible: &PatternTexels,
    ) -> RenderStats {
        let mut radiance = Vec3s::default();
        visible.filtered(tile, &mut radiance);
        holdouts::begin(tracer, split.batch.keys.len());
        holdouts::hold_out(tracer, split.batch.met(), &mut radiance);
        tracer.behind.clone_from(&split.behind);
        self.show(tracer, &split.batch, &mut radiance);
        let camera = split.batch.met();
        if let Some(aovs) = &mut tile.aovs {
            aovs.add(tracer, camera, 0..camera.keys.len(), sample, self.job.forward, &radiance);
        }
        closer_look::take(self.job, tile, tracer, sample);
        if !self.job.options.mattes.kinds.is_empty() {
            let kinds = &self.job.options.mattes.kinds;
            mattes::gather(tracer, kinds, camera, 0..camera.keys.len(), &mut tile.mattes);
        }
        tile.costs.resize(split.costs.len(), 0);
        tile.costs.iter_mut().zip(&split.costs).for_each(|(sum, cost)| *sum += cost);
        let covers = (camera.hits, &tracer.behind[..], &tracer.held[..]);
        let bad_samples = tile.add_sample(&radiance, covers, 0..camera.keys.len());
        let mut stats = tracer.take_stats();
        stats.add(&split.stats);
        stats.bad_samples += bad_samples;
        let done = self.job.samples_done.fetch_add(stats.samples, Ordering::Relaxed) + stats.samples;
        self.job.watch.update(done as f64 / self.job.all_samples as f64, done);
        stats
    }
}
