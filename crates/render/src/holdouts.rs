// SPDX-License-Identifier: GPL-3.0-or-later
//! Holdouts: instances and surfaces that leave a hole in the picture. Camera rays that meet such an instance, also through
//! transparent parts, bring nothing and count as not covered. Surfaces whose closures hold out count as not covered in
//! that share, and their other closures bring their light. Mirrors, shadows and indirect light show both as they are.
//! Tests: crates/render/tests/holdouts.rs.

use glam::Vec3;
use gnurt_shading::Vec3s;

use crate::behind::Behind;
use crate::held::Held;
use crate::options::Integrator;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::world::HitLanes;

/// Begins a batch of camera rays: none of them is known to see a hole.
pub(crate) fn begin(tracer: &mut BatchTracer, lanes: usize) {
    tracer.held.clear();
    let world = tracer.world;
    if !world.labels().holdouts.is_empty() || world.materials().have_holes() {
        tracer.held.resize(lanes, Held::default());
    }
}

/// Takes the light of camera rays that see a hole away.
pub(crate) fn hold_out(tracer: &mut BatchTracer, camera: HitLanes, radiance: &mut Vec3s) {
    if tracer.held.is_empty() {
        return;
    }
    // Paths note them as they pass transparent parts.
    if tracer.options.integrator != Integrator::Path {
        note_first_hits(tracer, camera);
    }
    // These show no closures.
    let is_drawing = matches!(tracer.options.integrator, Integrator::Normals | Integrator::Eyelight);
    for (lane, held) in tracer.held.iter().enumerate() {
        if held.is_dark {
            radiance.set(lane, Vec3::ZERO);
            if let Some(behind) = tracer.behind.get_mut(lane) {
                *behind = Behind::default();
            }
        } else if is_drawing && held.share > 0.0 {
            radiance.set(lane, radiance.get(lane) * (1.0 - held.share));
        }
    }
    if let Some(ledger) = tracer.wavefront.ledger.as_mut() {
        let lanes = tracer.held.iter().enumerate().filter(|(_, held)| held.is_dark);
        lanes.for_each(|(lane, _)| ledger.layers.iter_mut().for_each(|layer| layer.set(lane, Vec3::ZERO)));
    }
}

/// Notes the holes at the first hits of camera rays.
fn note_first_hits(tracer: &mut BatchTracer, camera: HitLanes) {
    let mut held = std::mem::take(&mut tracer.held);
    if tracer.world.materials().have_holes() {
        let mut closures = std::mem::take(&mut tracer.closures);
        tracer.for_each_surface(camera, AttributeRequests::Light, |tracer, shader, lanes, points| {
            if shader.has_holes() {
                closures.reset(points.len());
                shader.evaluate_traced(tracer, points, &mut closures);
                for (k, &lane) in lanes.iter().enumerate() {
                    held[lane as usize] = Held { share: closures.held_out(k), is_dark: false };
                }
            }
        });
        tracer.closures = closures;
    }
    let holdouts = &tracer.world.labels().holdouts;
    for (lane, held) in held.iter_mut().enumerate() {
        if camera.hits.get(lane).is_some_and(|hit| holdouts.contains(&hit.inst_id)) {
            *held = Held::ALL;
        }
    }
    tracer.held = held;
}
