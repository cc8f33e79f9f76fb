// SPDX-License-Identifier: GPL-3.0-or-later
//! A vertex's queries of lights: the side, the shadow ray; and lights that only have `illuminate`.
//! Source: [PJH23] sections 12.6 (a point that light may reach from both sides asks without a normal) and 13.2. Space: world.
//! Invariant: a direction counts for light samples exactly where a scattered ray may take it: the side is that of the BSDF's
//! normal, as for `BsdfSample::transmitted`, and the horizon is that of `SurfacePoint::scatter_ray`.
//! Tests: crates/render/tests/agreement.rs.

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_shading::bsdf::Bsdf;
use gnurt_shading::sampling::{purpose, sample_pair};
use gnurt_shading::{LightBatch, SampleKey, SurfacePoint, Vec3s};

use crate::world::World;

/// The normal for light samples: zero, for all sides, if the surface may transmit light.
pub(crate) fn sampling_normal(point: &SurfacePoint, bsdf: &Bsdf) -> Vec3 {
    if bsdf.is_translucent() { Vec3::ZERO } else { point.ns }
}

/// The ray that decides whether light from the unit direction `dir`, `dist` away, reaches the point; `None` where it does not
/// count.
pub(crate) fn shadow_ray(point: &SurfacePoint, bsdf: &Bsdf, dir: Vec3, dist: f32) -> Option<Ray> {
    point.shadow_ray(dir, dist, bsdf.is_transmitted(dir))
}

/// A vertex that queries lights of shader plugins.
pub(crate) struct LightQuery<'a> {
    pub(crate) point: &'a SurfacePoint,
    pub(crate) bsdf: &'a Bsdf,
    pub(crate) key: SampleKey,
    pub(crate) edges: u32,
}

/// A light sample from a light of a shader plugin.
pub(crate) struct Offer {
    /// Unit, towards the light.
    pub(crate) dir: Vec3,
    pub(crate) dist: f32,
    /// As `LightBatch::radiance`.
    pub(crate) arriving: Vec3,
}

/// Calls `with(number of the vertex, offer)` for the light of all lights that only have `illuminate`. The
/// query has one normal, so transmitting vertices make two queries, once for each side, and use from each
/// answer the light on that side.
pub(crate) fn query_plugin_lights(
    world: &World,
    seed: u64,
    queries: &[LightQuery],
    mut with: impl FnMut(usize, Offer),
) {
    let lights = world.lights();
    if lights.plugins.is_empty() || queries.is_empty() {
        return;
    }
    let (mut p, mut normal) = (Vec3s::default(), Vec3s::default());
    let mut lane = |number: usize, side: f32| {
        p.push(queries[number].point.p);
        normal.push(queries[number].point.ns * side);
        number
    };
    let mut lanes: Vec<usize> = (0..queries.len()).map(|number| lane(number, 1.0)).collect();
    let behind = (0..queries.len()).filter(|&number| queries[number].bsdf.is_translucent());
    lanes.extend(behind.map(|number| lane(number, -1.0)));
    let mut arriving = LightBatch::default();
    for light in lights.plugins.clone() {
        let draw = |&number: &usize| {
            let LightQuery { key, edges, .. } = queries[number];
            sample_pair(seed, key, edges, purpose::LIGHT + light as u32)
        };
        let random: Vec<_> = lanes.iter().map(draw).collect();
        arriving.reset(lanes.len());
        lights.shaders[light].illuminate(&p, &normal, &random, &mut arriving);
        for (i, &number) in lanes.iter().enumerate() {
            let offer = Offer {
                dir: arriving.dir.get(i),
                dist: arriving.dist[i],
                arriving: arriving.radiance.get(i),
            };
            let is_of_side = !queries[number].bsdf.is_translucent() || normal.get(i).dot(offer.dir) > 0.0;
            if is_of_side && offer.arriving != Vec3::ZERO {
                with(number, offer);
            }
        }
    }
}
