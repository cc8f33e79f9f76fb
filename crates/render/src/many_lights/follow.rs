// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays to the next surface that stops them: what only covers a share of the light is passed by chance.
//! Source: original. Space: world. Proof: crates/render/tests/many_lights.rs.

use gnurt_accel::{Coherence, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::SampleKey;
use gnurt_shading::sampling::sample_pair;

use crate::tracer::BatchTracer;
use crate::transport::Vertex;
use crate::world::HitLanes;

/// Purpose of the numbers that decide whether a ray passes; layers follow.
const PASS: u32 = 0x4000;
/// Surfaces that a ray may pass.
const MOST_LAYERS: u32 = 64;

impl BatchTracer<'_> {
    /// The vertex where each ray is stopped; `None` where it leaves the scene.
    pub(crate) fn follow(
        &mut self,
        rays: &RayBatch,
        keys: &[SampleKey],
        depth: u32,
        coherence: Coherence,
    ) -> Vec<Option<Vertex>> {
        self.stats.secondary_rays += rays.len() as u64;
        let hits = self.intersect(RayMask::OTHER, rays, keys, coherence);
        let from = HitLanes { rays, keys, hits: &hits, depth, epsilon: self.options.ray_epsilon };
        let mut vertices = self.vertices(from);
        self.pass_on(&mut vertices, depth);
        vertices
    }

    /// Sends on what only some of the light is stopped by.
    pub(crate) fn pass_on(&mut self, vertices: &mut [Option<Vertex>], depth: u32) {
        for layer in 0..MOST_LAYERS {
            let (mut rays, mut keys, mut lanes) = (RayBatch::default(), Vec::new(), Vec::new());
            for (lane, vertex) in vertices.iter().enumerate() {
                let Some(vertex) = vertex.as_ref().filter(|v| v.scattering.coverage < 1.0) else { continue };
                let [u, _] = sample_pair(self.options.seed, vertex.key, depth, PASS + layer);
                if u >= vertex.scattering.coverage {
                    rays.push(vertex.point.spawn(-vertex.wo, f32::INFINITY));
                    keys.push(vertex.key);
                    lanes.push(lane);
                }
            }
            if rays.is_empty() {
                return;
            }
            self.stats.secondary_rays += rays.len() as u64;
            let hits = self.intersect(RayMask::OTHER, &rays, &keys, Coherence::Incoherent);
            let epsilon = self.options.ray_epsilon;
            let next = self.vertices(HitLanes { rays: &rays, keys: &keys, hits: &hits, depth, epsilon });
            // What was stopped is not asked again.
            vertices.iter_mut().flatten().for_each(|vertex| vertex.scattering.coverage = 1.0);
            for (lane, vertex) in lanes.into_iter().zip(next) {
                vertices[lane] = vertex;
            }
        }
    }
}
