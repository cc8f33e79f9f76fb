// SPDX-License-Identifier: GPL-3.0-or-later
//! The vertices of paths: hits with all that scattering needs, in the order of their rays.
//! Source: original; batches by shader after the paper's section 8. Space: world.
//! Proof: the integrators' tests.

use glam::Vec3;
use gnurt_shading::bsdf::{Bsdf, Scattering};
use gnurt_shading::{SampleKey, SurfaceBatch, SurfacePoint, SurfaceShader, Vec3s};

use super::finals;
use crate::tracer::{BatchTracer, Wanted};
use crate::world::HitLanes;

/// A point of a path on a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// Where rays leave it.
    pub(crate) point: SurfacePoint,
    /// Unit, to where the ray came from.
    pub(crate) wo: Vec3,
    /// What it does to light, what it gives off, how much of it is there.
    pub(crate) scattering: Scattering,
    /// Whether only its shader knows what it sends back: the emission then is all of that, and paths end here.
    pub(crate) is_final: bool,
    /// What it shows where all light of the environment reaches it, if it only catches shadow.
    pub(crate) backdrop: Option<Vec3>,
    /// What light straight from lamps counts here more than other light; 1 where shaders tell what they do to light.
    pub(crate) lamp_gain: f32,
    /// Whether the ray came to the side that its geometric normal points to.
    pub(crate) front: bool,
    /// How far the ray came.
    pub(crate) t: f32,
    /// What was hit: instance, mesh, triangle.
    pub(crate) ids: [u32; 3],
    /// Where on the triangle: weights of its second and third corner.
    pub(crate) place: [f32; 2],
    /// Key of its random numbers.
    pub(crate) key: SampleKey,
}

impl BatchTracer<'_> {
    /// The vertex of each ray, `None` where it hit nothing.
    pub(crate) fn vertices(&mut self, from: HitLanes) -> Vec<Option<Vertex>> {
        let mut vertices = vec![None; from.rays.len()];
        self.for_each_surface(from, Wanted::Light, |tracer, shader, lanes, points| {
            if let Some(log) = &mut tracer.log {
                log.surface(points);
            }
            tracer.vertices_of(shader, lanes, points, &mut |lane, vertex| vertices[lane] = Some(vertex));
        });
        vertices
    }

    /// Calls `with(lane, vertex)` for each point of a batch.
    pub(crate) fn vertices_of(
        &mut self,
        shader: &dyn SurfaceShader,
        lanes: &[u32],
        points: &SurfaceBatch,
        with: &mut dyn FnMut(usize, Vertex),
    ) {
        let mut scattering = std::mem::take(&mut self.scattering);
        scattering.clear();
        let is_known = shader.scatter(points, &mut scattering);
        let is_final = !(is_known || self.probes);
        let mut lamp_gain = 1.0;
        if !is_known && self.probes {
            let white = self.options.white;
            finals::probe(shader, points, white, &mut scattering);
            lamp_gain = std::f32::consts::PI * white;
        }
        if is_final {
            let mut radiance = Vec3s::splat(lanes.len(), Vec3::ZERO);
            shader.shade(self, points, &mut radiance);
            if self.is_interleaved {
                // What light is averaged without.
                finals::probe(shader, points, self.options.white, &mut scattering);
                scattering.iter_mut().enumerate().for_each(|(k, point)| point.emission = radiance.get(k));
            } else {
                scattering.extend((0..lanes.len()).map(|k| Scattering {
                    bsdf: Bsdf::black(points.facing_ns(k)),
                    emission: radiance.get(k),
                    coverage: 1.0,
                }));
            }
        }
        let backdrop = shader.backdrop();
        for (k, (&lane, &scattering)) in lanes.iter().zip(&scattering).enumerate() {
            let vertex = Vertex {
                point: points.point(k),
                wo: -points.ray_dir.get(k),
                scattering,
                is_final,
                backdrop,
                lamp_gain,
                front: points.front(k),
                t: points.t[k],
                ids: [points.inst_id[k], points.geom_id[k], points.prim_id[k]],
                place: [points.u[k], points.v[k]],
                key: points.key[k],
            };
            with(lane as usize, vertex);
        }
        self.scattering = scattering;
    }
}
