// SPDX-License-Identifier: GPL-3.0-or-later
//! One sample of one pixel, with every value that flows: ray, hit, surface point, lights, shadows, radiance.
//! It runs the same code as a rendering, on a batch of one, with a log.

use std::fmt;

use gnurt_accel::Coherence;
use gnurt_scene::RayMask;
use gnurt_shading::{CameraShader, Vec3s};

use crate::camera_batch::CameraBatch;
use crate::error::RenderError;
use crate::integrators;
use crate::job::Job;
use crate::log::{Log, triple};
use crate::many_lights;
use crate::options::RenderOptions;
use crate::pixels;
use crate::progress::Unwatched;
use crate::transport::links::LinkedPaths;
use crate::transport::manifold;
use crate::world::World;

/// All that happened for one sample of a pixel, in order. Printed by `Display`, one line per value.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelTrace {
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// One value each, indented by bounces.
    pub lines: Vec<String>,
    /// The radiance of the sample.
    pub radiance: [f32; 3],
}

impl fmt::Display for PixelTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "pixel {},{}", self.x, self.y)?;
        self.lines.iter().try_for_each(|line| writeln!(f, "  {line}"))?;
        write!(f, "  radiance  {}", triple(self.radiance))
    }
}

/// Follows the first sample of a pixel.
///
/// # Errors
/// [`RenderError`] if the options leave nothing to render, or the pixel lies outside of the picture.
pub fn trace_pixel(
    world: &World,
    camera: &dyn CameraShader,
    options: &RenderOptions,
    x: u32,
    y: u32,
) -> Result<PixelTrace, RenderError> {
    let integrator = options.integrator.without_pilot();
    let options = RenderOptions {
        integrator,
        crop: None,
        heatmap: false,
        aovs: false,
        interleave: 1,
        ..options.clone()
    };
    options.region()?;
    if x >= options.width || y >= options.height {
        return Err(RenderError::NoSuchPixel { x, y, width: options.width, height: options.height });
    }
    let opened = world.needs_times().then(|| world.with_times(options.seed));
    let world = opened.as_ref().unwrap_or(world);
    let job = Job::new(world, camera, &options, &Unwatched);
    let pass = many_lights::pass_lights(&job, 0);
    let caustics = manifold::find(&mut job.tracer(false));
    let mut tracer = job.tracer(false);
    tracer.caustics = caustics.as_ref();
    tracer.lights = pass.as_ref().map(|pass| pass as _);
    tracer.wavefront.linked = job.links.clone().map(LinkedPaths::new);
    tracer.log = Some(Log::default());
    let mut batch = CameraBatch::default();
    job.camera_rays(std::iter::once([x, y]), 0..1, &mut batch);
    batch.hits = tracer.intersect(RayMask::CAMERA, &batch.rays, &batch.keys, Coherence::Coherent);
    let camera = batch.met();
    if let Some(log) = &mut tracer.log {
        log.rays(0, camera.rays, camera.hits);
    }
    let mut radiance = Vec3s::default();
    integrators::radiance(options.integrator, &mut tracer, pass.as_ref(), camera, &mut radiance);
    pixels::show(&job, pass.as_ref(), &mut tracer, &batch, &mut radiance);
    let lines = tracer.log.take().unwrap_or_default().lines;
    Ok(PixelTrace { x, y, lines, radiance: radiance.get(0).into() })
}
