// SPDX-License-Identifier: GPL-3.0-or-later
//! A picture in motion in the making: surfaces, light that earlier pictures knew, fresh samples.
//! Fresh samples go through the pixels' centres, as the first surfaces do, with their own random numbers in
//! each frame. A sample far brighter than all known light is clamped, because a short-lived picture has no
//! time to average fireflies. Space: world. Tests: crates/render/tests/motion.rs.

use glam::Vec3;
use gnurt_accel::Coherence;
use gnurt_accel::threads::{self, Pieces};
use gnurt_image::srgb::luminance;
use gnurt_scene::RayMask;
use gnurt_shading::sampling::hash_combine;
use gnurt_simd::dispatch_two;

use super::before::Before;
use super::choose::{need, rank_of};
use super::lattice::Lattice;
use super::surface_key::{Light, SurfaceKey, Tint};
use super::surface_sample::{ROWS, SurfaceSample, sample_surfaces};
use crate::film;
use crate::integrators;
use crate::job::Job;
use crate::many_lights::PassLights;
use crate::sampler::Sampler;
use crate::stats::RenderStats;
use crate::tracer::BatchTracer;

/// The largest number of remembered samples of a pixel.
const MOST: f32 = 64.0;
/// Fresh samples that go together.
const TOGETHER: usize = 1024;

/// A picture in the making, row by row of the lattice.
pub(super) struct Frame {
    pub(super) lattice: Lattice,
    pub(super) surface_keys: Vec<SurfaceKey>,
    pub(super) lights: Vec<Light>,
    /// Where the points were in the previous picture; see [`Before::origin`]. Empty where all pixels are traced.
    pub(super) origins: Vec<[f32; 2]>,
}

/// Memory of earlier frames.
#[derive(Default)]
pub(super) struct Spare {
    pub(super) surface_keys: Vec<SurfaceKey>,
    pub(super) lights: Vec<Light>,
    pub(super) origins: Vec<[f32; 2]>,
}

impl From<Frame> for Spare {
    fn from(frame: Frame) -> Self {
        Self { surface_keys: frame.surface_keys, lights: frame.lights, origins: frame.origins }
    }
}

impl Frame {
    /// In this memory.
    pub(super) fn new(lattice: Lattice, spare: Spare) -> Self {
        let [width, height] = lattice.size();
        let pixels = width as usize * height as usize;
        let Spare { mut surface_keys, mut lights, mut origins } = spare;
        surface_keys.resize(pixels, SurfaceKey::default());
        lights.resize(pixels, Light::default());
        origins.resize(if lattice.stride > 1 { pixels } else { 0 }, [f32::NAN; 2]);
        Self { lattice, surface_keys, lights, origins }
    }

    /// Finds the surfaces of all pixels, and their remembered light; returns the number of pixels with each
    /// of the needs 1, 2 and 4.
    pub(super) fn sample_surfaces(
        &mut self,
        job: &Job,
        before: Option<&Before>,
        tints: &mut Vec<Tint>,
        fading: f32,
        stats: &mut RenderStats,
    ) -> [u64; 3] {
        let [width, height] = self.lattice.size();
        tints.resize(self.surface_keys.len(), Tint::default());
        let band = (width * ROWS) as usize;
        let surface_keys = Pieces::new(&mut self.surface_keys, band);
        let (lights, tints) = (Pieces::new(&mut self.lights, band), Pieces::new(tints, band));
        let origins = (!self.origins.is_empty()).then(|| Pieces::new(&mut self.origins, band));
        let lattice = self.lattice;
        let sampler = Sampler { job, pass: None };
        let see = |tracer: &mut BatchTracer, n: usize| {
            let (mut surface_keys, mut lights, mut tints) =
                (surface_keys.lock(n), lights.lock(n), tints.lock(n));
            let mut origins = origins.as_ref().map(|origins| origins.lock(n));
            let top = n as u32 * ROWS;
            let mut rows = Rows {
                top,
                width,
                surface_keys: &mut surface_keys,
                tints: &mut tints,
                lights: &mut lights,
                origins: origins.as_mut().map(|origins| &mut origins[..]),
                counts: [0; 3],
            };
            let level = job.options.level;
            let range = [top, (top + ROWS).min(height)];
            sample_surfaces(job, lattice, tracer, range, &mut |places, samples| {
                dispatch_two!(level, _simd => rows.keep(before, fading, places, samples));
            });
            (rows.counts, tracer.take_stats())
        };
        let found: Vec<([u64; 3], RenderStats)> =
            threads::map_with(true, surface_keys.count(), || sampler.tracer(), see);
        found.iter().fold([0; 3], |sum, (counts, of_band)| {
            stats.add(of_band);
            [0, 1, 2].map(|k| sum[k] + counts[k])
        })
    }

