// SPDX-License-Identifier: GPL-3.0-or-later
//! Services for shaders: rays, lights and random numbers, in batches.
//! Invariant: the result of a lane depends on its ray and key only.
//! Tests: crates/render/tests/{lights,mirrors,restricted}.rs.

use glam::Vec3;
use gnurt_scene::RayMask;
use gnurt_shading::sampling::{purpose, sample_pair};
use gnurt_shading::{LightBatch, RayKind, RayRequest, SampleKey, SurfaceBatch, SurfaceHit, Tracer, Vec3s};

use crate::cone::Cones;
use crate::restricted::{closest_hits, illuminate_in};
use crate::tracer::{AttributeRequests, BatchTracer, MID_GREY};
use crate::world::HitLanes;

impl BatchTracer<'_> {
    /// How far rays of a kind go.
    pub(crate) fn distances_of(&mut self, kind: RayMask, request: &RayRequest, out: &mut Vec<f32>) {
        self.stats.secondary_rays += request.rays.len() as u64;
        let hits = closest_hits(self, kind, request);
        out.clear();
        out.extend((0..request.rays.len()).map(|i| hits.get(i).map_or(f32::INFINITY, |hit| hit.t)));
    }

    /// The cones of rays that a shader requests: with its width, and a pixel's spread.
    fn cones_of(&self, request: &RayRequest) -> Cones {
        let mut cones = Cones::default();
        for (i, &key) in request.key.iter().enumerate() {
            let width = request.width.get(i).copied().unwrap_or(0.0);
            let kind = request.kinds.get(i).copied().unwrap_or(RayKind::Reflection);
            cones.push(self.cone.of_sample(self.pixel_order.sample(key)).beginning(width).sent_by(kind));
        }
        cones
    }

    /// The first hits of rays of a kind.
    pub(crate) fn hits_of(&mut self, kind: RayMask, request: &RayRequest, out: &mut Vec<Option<SurfaceHit>>) {
        self.stats.secondary_rays += request.rays.len() as u64;
        let RayRequest { rays, key: keys, .. } = request;
        let hits = &closest_hits(self, kind, request);
        out.clear();
        out.resize(rays.len(), None);
        let cones = Some(&self.cones_of(request));
        let from = HitLanes { rays, keys, hits, cones, depth: 1 };
        self.for_each_surface(from, AttributeRequests::Sides, |tracer, shader, lanes, points| {
            let mut albedo = Vec3s::splat(lanes.len(), MID_GREY);
            shader.albedo(points, &mut albedo);
            for (k, &lane) in lanes.iter().enumerate() {
                let (world, instance) = (tracer.world, points.inst_id[k]);
                out[lane as usize] = Some(SurfaceHit {
                    t: points.t[k],
                    p: points.p.get(k),
                    ng: points.facing_ng(k),
                    ns: points.facing_ns(k),
                    uv: [points.texcoord[0][k], points.texcoord[1][k]],
                    albedo: albedo.get(k),
                    back: !points.front(k),
                    ids: [
                        instance,
                        world.leaf(points.leaf_id[k]).1.0,
                        world.material_of(points.leaf_id[k], points.geom_id[k]),
                        points.prim_id[k],
                    ],
                });
            }
        });
    }
}

impl Tracer for BatchTracer<'_> {
    fn light_count(&self) -> usize {
        self.world.lights().shaders.len() + self.lights.map_or(0, |lights| lights.count(self))
    }

    fn light_is_visible(&self, light: usize) -> bool {
        self.world.lights().shaders.get(light).is_some_and(|light| light.is_visible())
    }

    fn illuminate(&mut self, light: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        out.reset(hits.len());
        if let Some(number) = light.checked_sub(self.world.lights().shaders.len()) {
            if let Some(lights) = self.lights {
                lights.illuminate(self, number, hits, out);
            }
            return;
        }
        let mut normal = Vec3s::default();
        (0..hits.len()).for_each(|i| normal.push(hits.facing_ns(i)));
        let random: Vec<_> =
            hits.key.iter().map(|&key| self.random(key, hits.depth, purpose::LIGHT + light as u32)).collect();
        self.world.lights().shaders[light].illuminate(&hits.p, &normal, &random, out);
        if let Some(log) = &mut self.log {
            log.light(light, out);
        }
    }

    fn illuminate_in(&mut self, category: &str, light: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        match category.is_empty() {
            true => self.illuminate(light, hits, out),
            false => illuminate_in(self, category, light, hits, out),
        }
    }

    fn occluded(&mut self, request: &RayRequest, transmittance: &mut Vec3s) {
        self.passed(request, (None, None), transmittance);
    }

    fn distances(&mut self, request: &RayRequest, out: &mut Vec<f32>) {
        self.distances_of(RayMask::OTHER, request, out);
    }

    fn meet(&mut self, request: &RayRequest, out: &mut Vec<Option<SurfaceHit>>) {
        self.hits_of(RayMask::OTHER, request, out);
    }

    fn trace(&mut self, depth: u32, request: &RayRequest, radiance: &mut Vec3s) {
        radiance.reset(request.rays.len(), Vec3::ZERO);
        if request.rays.is_empty() {
            return;
        }
        let depth = depth + 1;
        if depth > self.options.max_depth {
            let all: Vec<usize> = (0..request.rays.len()).collect();
            *radiance = self.environment(&request.rays, &all, |_| false);
            return;
        }
        let RayRequest { rays, key: keys, .. } = request;
        self.stats.secondary_rays += rays.len() as u64;
        let hits = &closest_hits(self, RayMask::OTHER, request);
        if let Some(log) = &mut self.log {
            log.rays(depth, rays, hits);
        }
        let cones = Some(&self.cones_of(request));
        self.shade(HitLanes { rays, keys, hits, cones, depth }, radiance);
    }

    fn random(&self, key: SampleKey, depth: u32, purpose: u32) -> [f32; 2] {
        sample_pair(self.options.seed, key, depth, purpose)
    }
}
