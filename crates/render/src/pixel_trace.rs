// SPDX-License-Identifier: GPL-3.0-or-later
//! One sample of one pixel, with every value that flows: ray, hit, surface point, lights, shadows, radiance.
//! Source: original. It runs the same code as a rendering, on a batch of one, with a log.

use std::fmt;

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, Ray, RayBatch};
use gnurt_shading::{CameraShader, LightBatch, SurfaceBatch, Vec3s};

use crate::error::RenderError;
use crate::integrators;
use crate::many_lights::PassLights;
use crate::options::RenderOptions;
use crate::progress::Silent;
use crate::tile::{CameraBatch, Job};
use crate::tracer::BatchTracer;
use crate::world::{HitLanes, World};

/// All that happened for one sample of a pixel, in order. Printed by `Display`, one line per value.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelTrace {
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// One value each, indented by bounces.
    pub lines: Vec<String>,
    /// What came out.
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
    let options = RenderOptions { crop: None, heatmap: false, aovs: false, interleave: 1, ..options.clone() };
    options.region()?;
    if x >= options.width || y >= options.height {
        return Err(RenderError::NoSuchPixel { x, y, width: options.width, height: options.height });
    }
    let mut job = Job::new(world, camera, &options, &Silent);
    job.pass = PassLights::new(&job, 0);
    let mut tracer = BatchTracer::new(world, &options, false);
    tracer.pass = job.pass.as_ref();
    tracer.log = Some(Log::default());
    let mut batch = CameraBatch::default();
    job.camera_rays(std::iter::once([x, y]), 0..1, &mut batch);
    let CameraBatch { rays, keys, .. } = batch;
    let hits = tracer.intersect(&rays, &keys, Coherence::Coherent);
    if let Some(log) = &mut tracer.log {
        log.rays(0, &rays, &hits);
    }
    let camera = HitLanes { rays: &rays, keys: &keys, hits: &hits, depth: 0, epsilon: options.ray_epsilon };
    let mut radiance = Vec3s::default();
    integrators::radiance(options.integrator, &mut tracer, camera, &mut radiance);
    let lines = tracer.log.take().unwrap_or_default().lines;
    Ok(PixelTrace { x, y, lines, radiance: radiance.get(0).into() })
}

/// Lines of values as they come by.
#[derive(Clone, Debug, Default)]
pub(crate) struct Log {
    depth: usize,
    lines: Vec<String>,
}

impl Log {
    /// Rays with this many bounces behind them, and what they hit.
    pub(crate) fn rays(&mut self, depth: u32, rays: &RayBatch, hits: &HitBatch) {
        self.depth = depth as usize;
        for i in 0..rays.len() {
            self.line("ray", ray(&rays.get(i)));
            let hit = hits.get(i).map_or_else(
                || "nothing".to_owned(),
                |hit| {
                    let ids =
                        format!("instance {} mesh {} triangle {}", hit.inst_id, hit.geom_id, hit.prim_id);
                    format!("t {} u {} v {}  {ids}", hit.t, hit.u, hit.v)
                },
            );
            self.line("hit", hit);
        }
    }

    /// Points that a shader is called for.
    pub(crate) fn surface(&mut self, points: &SurfaceBatch) {
        self.depth = points.depth as usize;
        for i in 0..points.len() {
            let side = if points.front(i) { "front" } else { "back" };
            self.line("point", format!("{}  error {}  {side}", triple(points.p.get(i)), points.error[i]));
            self.line(
                "normals",
                format!("{}  shading {}", triple(points.ng.get(i)), triple(points.ns.get(i))),
            );
            self.line("uv", format!("{} {}", points.texcoord[0][i], points.texcoord[1][i]));
        }
    }

    /// What a light sends to the points.
    pub(crate) fn light(&mut self, number: usize, light: &LightBatch) {
        for i in 0..light.dist.len() {
            let (dir, radiance) = (triple(light.dir.get(i)), triple(light.radiance.get(i)));
            self.line(
                "light",
                format!("{number}  towards {dir}  distance {}  arriving {radiance}", light.dist[i]),
            );
        }
    }

    /// Rays towards lights and what comes through.
    pub(crate) fn shadows(&mut self, rays: &RayBatch, transmittance: &Vec3s) {
        for i in 0..rays.len() {
            self.line("shadow", format!("{}  through {}", ray(&rays.get(i)), triple(transmittance.get(i))));
        }
    }

    fn line(&mut self, what: &str, value: String) {
        self.lines.push(format!("{:indent$}{what:<9} {value}", "", indent = 2 * self.depth));
    }
}

fn ray(ray: &Ray) -> String {
    format!("from {}  along {}  t {} to {}", triple(ray.org), triple(ray.dir), ray.t_near, ray.t_far)
}

fn triple(v: impl Into<Vec3>) -> String {
    let v = v.into();
    format!("({}, {}, {})", v.x, v.y, v.z)
}
