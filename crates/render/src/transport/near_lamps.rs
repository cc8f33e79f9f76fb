// SPDX-License-Identifier: GPL-3.0-or-later
//! Places in media where light of near lamps is sampled, in addition to the ends of flights.
//! Source: [KF12] (equiangular sampling), [VG95] (both combined by the power heuristic). For each edge one lamp is drawn first.
//! A flight that ends at a place has the density f there, and the lamp's angles e: light samples there count f^2 / (f^2 + e^2)
//! and e^2 / (f^2 + e^2). The farther the lamp is, the less often the second is drawn, by which e is less. Directions of the phase
//! function keep their weights, since only ends of flights have them.
//! Space: world. Tests: crates/render/tests/media.rs.

use glam::Vec3;
use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{hash_combine, purpose, sample_pair};

use super::equiangular::Equiangular;
use super::flight::{Parts, Random};
use super::medium_vertices::{MediumVertex, MediumVertices};
use super::mis::power_heuristic;
use super::paths::Path;
use crate::options::RenderOptions;
use crate::world::World;

/// Lamps nearer than this share of the scale of the density along the ray are sampled each time.
const ALWAYS: f32 = 0.25;
/// The lamps' branch of a key.
const BRANCH: u32 = 0x6c61_6d70;

/// The distances along an edge by the angles of a lamp.
pub(super) struct NearLamp<'a> {
    angles: Equiangular,
    /// The probability that a place is drawn.
    chance: f32,
    throughput: Vec3,
    random: Random,
    seed: u64,
    path: &'a Path,
}

impl<'a> NearLamp<'a> {
    /// That of a path's edge up to `length`; `None` if no lamp is near.
    pub(super) fn of(
        (world, options): (&World, &RenderOptions),
        parts: &Parts,
        path: &'a Path,
        (org, dir, length): (Vec3, Vec3, f32),
    ) -> Option<Self> {
        let (lights, throughput) = (world.light_set(), path.throughput);
        if !lights.has_near()
            || path.edges >= options.max_depth
            || throughput == Vec3::ZERO
            || !throughput.is_finite()
        {
            return None;
        }
        let span = parts.scattering_span(length)?;
        let mut random = Random::of_lamp(options.seed, path.key, path.edges);
        let mut numbers = || random.next();
        let (u, choice) = (numbers(), [numbers(), numbers(), numbers()]);
        let (reach, mean) = (span[1] - span[0], parts.mean_distance());
        // Lamps are chosen as from a place on the ray: as flights end, or evenly.
        let away = match mean.is_finite() {
            true => -mean * (1.0 - u * (1.0 - (-reach / mean).exp())).ln(),
            false => reach * u,
        };
        let from = org + dir * (span[0] + away.min(reach));
        let lamp = lights.near_place(from, choice)?;
        let angles = Equiangular::new((org, dir), lamp, span)?;
        // Light of farther lamps changes less along the ray than density does.
        let scale = mean.min(reach);
        let closeness = ALWAYS * scale / angles.closest(span);
        let chance = (closeness * closeness).min(1.0);
        let is_near = angles.closest(span) < scale;
        is_near.then_some(Self { angles, chance, throughput, random, seed: options.seed, path })
    }

    /// The share of light samples at the end of a flight.
    pub(super) fn share_of_flight(&self, parts: &Parts, t: f32) -> f32 {
        power_heuristic(parts.density(t, self.throughput), self.chance * self.angles.density(t))
    }

    /// Adds a place near the lamp for a light sample.
    pub(super) fn add(
        &mut self,
        world: &World,
        parts: &Parts,
        (number, org, dir): (u32, Vec3, Vec3),
        vertices: &mut MediumVertices,
    ) {
        if self.random.next() >= self.chance {
            return;
        }
        let key = self.path.key;
        let [u, _] = sample_pair(self.seed, key, self.path.edges, purpose::LAMP_DISTANCE);
        let t = self.angles.sample(u);
        let density = self.chance * self.angles.density(t);
        let share = power_heuristic(density, parts.density(t, self.throughput));
        if !(t.is_finite() && t >= 0.0 && share > 0.0) {
            return;
        }
        let Some((weight, medium)) = parts.goes_to(t, self.throughput, &mut self.random) else { return };
        let key = SampleKey { branch: hash_combine(key.branch, BRANCH), ..key };
        let (phase, throughput) = (world.media().get(medium).phase, weight / density);
        let p = org + dir * t;
        vertices.push((number, key), &MediumVertex { p, along: dir, phase, throughput, share });
    }
}
