// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays towards light, and what each brings unless something is in between. Source: original. Space: world.
//! Proof: crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_shading::{RayRequest, Tracer, Vec3s};

use super::walk::Walk;
use crate::tracer::BatchTracer;

/// Rays towards light and what they bring if nothing is in between.
#[derive(Default)]
pub(super) struct Offers {
    request: RayRequest,
    offers: Vec<(u32, Vec3)>,
}

impl Offers {
    pub(super) fn push(&mut self, ray: Ray, walk: &Walk, offer: Vec3) {
        if offer.is_finite() && offer != Vec3::ZERO {
            self.request.rays.push(ray);
            self.request.key.push(walk.key);
            self.offers.push((walk.lane, offer));
        }
    }

    pub(super) fn append(&mut self, other: &Self) {
        other.offers.iter().enumerate().for_each(|(i, &offer)| {
            self.request.rays.push(other.request.rays.get(i));
            self.request.key.push(other.request.key[i]);
            self.offers.push(offer);
        });
    }

    /// Adds what arrives.
    pub(super) fn settle(self, tracer: &mut BatchTracer, radiance: &mut Vec3s) {
        let mut through = Vec3s::default();
        tracer.occluded(&self.request, &mut through);
        for (i, (lane, offer)) in self.offers.into_iter().enumerate() {
            radiance.add(lane as usize, offer * through.get(i));
        }
    }
}
