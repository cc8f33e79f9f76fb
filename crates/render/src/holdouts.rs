// SPDX-License-Identifier: GPL-3.0-or-later
//! Holdouts: instances that leave a hole in the picture. Camera rays that meet one, also through transparent parts, bring
//! nothing and count as not covered; mirrors, shadows and indirect light show it as any other instance.
//! Tests: crates/render/tests/holdouts.rs.

use glam::Vec3;
use gnurt_shading::Vec3s;

use crate::options::Integrator;
use crate::tracer::BatchTracer;
use crate::world::HitLanes;

/// Begins a batch of camera rays: none of them is known to see a hole.
pub(crate) fn begin(tracer: &mut BatchTracer, lanes: usize) {
    tracer.held.clear();
    if !tracer.world.labels().holdouts.is_empty() {
        tracer.held.resize(lanes, false);
    }
}

/// Takes the light of camera rays that see a hole away.
pub(crate) fn hold_out(tracer: &mut BatchTracer, camera: HitLanes, radiance: &mut Vec3s) {
    let holdouts = &tracer.world.labels().holdouts;
    // Paths note them as they pass transparent parts.
    let notes = tracer.options.integrator != Integrator::Path;
    for (lane, held) in tracer.held.iter_mut().enumerate() {
        *held |= notes && camera.hits.get(lane).is_some_and(|hit| holdouts.contains(&hit.inst_id));
        if *held {
            radiance.set(lane, Vec3::ZERO);
        }
    }
    if let Some(ledger) = tracer.wavefront.ledger.as_mut() {
        let lanes = tracer.held.iter().enumerate().filter(|(_, held)| **held);
        lanes.for_each(|(lane, _)| ledger.layers.iter_mut().for_each(|layer| layer.set(lane, Vec3::ZERO)));
    }
}
