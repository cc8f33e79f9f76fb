// SPDX-License-Identifier: GPL-3.0-or-later
//! Shading normals, facing the viewer, as colours: 0.5 + 0.5 n. Misses are black.

use glam::Vec3;
use gnurt_shading::Vec3s;

use crate::tracer::{AttributeRequests, BatchTracer};
use crate::world::HitLanes;

pub(super) fn radiance(tracer: &mut BatchTracer, camera: HitLanes, radiance: &mut Vec3s) {
    radiance.reset(camera.rays.len(), Vec3::ZERO);
    tracer.for_each_surface(camera, AttributeRequests::Sides, |_, _, lanes, points| {
        for (k, &lane) in lanes.iter().enumerate() {
            radiance.set(lane as usize, Vec3::splat(0.5) + 0.5 * points.facing_ns(k));
        }
    });
}
