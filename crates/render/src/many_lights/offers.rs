// SPDX-License-Identifier: GPL-3.0-or-later
//! Shadow rays, with the unoccluded light of each. Space: world.
//! Tests: crates/render/tests/{many_lights,panes}.rs.

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_shading::{RayRequest, Tracer, Vec3s};

use super::walk::Walk;
use crate::tracer::BatchTracer;
use crate::transport::panes;
use crate::world::Inside;

/// Shadow rays and their unoccluded light.
#[derive(Default)]
pub(super) struct Offers {
    request: RayRequest,
    offers: Vec<(u32, Vec3)>,
    /// Rays to delta lights that begin outside of absorbing media, and edges up to these lights.
    delta_requests: Vec<(usize, u32)>,
}

impl Offers {
    /// Light of a light, which is searched for through glass if `is_delta`.
    pub(super) fn push_of_light(&mut self, ray: Ray, walk: &Walk, offer: Vec3, is_delta: bool) {
        let before = self.offers.len();
        self.push(ray, walk, offer);
        if is_delta && self.offers.len() > before {
            self.delta_requests.push((before, walk.edges + 1));
        }
    }

    pub(super) fn push(&mut self, ray: Ray, walk: &Walk, offer: Vec3) {
        if offer.is_finite() && offer != Vec3::ZERO {
            self.request.rays.push(ray);
            self.request.key.push(walk.key);
            self.offers.push((walk.lane, offer));
        }
    }

    pub(super) fn append(&mut self, other: &Self) {
        let before = self.offers.len();
        self.delta_requests.extend(other.delta_requests.iter().map(|&(i, edges)| (before + i, edges)));
        other.offers.iter().enumerate().for_each(|(i, &offer)| {
            self.request.rays.push(other.request.rays.get(i));
            self.request.key.push(other.request.key[i]);
            self.offers.push(offer);
        });
    }

    /// Adds the unoccluded light.
    pub(super) fn settle(self, tracer: &mut BatchTracer, radiance: &mut Vec3s) {
        let mut through = Vec3s::default();
        tracer.occluded(&self.request, &mut through);
        let emitters = self.delta_requests.into_iter();
        let emitters = emitters.map(|(ray, edges)| (ray, edges, Inside::default()));
        panes::trace_through(tracer, &self.request, None, emitters, &mut through);
        for (i, (lane, offer)) in self.offers.into_iter().enumerate() {
            radiance.add(lane as usize, offer * through.get(i));
        }
    }
}
