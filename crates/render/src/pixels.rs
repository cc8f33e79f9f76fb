// SPDX-License-Identifier: GPL-3.0-or-later
//! Pixel shaders, which compute the colours of pixels: between the integrator and the film, sample by sample.
//! The default pixel shader, the radiance along the camera ray, equals rendering without one. The film
//! averages their samples like light: lines are antialiased, and pieces, checkpoints and frames work as
//! without a pixel shader. Layers beside the colour still hold properties of the camera rays' hits, except
//! for directly visible light, which becomes unknown.
//! Space: world. Tests: crates/render/tests/pixels.rs.

use gnurt_accel::RayBatch;
use gnurt_scene::RayMask;
use gnurt_shading::{
    CameraSamples, LightBatch, PixelSamples, RayRequest, SampleKey, SurfaceBatch, SurfaceHit, Tracer, Vec3s,
};

use crate::camera_batch::CameraBatch;
use crate::integrators;
use crate::job::Job;
use crate::many_lights::PassLights;
use crate::restricted::closest_hits;
use crate::tracer::BatchTracer;
use crate::world::HitLanes;

/// Replaces `radiance`, that of the camera rays of a batch, by the colours of the world's pixel shader, if
/// there is one.
pub(crate) fn show(
    job: &Job,
    pass: Option<&PassLights>,
    tracer: &mut BatchTracer,
    batch: &CameraBatch,
    radiance: &mut Vec3s,
) {
    let Some(shader) = job.world.pixel() else { return };
    let CameraBatch { rays, keys, positions, lens, times, hits, .. } = batch;
    let (width, height) = (job.options.width as f32, job.options.height as f32);
    let neighbours = [[1.0 / width, 0.0], [0.0, -1.0 / height]].map(|[dx, dy]| {
        let moved: Vec<[f32; 2]> = positions.iter().map(|[x, y]| [x + dx, y + dy]).collect();
        let mut there = RayBatch::default();
        job.camera.rays(&CameraSamples { positions: &moved, lens, times }, width / height, &mut there);
        there
    });
    let distances: Vec<f32> =
        (0..rays.len()).map(|i| hits.get(i).map_or(f32::INFINITY, |hit| hit.t)).collect();
    let samples = PixelSamples {
        rays,
        neighbours: [&neighbours[0], &neighbours[1]],
        camera: CameraSamples { positions, lens, times },
        size: [job.options.width, job.options.height],
        projection: job.properties.projection,
        keys,
        radiance,
        distances: &distances,
    };
    let mut shown = Vec3s::default();
    shown.resize(rays.len());
    shader.show(&mut Looking { tracer, pass }, &samples, &mut shown);
    *radiance = shown;
    (tracer.direct, tracer.seen) = Default::default();
}

/// A tracer whose rays are those of the camera.
struct Looking<'t, 'w> {
    tracer: &'t mut BatchTracer<'w>,
    pass: Option<&'t PassLights>,
}

impl Tracer for Looking<'_, '_> {
    fn light_count(&self) -> usize {
        self.tracer.light_count()
    }

    fn light_is_visible(&self, light: usize) -> bool {
        self.tracer.light_is_visible(light)
    }

    fn illuminate(&mut self, light: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        self.tracer.illuminate(light, hits, out);
    }

    fn illuminate_in(&mut self, category: &str, light: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        self.tracer.illuminate_in(category, light, hits, out);
    }

    fn occluded(&mut self, request: &RayRequest, transmittance: &mut Vec3s) {
        self.tracer.occluded(request, transmittance);
    }

    fn trace(&mut self, _: u32, request: &RayRequest, radiance: &mut Vec3s) {
        let (tracer, RayRequest { rays, key: keys, .. }) = (&mut *self.tracer, request);
        tracer.stats.camera_rays += rays.len() as u64;
        let hits = &closest_hits(tracer, RayMask::CAMERA, request);
        if let Some(log) = &mut tracer.log {
            log.rays(0, rays, hits);
        }
        let camera = HitLanes { rays, keys, hits, cones: None, depth: 0 };
        integrators::radiance(tracer.options.integrator, tracer, self.pass, camera, radiance);
    }

    fn distances(&mut self, request: &RayRequest, out: &mut Vec<f32>) {
        self.tracer.distances_of(RayMask::CAMERA, request, out);
    }

    fn meet(&mut self, request: &RayRequest, out: &mut Vec<Option<SurfaceHit>>) {
        self.tracer.hits_of(RayMask::CAMERA, request, out);
    }

    fn random(&self, key: SampleKey, depth: u32, purpose: u32) -> [f32; 2] {
        self.tracer.random(key, depth, purpose)
    }
}
