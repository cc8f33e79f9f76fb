// SPDX-License-Identifier: GPL-3.0-or-later
//! Direct light on a surface: samples of every light, shadow rays, and the BSDF as weight.
//! Source: [Whi80] (shadow rays); [CPC84] (lights with extent, by sampling).
//! A light counts only where it is above the horizon, see [`SurfaceBatch::shadow_ray`]. Shadow rays are sent
//! only where the BSDF is not zero.

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{LightBatch, RayRequest, Tracer};

/// Adds to `out` the light of all lights, each weighted by `bsdf_cos(lane, towards the light, light is visible)`: the
/// BSDF times the cosine to the shading normal.
pub fn direct_light(
    tracer: &mut dyn Tracer,
    hits: &SurfaceBatch,
    bsdf_cos: &dyn Fn(usize, Vec3, bool) -> Vec3,
    out: &mut Vec3s,
) {
    let (mut arriving, mut shadows, mut through) =
        (LightBatch::default(), RayRequest::default(), Vec3s::default());
    let mut scattered = Vec::new();
    for light in 0..tracer.light_count() {
        tracer.illuminate(light, hits, &mut arriving);
        let visible = tracer.light_is_visible(light);
        shadows.clear();
        scattered.clear();
        for i in 0..hits.len() {
            let (dir, radiance) = (arriving.dir.get(i), arriving.radiance.get(i));
            if radiance == Vec3::ZERO {
                continue;
            }
            let Some(shadow) = hits.shadow_ray(i, dir, arriving.dist[i]) else { continue };
            let value = bsdf_cos(i, dir, visible) * radiance;
            if value != Vec3::ZERO {
                scattered.push(value);
                shadows.push(shadow, i, hits.key[i]);
            }
        }
        tracer.occluded(&shadows, &mut through);
        for (k, (&parent, &value)) in shadows.parent.iter().zip(&scattered).enumerate() {
            out.add(parent as usize, value * through.get(k));
        }
    }
}
