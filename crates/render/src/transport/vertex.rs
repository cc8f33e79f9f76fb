// SPDX-License-Identifier: GPL-3.0-or-later
//! The vertices of paths: hits with all that scattering needs, in the order of their rays.
//! Batches by shader after the paper's section 8. Space: world.
//! Tests: the integrators' tests.

use glam::Vec3;
use gnurt_shading::bsdf::{ClosureBatch, Scattering};
use gnurt_shading::{SurfaceBatch, SurfacePoint, SurfaceShader, Vec3s};

use super::manifold::SmoothPoint;
use super::radiance_only;
use crate::cone::ConeHit;
use crate::tracer::{AttributeRequests, BatchTracer, Sharing};
use crate::world::HitLanes;

/// Knowledge about the scattering of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Known {
    /// Its shader returns closures.
    Closures,
    /// Its shader only shows: it was shown under a few lights, and under none ([`BatchTracer::dark`]).
    Probed,
    /// None: emission is the radiance of its shader.
    Shown,
}

/// A point of a path on a surface.
#[derive(Clone, Debug)]
pub(crate) struct Vertex {
    /// Where rays leave it.
    pub(crate) point: SurfacePoint,
    /// Unit, to where the ray came from.
    pub(crate) wo: Vec3,
    /// Scattering, emission and opacity. Emission counts whether or not the path is stopped.
    pub(crate) scattering: Scattering,
    /// Whether only its shader knows its radiance: the emission then is all of it, and paths end here.
    pub(crate) is_final: bool,
    /// The part of the emission that a probed shader adds without light, beside the described emission: light
    /// samples do not know it.
    pub(crate) shown: Vec3,
    /// Relative weight of direct light here; 1 if shaders return closures.
    pub(crate) light_gain: f32,
    /// How far the ray came.
    pub(crate) t: f32,
    /// How its cone met the surface.
    pub(crate) cone: ConeHit<f32>,
    /// The hit: leaf, mesh, triangle.
    pub(crate) ids: [u32; 3],
    /// Where chains of searches go on, if the tracer knows of such.
    pub(crate) smooth: Option<Box<SmoothPoint>>,
}

impl Vertex {
    /// Makes it black: no radiance leaves it, and no path continues.
    pub(crate) fn darken(&mut self) {
        (self.scattering.emission, self.shown, self.is_final) = (Vec3::ZERO, Vec3::ZERO, true);
    }
}

impl BatchTracer<'_> {
    /// The vertex of each ray, `None` where it hit nothing.
    pub(crate) fn vertices(&mut self, from: HitLanes) -> Vec<Option<Vertex>> {
        let mut vertices = Vec::new();
        vertices.resize_with(from.rays.len(), || None);
        self.for_each_surface(from, AttributeRequests::Light, |tracer, shader, lanes, points| {
            if let Some(log) = &mut tracer.log {
                log.surface(shader, points);
            }
            tracer.vertices_of(shader, lanes, points, &mut |lane, vertex| vertices[lane] = Some(vertex));
        });
        vertices
    }

    /// Writes the closures of points of one shader, and returns how they are known.
    pub(crate) fn closures_of(
        &mut self,
        shader: &dyn SurfaceShader,
        points: &SurfaceBatch,
        closures: &mut ClosureBatch,
    ) -> Known {
        closures.reset(points.len());
        shader.evaluate_traced(self, points, closures);
        let Some(shader) = shader.radiance() else { return Known::Closures };
        if self.probes {
            self.dark = radiance_only::probe(shader, points, self.options.white, closures);
            for k in 0..points.len() {
                self.dark.set(k, self.dark.get(k) * closures.coverage(k));
                closures.emit(k, self.dark.get(k));
            }
            return Known::Probed;
        }
        let mut radiance = Vec3s::splat(points.len(), Vec3::ZERO);
        shader.shade(self, points, &mut radiance);
        if self.sharing == Sharing::Pattern {
            // This part is excluded from averaging.
            radiance_only::probe(shader, points, self.options.white, closures);
        }
        (0..points.len()).for_each(|k| closures.emit(k, radiance.get(k) * closures.coverage(k)));
        Known::Shown
    }

    /// Calls `with(lane, vertex)` for each point of a batch.
    pub(crate) fn vertices_of(
        &mut self,
        shader: &dyn SurfaceShader,
        lanes: &[u32],
        points: &SurfaceBatch,
        with: &mut dyn FnMut(usize, Vertex),
    ) {
        let mut closures = std::mem::take(&mut self.closures);
        let known = self.closures_of(shader, points, &mut closures);
        let is_final = known == Known::Shown;
        let light_gain = if known == Known::Probed { std::f32::consts::PI * self.options.white } else { 1.0 };
        let caustics = self.caustics.filter(|_| known == Known::Closures);
        for (k, &lane) in lanes.iter().enumerate() {
            let vertex = Vertex {
                point: points.point(k),
                wo: -points.ray_dir.get(k),
                scattering: closures.point(k),
                is_final,
                shown: if known == Known::Probed { self.dark.get(k) } else { Vec3::ZERO },
                light_gain,
                t: points.t[k],
                cone: ConeHit::of(points, k),
                ids: [points.leaf_id[k], points.geom_id[k], points.prim_id[k]],
                smooth: caustics.and_then(|caustics| {
                    SmoothPoint::of((self.world, caustics), (points, &closures), k).map(Box::new)
                }),
            };
            with(lane as usize, vertex);
        }
        self.closures = closures;
    }
}
