// SPDX-License-Identifier: GPL-3.0-or-later
//! How radiance is computed against a batch of camera rays: one integrator, one file. Source: see each.

mod eyelight;
mod normals;
mod path;
mod whitted;

use gnurt_shading::Vec3s;

use crate::many_lights::{self, PassLights};
use crate::options::Integrator;
use crate::tracer::BatchTracer;
use crate::world::HitLanes;

/// Writes the radiance against each camera ray; `pass` holds the virtual lights of the sample, if the integrator has any.
pub(crate) fn radiance(
    integrator: Integrator,
    tracer: &mut BatchTracer,
    pass: Option<&PassLights>,
    camera: HitLanes,
    radiance: &mut Vec3s,
) {
    tracer.behind.clear();
    match integrator {
        Integrator::Eyelight => eyelight::radiance(tracer, camera, radiance),
        Integrator::Normals => normals::radiance(tracer, camera, radiance),
        Integrator::InstantRadiosity
        | Integrator::BidirectionalInstantRadiosity
        | Integrator::MetropolisInstantRadiosity => {
            if let Some(pass) = pass {
                many_lights::radiance(tracer, pass, camera, radiance);
            } else {
                radiance.reset(camera.rays.len(), glam::Vec3::ZERO);
            }
        }
        // A pilot has chosen, unless there was none.
        Integrator::Path | Integrator::Auto => path::radiance(tracer, camera, radiance),
        Integrator::Whitted => whitted::radiance(tracer, camera, radiance),
    }
}
