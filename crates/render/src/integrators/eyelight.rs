// SPDX-License-Identifier: GPL-3.0-or-later
//! Base colours lit from the eye: the cosine between ray and shading normal. Shows geometry without any
//! light. Misses are black.

use glam::Vec3;
use gnurt_shading::Vec3s;

use crate::tracer::{AttributeRequests, BatchTracer, MID_GREY};
use crate::world::HitLanes;

pub(super) fn radiance(tracer: &mut BatchTracer, camera: HitLanes, radiance: &mut Vec3s) {
    radiance.reset(camera.rays.len(), Vec3::ZERO);
    let mut albedo = Vec3s::default();
    tracer.for_each_surface(camera, AttributeRequests::Sides, |_, shader, lanes, points| {
        albedo.reset(lanes.len(), MID_GREY);
        shader.albedo(points, &mut albedo);
        for (k, &lane) in lanes.iter().enumerate() {
            let cos = points.ns.get(k).dot(points.ray_dir.get(k)).abs();
            radiance.set(lane as usize, albedo.get(k) * cos);
        }
    });
}