    /// The pixels that get a fresh sample, neighbours together.
    pub(super) fn choose(&self, scale: f32, frame: u32) -> Vec<[u32; 2]> {
        let [width, height] = self.lattice.size();
        let of_band = |n: usize| {
            let top = n as u32 * ROWS;
            let mut chosen = Vec::new();
            for [x0, y0, x1, y1] in film::blocks([0, top, width, (top + ROWS).min(height)]) {
                for (y, x) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (y, x))) {
                    let i = (y * width + x) as usize;
                    if rank_of(x, y, frame) < scale * need(&self.surface_keys[i], &self.lights[i]) {
                        chosen.push([x, y]);
                    }
                }
            }
            chosen
        };
        threads::map(true, height.div_ceil(ROWS) as usize, of_band).concat()
    }

    /// Adds a fresh sample to some pixels; returns their brightness, or `None` if stopped. A sample counts at
    /// most `most` times the known light there, or that of the mean pixel.
    pub(super) fn sample(
        &mut self,
        job: &Job,
        pass: Option<&PassLights>,
        (chosen, frame): (&[[u32; 2]], u32),
        tints: &[Tint],
        [mean, most]: [f32; 2],
        stats: &mut RenderStats,
    ) -> Option<Vec<f32>> {
        let [width, _] = self.lattice.size();
        let sampler = Sampler { job, pass };
        let chunks: Vec<&[[u32; 2]]> = chosen.chunks(TOGETHER).collect();
        let take = |tracer: &mut BatchTracer, n: usize| {
            let pixels = chunks[n];
            let is_requested = !job.should_stop();
            let fresh_radiance = if is_requested {
                radiance(job, self.lattice, pass, tracer, (pixels, frame))
            } else {
                Vec::new()
            };
            (fresh_radiance, tracer.take_stats())
        };
        let found: Vec<(Vec<Vec3>, RenderStats)> =
            threads::map_with(true, chunks.len(), || sampler.tracer(), take);
        found.iter().for_each(|(_, of_chunk)| stats.add(of_chunk));
        if job.should_stop() {
            return None;
        }
        let light_of = |(&[x, y], &fresh_radiance): (&[u32; 2], &Vec3)| {
            let tint = &tints[(y * width + x) as usize];
            let is_number = fresh_radiance.is_finite();
            if is_number { (fresh_radiance - tint.plain).max(Vec3::ZERO) / tint.share } else { Vec3::NAN }
        };
        let fresh_radiance = found.iter().flat_map(|(fresh_radiance, _)| fresh_radiance);
        let mut samples: Vec<Vec3> = chosen.iter().zip(fresh_radiance).map(light_of).collect();
        // The brightness of the first picture was unknown.
        let mean = if mean > 0.0 { mean } else { mean_brightness(&samples) };
        let mut count_in = |(&[x, y], sample): (&[u32; 2], &mut Vec3)| {
            if !sample.is_finite() {
                stats.bad_samples += 1;
                return f32::NAN;
            }
            let light = &mut self.lights[(y * width + x) as usize];
            let known = if light.count >= 2.0 { luminance(light.mean.into()) } else { 0.0 };
            let most = most * known.max(mean);
            let brightness = luminance((*sample).into());
            if most > 0.0 && brightness > most {
                *sample *= most / brightness;
            }
            let count = light.count + 1.0;
            light.mean += (*sample - light.mean) / count;
            light.count = count.min(MOST);
            if most > 0.0 { brightness.min(most) } else { brightness }
        };
        Some(chosen.iter().zip(&mut samples).map(&mut count_in).collect())
    }
}

