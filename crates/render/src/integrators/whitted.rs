// SPDX-License-Identifier: GPL-3.0-or-later
//! Whitted's integrator: emission seen directly, direct light once scattered, recursion through mirrors and glass.
//! Source: [Whi80]; lights with extent by sampling [CPC84]. All work happens in the shaders, which query the
//! tracer.

use gnurt_shading::Vec3s;

use crate::tracer::BatchTracer;
use crate::world::HitLanes;

pub(super) fn radiance(tracer: &mut BatchTracer, camera: HitLanes, radiance: &mut Vec3s) {
    tracer.shade(camera, radiance);
}
