// SPDX-License-Identifier: GPL-3.0-or-later
//! Light of even media that flights pass: where a flight goes through, a collision is forced for a light sample.
//! Source: [SG69]. A flight is scattered with the probability q; its end then counts q for light samples,
//! and so does the place that is drawn where it is not: each flight brings one light sample, and that chance makes no noise.
//! Space: world. Tests: crates/render/tests/media.rs.

use glam::Vec3;
use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{hash_combine, purpose};

use super::flight::{Parts, Random, channel_by};
use super::medium_vertices::{MediumVertex, MediumVertices};
use super::near_lamps::NearLamps;
use super::paths::Path;
use crate::world::World;

/// The branch of the places' keys.
const BRANCH: u32 = 0x7061_7373;

/// Flights along one edge, if they are scattered.
pub(super) struct ForcedCollision {
    /// Of the one even medium along it.
    extinction: Vec3,
    /// By channel, the light of the path and the part of it that is scattered.
    shares: Vec3,
    scattered: Vec3,
}

impl ForcedCollision {
    /// Those of a path's edge of a finite length, in one even medium.
    pub(super) fn of(parts: &Parts, path: &Path, length: f32) -> Option<Self> {
        let extinction = parts.even_extinction(length)?;
        let shares = path.throughput / path.throughput.element_sum();
        // Exact where media are thin, too.
        let scattered = Vec3::from((extinction * length).to_array().map(|depth| -(-depth).exp_m1()));
        let is_sound = length.is_finite() && shares.is_finite() && shares.dot(scattered) > 0.0;
        is_sound.then_some(Self { extinction, shares, scattered })
    }

    /// The probability that a flight is scattered.
    pub(super) fn chance(&self) -> f32 {
        self.shares.dot(self.scattered)
    }

    /// A distance, by two numbers in [0, 1).
    fn sample(&self, [choice, u]: [f32; 2]) -> f32 {
        let channel = channel_by(self.shares * self.scattered, choice);
        -(-u * self.scattered[channel]).ln_1p() / self.extinction[channel]
    }

    /// Adds the place of a flight that was not scattered, for a light sample.
    pub(super) fn add(
        &self,
        (world, edge): (&World, &Random),
        (parts, near): (&Parts, Option<&NearLamps>),
        (path, number, org, dir): (&Path, u32, Vec3, Vec3),
        vertices: &mut MediumVertices,
    ) {
        let t = self.sample(edge.pair_of(purpose::FORCED_DISTANCE));
        let density = parts.density(t, path.throughput) / self.chance();
        let Some((weight, medium)) = parts.goes_to(t, path.throughput, &mut edge.beside(BRANCH)) else {
            return;
        };
        if !(density > 0.0 && density.is_finite()) {
            return;
        }
        let key = SampleKey { branch: hash_combine(path.key.branch, BRANCH), ..path.key };
        let (phase, throughput) = (world.media().get(medium).phase, weight / density);
        let share = near.map_or(1.0, |near| near.share_of_flight(density, t));
        vertices
            .push((number, key), &MediumVertex { p: org + dir * t, along: dir, phase, throughput, share });
    }
}