/// Rows of the lattice, from `top` on.
struct Rows<'a> {
    top: u32,
    width: u32,
    surface_keys: &'a mut [SurfaceKey],
    tints: &'a mut [Tint],
    lights: &'a mut [Light],
    origins: Option<&'a mut [[f32; 2]]>,
    /// Pixels with each of the needs 1, 2 and 4.
    counts: [u64; 3],
}

impl Rows<'_> {
    /// Keeps surfaces, with the light that is known of them.
    #[inline(always)]
    fn keep(&mut self, before: Option<&Before>, fading: f32, places: &[[u32; 2]], samples: &[SurfaceSample]) {
        for k in 0..places.len().min(samples.len()) {
            let ([x, y], sample) = (places[k], &samples[k]);
            let i = ((y - self.top) * self.width + x) as usize;
            let (mut origin, mut light) = ([f32::NAN; 2], Light::default());
            if let Some(before) = before {
                origin = before.origin(sample);
                light = before.recall(sample, origin, MOST);
            }
            light.count *= fading;
            (self.surface_keys[i], self.tints[i], self.lights[i]) = (sample.surface_key, sample.tint, light);
            if let Some(origins) = &mut self.origins {
                origins[i] = origin;
            }
            let need = need(&sample.surface_key, &light);
            let counts = &mut self.counts;
            counts[0] += u64::from(need > 0.0 && need < 2.0);
            counts[1] += u64::from((2.0..4.0).contains(&need));
            counts[2] += u64::from(need >= 4.0);
        }
    }
}

/// The mean luminance of the finite ones.
fn mean_brightness(samples: &[Vec3]) -> f32 {
    let finite = samples.iter().filter(|sample| sample.is_finite());
    let (sum, count) = finite
        .fold((0.0, 0.0), |(sum, count), sample| (sum + f64::from(luminance((*sample).into())), count + 1.0));
    (sum / f64::max(count, 1.0)) as f32
}

/// A sample of each of some pixels of the lattice.
fn radiance(
    job: &Job,
    lattice: Lattice,
    pass: Option<&PassLights>,
    tracer: &mut BatchTracer,
    (pixels, frame): (&[[u32; 2]], u32),
) -> Vec<Vec3> {
    let mut batch = std::mem::take(&mut tracer.camera);
    job.camera_rays(pixels.iter().map(|&at| lattice.pixel(at)), 0..1, &mut batch);
    // Numbers of their own for each frame, not the next ones of the pixel's sequence: light moves on to other pixels as the camera does, few
    // pixels take a sample in a frame, and later samples read textures finer (`cone::fineness`).
    for key in &mut batch.keys {
        key.pixel = hash_combine(key.pixel, frame);
    }
    tracer.intersect_into(RayMask::CAMERA, &batch.rays, &batch.keys, Coherence::Coherent, &mut batch.hits);
    let mut radiance = std::mem::take(&mut batch.radiance);
    integrators::radiance(job.options.integrator, tracer, pass, batch.met(), &mut radiance);
    tracer.stats.camera_rays += pixels.len() as u64;
    tracer.stats.samples += pixels.len() as u64;
    let fresh_radiance = (0..pixels.len()).map(|i| radiance.get(i)).collect();
    batch.radiance = radiance;
    tracer.camera = batch;
    fresh_radiance
}
