// SPDX-License-Identifier: GPL-3.0-or-later
//! Colours of visible surfaces by the kind of their scattering: the light 1 from all sides, without shadows; and values
//! that their shaders put out.
//! They replace the light of some layers. A surface that is there in part covers that share of a ray; the rest goes
//! straight on. Media cover nothing. Space: world. Tests: crates/render/tests/light_layers.rs,
//! crates/cli/tests/program/shader_outputs.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{SampleKey, SurfaceBatch, SurfaceShader, Vec3s};

use crate::cone::Cones;
use crate::expressions::LightLayer;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::transport::opacity::MOST_LAYERS;
use crate::world::HitLanes;

/// Less of a ray is not followed.
const LEAST: f32 = 1e-4;

/// Rays behind surfaces that are there in part.
#[derive(Default)]
struct Rest {
    rays: RayBatch,
    keys: Vec<SampleKey>,
    /// The camera ray of each, and its share.
    lanes: Vec<(usize, f32)>,
}

/// What replaces the light of some layers.
struct Replaced<'a> {
    /// Layers of colours, and the parts that count.
    colors: Vec<(usize, [bool; 4])>,
    /// Layers of shaders' outputs, by name.
    outputs: Vec<(usize, &'a str)>,
    light: &'a mut [Vec3s],
}

impl Replaced<'_> {
    /// Adds the colours of a surface to a camera ray.
    fn add_colors(&mut self, lane: usize, share: f32, parts: [Vec3; 4]) {
        for (layer, counts) in &self.colors {
            let counted = parts.iter().zip(counts).filter(|(_, counts)| **counts);
            self.light[*layer].add(lane, counted.map(|(part, _)| *part).sum::<Vec3>() * share);
        }
    }

    /// Adds the outputs of a surface at some points; `of` gives the camera ray of a point and its share.
    fn add_outputs(
        &mut self,
        shader: &dyn SurfaceShader,
        points: &SurfaceBatch,
        of: impl Fn(usize) -> (usize, f32),
    ) {
        let known = shader.outputs();
        let mut values = Vec3s::default();
        for (layer, name) in self.outputs.iter().filter(|(_, name)| known.iter().any(|own| own.name == *name))
        {
            values.reset(points.len(), Vec3::ZERO);
            shader.output(name, points, &mut values);
            for k in 0..points.len() {
                let ((lane, share), value) = (of(k), values.get(k));
                if share > 0.0 && value.is_finite() {
                    self.light[*layer].add(lane, value * share);
                }
            }
        }
    }
}

/// Replaces the light of those layers that are colours or outputs of shaders.
pub(crate) fn fill(tracer: &mut BatchTracer, layers: &[LightLayer], camera: HitLanes, light: &mut [Vec3s]) {
    let numbered = || layers.iter().enumerate();
    let colors: Vec<_> = numbered().filter_map(|(layer, of)| Some((layer, of.color()?))).collect();
    let outputs: Vec<_> = numbered().filter_map(|(layer, of)| Some((layer, of.output()?))).collect();
    let all = colors.iter().map(|(layer, _)| *layer).chain(outputs.iter().map(|(layer, _)| *layer));
    let all: Vec<usize> = all.collect();
    if all.is_empty() {
        return;
    }
    all.iter().for_each(|&layer| light[layer].reset(camera.keys.len(), Vec3::ZERO));
    let mut to = Replaced { colors, outputs, light };
    let mut rest = gather(tracer, camera, |lane| (lane, 1.0), &mut to);
    // Opacity textures are read without filtering.
    let cones = Cones::default();
    for _ in 0..MOST_LAYERS {
        if rest.keys.is_empty() {
            break;
        }
        let Rest { rays, keys, lanes } = &rest;
        tracer.stats.secondary_rays += keys.len() as u64;
        let hits = tracer.intersect(RayMask::CAMERA, rays, keys, Coherence::Coherent);
        let from = HitLanes { rays, keys, hits: &hits, cones: Some(&cones), depth: 1 };
        rest = gather(tracer, from, |lane| lanes[lane], &mut to);
    }
}

/// Adds the colours and outputs of some hits; `of` gives the camera ray of a lane and its share. Returns the rest.
fn gather(
    tracer: &mut BatchTracer,
    from: HitLanes,
    of: impl Fn(usize) -> (usize, f32),
    to: &mut Replaced,
) -> Rest {
    let (mut rest, mut closures) = (Rest::default(), ClosureBatch::default());
    tracer.for_each_surface(from, AttributeRequests::Light, |tracer, shader, lanes, points| {
        closures.reset(points.len());
        shader.evaluate_traced(tracer, points, &mut closures);
        to.add_outputs(shader, points, |k| {
            let (pixel, share) = of(lanes[k] as usize);
            (pixel, share * closures.stopped(k))
        });
        for (k, &lane) in lanes.iter().enumerate() {
            let (pixel, share) = of(lane as usize);
            let coverage = closures.coverage(k);
            if coverage > 0.0 && !to.colors.is_empty() {
                let parts = closures.point(k).bsdf.albedo_parts(-points.ray_dir.get(k));
                if parts.iter().all(|part| part.is_finite()) {
                    to.add_colors(pixel, share * coverage, parts);
                }
            }
            let left = share * (1.0 - closures.stopped(k));
            if left > LEAST {
                rest.rays.push(points.spawn(k, points.ray_dir.get(k), f32::INFINITY));
                rest.keys.push(from.keys[lane as usize]);
                rest.lanes.push((pixel, left));
            }
        }
    });
    rest
}
