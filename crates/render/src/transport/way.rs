// SPDX-License-Identifier: GPL-3.0-or-later
//! What lies between two points: surfaces that are there in part, and media. Shadow rays and connections ask
//! for their transmittance.
//! Source: [NSJ14] (ratio tracking), [SKTM11] (local majorants); Beer's law where density is even. Space: world.
//! Invariants: media are passed by expectation, so transmittance is unbiased; without media the result is
//! a product of surfaces, and no random number is drawn. A limit of layers: `opacity::MOST_LAYERS`.
//! Tests: crates/render/tests/{media,path,many_lights}.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::{RayRequest, Vec3s};

use super::flight::Parts;
use super::links::Blockers;
use super::opacity;
use super::through::Through;
use crate::cone::Cones;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::world::{HitLanes, Inside};

impl BatchTracer<'_> {
    /// Multiplies the transmittances of the media along rays that no surface blocks.
    pub(crate) fn pass_media(&mut self, request: &RayRequest, through: Through, transmittance: &mut Vec3s) {
        let (mut parts, seed) = (Parts::default(), self.options.seed);
        for (i, &key) in request.key.iter().enumerate() {
            let left = transmittance.get(i);
            if left == Vec3::ZERO {
                continue;
            }
            let ray = request.rays.get(i);
            let way = (Vec3::from(ray.org), Vec3::from(ray.dir), ray.t_far);
            let begin = (through.inside[i], through.edges[i]);
            transmittance.set(i, left * through.left(&mut parts, begin, way, (seed, key, 0)));
        }
    }

    /// Steps from surface to surface and multiplies their transmittances, and those of media between them,
    /// until no light or no distance remains. `scatters`: only holes let light through. Some instances may not stop
    /// some rays.
    pub(crate) fn pass_layers(
        &mut self,
        request: &RayRequest,
        scatters: bool,
        (through, blockers): (Option<Through>, Option<Blockers>),
        transmittance: &mut Vec3s,
    ) {
        let no_width = Cones::default();
        let (mut rays, mut keys) = (request.rays.clone(), request.key.clone());
        // Which ray of the request each lane still serves.
        let mut serves: Vec<u32> = (0..rays.len() as u32).collect();
        let mut inside: Vec<Inside> = through.map_or_else(Vec::new, |through| through.inside.to_vec());
        let (mut parts, seed) = (Parts::default(), self.options.seed);
        for layer in 0.. {
            let hits = self.intersect(RayMask::SHADOW, &rays, &keys, Coherence::Coherent);
            if let Some(through) = through {
                for (lane, &ray) in serves.iter().enumerate() {
                    let (ray, segment) = (ray as usize, rays.get(lane));
                    let length = if hits.get(lane).is_some() { hits.t[lane] } else { segment.t_far };
                    let way = (Vec3::from(segment.org), Vec3::from(segment.dir), length);
                    let begin = (inside[ray], through.edges[ray]);
                    let left = through.left(&mut parts, begin, way, (seed, keys[lane], layer));
                    transmittance.set(ray, transmittance.get(ray) * left);
                }
            }
            // Opacity textures are read without filtering.
            let cones = Some(&no_width);
            let from = HitLanes { rays: &rays, keys: &keys, hits: &hits, cones, depth: 0 };
            let (mut next_rays, mut next_keys, mut next_serves) =
                (RayBatch::default(), Vec::new(), Vec::new());
            self.for_each_surface(from, AttributeRequests::Light, |tracer, shader, lanes, points| {
                let mut left = Vec3s::splat(lanes.len(), Vec3::ZERO);
                if layer >= opacity::MOST_LAYERS {
                } else if scatters {
                    if !shader.is_solid() {
                        shader.gaps(tracer, points, &mut left);
                    }
                } else if !shader.is_opaque() {
                    shader.transmit(tracer, points, &mut left);
                }
                let bounds = through.map_or(0, |through| through.media.of_points(tracer.world, points));
                for (k, &lane) in lanes.iter().enumerate() {
                    let ray = serves[lane as usize] as usize;
                    let stops = |Blockers { links, sets }| links.stops(sets[ray], points.inst_id[k]);
                    if !blockers.is_none_or(stops) && layer < opacity::MOST_LAYERS {
                        left.set(k, Vec3::ONE);
                    }
                    transmittance.set(ray, transmittance.get(ray) * left.get(k));
                    if transmittance.get(ray) != Vec3::ZERO {
                        if bounds != 0 {
                            inside[ray] = inside[ray].crossing(bounds, points.front(k));
                        }
                        let onward = points.spawn(k, points.ray_dir.get(k), f32::INFINITY);
                        next_rays.push(opacity::rest(&rays.get(lane as usize), onward));
                        next_keys.push(keys[lane as usize]);
                        next_serves.push(ray as u32);
                    }
                }
            });
            (rays, keys, serves) = (next_rays, next_keys, next_serves);
            if rays.is_empty() {
                return;
            }
        }
    }
}
