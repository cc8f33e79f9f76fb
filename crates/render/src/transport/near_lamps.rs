// SPDX-License-Identifier: GPL-3.0-or-later
//! Places in media where light of near lamps is sampled, in addition to the ends of flights.
//! Source: [KF12] (equiangular sampling), [VG95] (both combined by the power heuristic). For each edge some lamps are drawn
//! first. A flight that ends at a place has the density f there, and the mean of the lamps' angles e: light samples there count
//! f^2 / (f^2 + e^2) and e^2 / (f^2 + e^2). The farther a lamp is, the less often its place is drawn, by which e is less.
//! Directions of the phase function keep their weights, since only ends of flights have them.
//! Space: world. Tests: crates/render/tests/media.rs.

use glam::Vec3;
use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{hash_combine, purpose};

use super::equiangular::Equiangular;
use super::flight::{Parts, Random};
use super::medium_vertices::{MediumVertex, MediumVertices};
use super::mis::power_heuristic;
use super::paths::Path;
use crate::options::RenderOptions;
use crate::world::World;

/// Lamps nearer than this share of the scale of the density along the ray are sampled each time.
const ALWAYS: f32 = 0.5;
/// The lamps' branch of a key.
const BRANCH: u32 = 0x6c61_6d70;
/// Lamps that are drawn for an edge, one of them for its place. With one alone flights near the others kept their whole weight.
const LAMPS: usize = 3;
/// Edges of a path that have so many; later ones, whose noise is seen less, have one.
const FIRST_EDGES: u32 = 2;

/// The distances along an edge by the angles of lamps.
pub(super) struct NearLamps<'a> {
    /// Each with the probability that a place is drawn by it.
    lamps: [Option<(Equiangular, f32)>; LAMPS],
    throughput: Vec3,
    random: Random,
    /// Numbers for a place.
    place: [f32; 2],
    path: &'a Path,
}

impl<'a> NearLamps<'a> {
    /// Those of a path's edge up to `length`; `None` if no lamp is near.
    pub(super) fn of(
        (world, options): (&World, &RenderOptions),
        (parts, edge): (&Parts, &Random),
        path: &'a Path,
        (org, dir, length): (Vec3, Vec3, f32),
    ) -> Option<Self> {
        let (lights, throughput) = (world.light_set(), path.throughput);
        if lights.near_count() == 0
            || path.edges >= options.max_depth
            || throughput == Vec3::ZERO
            || !throughput.is_finite()
        {
            return None;
        }
        let span = parts.scattering_span(length)?;
        let mut random = edge.beside(BRANCH);
        let mut numbers = || random.next();
        let (reach, mean) = (span[1] - span[0], parts.mean_distance());
        // Light of farther lamps changes less along the ray than density does.
        let scale = mean.min(reach);
        let count = if path.edges <= FIRST_EDGES { LAMPS.min(lights.near_count()) } else { 1 };
        let lamp = |u: f32, choice: [f32; 3]| {
            // Chosen as from a place on the ray: as flights end, or evenly.
            let away = match mean.is_finite() {
                true => -mean * (1.0 - u * (1.0 - (-reach / mean).exp())).ln(),
                false => reach * u,
            };
            let from = org + dir * (span[0] + away.min(reach));
            let angles = Equiangular::new((org, dir), lights.near_place(from, choice)?, span, scale)?;
            let closeness = ALWAYS * scale / angles.closest(span);
            Some((angles, (closeness * closeness).min(1.0) / count as f32))
        };
        let [u, choice] = [numbers(), numbers()];
        let mut lamps = [None; LAMPS];
        for (k, drawn) in lamps.iter_mut().enumerate().take(count) {
            // Both numbers in parts of their own, the second in another order.
            let part = |first: f32, k: usize| ((k as f32 + first) / count as f32).min(1.0_f32.next_down());
            *drawn = lamp(part(u, k), [part(choice, (k + 1) % count), numbers(), numbers()]);
        }
        let is_near = lamps.iter().any(Option::is_some);
        is_near.then_some(Self {
            lamps,
            throughput,
            random,
            place: edge.pair_of(purpose::LAMP_DISTANCE),
            path,
        })
    }

    /// The density of places at `t`.
    fn density(&self, t: f32) -> f32 {
        self.lamps.iter().flatten().map(|(angles, chance)| chance * angles.density(t)).sum()
    }

    /// The share of light samples at the end of a flight of this density.
    pub(super) fn share_of_flight(&self, density: f32, t: f32) -> f32 {
        power_heuristic(density, self.density(t))
    }

    /// Adds a place near a lamp for a light sample; `scattered` is the chance that counts for flights that are.
    pub(super) fn add(
        &mut self,
        world: &World,
        (parts, scattered): (&Parts, f32),
        (number, org, dir): (u32, Vec3, Vec3),
        vertices: &mut MediumVertices,
    ) {
        let key = self.path.key;
        let [u, choice] = self.place;
        let mut rest = choice;
        let Some((angles, _)) = self.lamps.iter().flatten().find(|(_, chance)| {
            rest -= chance;
            rest < 0.0
        }) else {
            return;
        };
        let t = angles.sample(u);
        let density = self.density(t);
        let share = power_heuristic(density, parts.density(t, self.throughput) / scattered);
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
