// SPDX-License-Identifier: GPL-3.0-or-later
//! Smooth surfaces that a scattered ray has met since a point that searched for lamps behind such, and the weight of a lamp at
//! their end: searches find it, too.
//! Source: [VG95] (balance heuristic). Differs: weights take searches to arrive always, because the chance to arrive is known by
//! counts only; as both ways use the same weights, the mean stays. Space: world. Tests: crates/render/tests/caustics.rs.

use glam::{Vec2, Vec3};
use gnurt_shading::SurfacePoint;
use gnurt_shading::lights::{LightId, LightSet};

use super::differential::Differential;
use super::known::Caustics;
use super::smooth::SmoothPoint;
use super::trace::MOST;

/// How much searches that arrive count against scattered rays: their light is one over a count.
const ARRIVES: f32 = 0.5;

/// Where no pilot told: the chance of a search by how often the path was scattered before, per unit of its throughput.
const CHANCES: [f32; 3] = [1.0, 0.25, 0.125];
const LEAST_CHANCE: f32 = 1.0 / 32.0;

/// Such a ray.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Chain {
    /// How often its path was scattered at rough points that searched.
    scattered: u8,
    /// Surfaces since; `None` = a search would not find where it is.
    smooth: Option<u8>,
    /// Density of its direction at that point over the chance that it searched.
    density: f32,
    /// How it changes with that direction.
    change: Differential,
}

impl Chain {
    /// Scattered at a point that searched by this chance, in a direction of this density per solid angle.
    pub(crate) fn rough(self, density: f32, chance: f32) -> Self {
        let scattered = self.scattered.saturating_add(1);
        Self { scattered, smooth: Some(0), density: density / chance, ..self }
    }

    /// Scattered otherwise.
    pub(crate) fn lost(self) -> Self {
        Self { smooth: None, ..self }
    }

    /// Turned at a smooth point that searches turn at, too; its ray came along `dir` from `org`.
    pub(super) fn turned(self, at: &SmoothPoint, (org, dir): (Vec3, Vec3), is_through: bool) -> Self {
        let Some(count) = self.smooth else { return self };
        let mut change = match count {
            0 => Differential::from_point(dir.any_orthonormal_pair().into()),
            _ => self.change,
        };
        change.transfer((at.point.p - org).length(), dir, at.point.ng);
        match is_through {
            true => change.refract(dir, at.point.ns, at.eta, &at.bend),
            false => change.mirror(dir, at.point.ns, &at.bend),
        }
        Self { smooth: count.checked_add(1), change, ..self }
    }

    /// The chance of a search from the point that it ends at, if its path has this throughput.
    pub(crate) fn chance(&self, caustics: &Caustics, throughput: Vec3, point: &SurfacePoint) -> f32 {
        if let Some(places) = caustics.places() {
            return places.chance((point.p, point.ng), throughput);
        }
        let of_order = CHANCES[usize::from(self.scattered).min(CHANCES.len() - 1)];
        (of_order * throughput.max_element()).clamp(LEAST_CHANCE, 1.0)
    }

    /// The weight of a surface that a scattered ray met, if it is a lamp that searches may find, too. The ray's last edge leads `from`
    /// a point to this one along `dir`.
    pub(crate) fn beside_searches(
        &self,
        (lights, caustics): (&LightSet, &Caustics),
        ids: [u32; 3],
        (from, to, dir): (Vec3, Vec3, Vec3),
    ) -> f32 {
        let Some(shape) = lights.shape(ids, dir) else { return 1.0 };
        let Some(area) = lights.area_across(LightId(shape), to, dir) else { return 1.0 };
        let probability = caustics.probability(shape);
        let dist = (to - from).length();
        if probability > 0.0 { self.weight(dir, dist, (area, probability)) } else { 1.0 }
    }

    /// The weight of light at its end, `dist` on along `dir`; `area`: of the lamp across the ray, `probability`: of its choice
    /// by searches.
    fn weight(&self, dir: Vec3, dist: f32, (area, probability): (f32, f32)) -> f32 {
        if !self.smooth.is_some_and(|count| (1..=MOST).contains(&usize::from(count))) {
            return 1.0;
        }
        let spread = area_of(&self.change, dir, dist).recip();
        let searched = weight(self.density, probability / (area * spread));
        if searched.is_finite() { 1.0 - searched } else { 1.0 }
    }
}

/// Area across the ray along `dir` at this distance, per solid angle of the first direction; for an infinite one the solid angle.
pub(super) fn area_of(change: &Differential, dir: Vec3, dist: f32) -> f32 {
    let (x, y) = dir.any_orthonormal_pair();
    let at = |k: usize| match dist.is_finite() {
        true => change.org[k] + change.dir[k] * dist,
        false => change.dir[k],
    };
    let [a, b] = [0, 1].map(|k| Vec2::new(at(k).dot(x), at(k).dot(y)));
    a.perp_dot(b).abs()
}

/// The weight of searches, by the density of scattered directions and that of searches, both over the chance of the search.
pub(super) fn weight(scattered: f32, searched: f32) -> f32 {
    let searched = searched * ARRIVES;
    searched / (searched + scattered)
}
