// SPDX-License-Identifier: GPL-3.0-or-later
//! The choice between the groups of lights of a set: those of the tree, each directional light, the environment.
//! Source: as in the tree [EK18] the choice follows the contribution that each group is estimated to make to the
//! point, unoccluded. Differs: a share of all choices is even, because the brightest group may be occluded; and of the sky only
//! what scattered rays do not find as well counts ([KSV*19] takes that off the densities of the sky's directions).
//! Space: world; estimates are irradiances (fluences where a point requests all sides), by brightness.
//! Invariants: `group_share` is the probability of `choose_group` for the same point and normal; a group whose estimate is
//! 0 brings nothing to the point.
//! Tests: `light_set_tests::{densities_are_those_of_samples, groups_are_chosen_by_contribution}`.

use glam::Vec3;
use gnurt_image::srgb::luminance;

use super::EnvironmentLight;
use super::light_set::LightSet;
use crate::sampling::Choice;
use crate::sampling::distribution::ALMOST_ONE;

/// Share of the choices that is even among the groups which may contribute.
const EVEN: f32 = 0.25;
/// Least cosine to a directional light: shaders may turn their normals towards it.
const LEAST_COSINE: f32 = 1.0 / 16.0;
/// Groups that are sampled one by one where a vertex is worth a ray to each.
const MOST_SPLIT: usize = 4;

/// Skies of less unevenness are not sampled one by one.
const WORTH_A_RAY: f32 = 0.25;

/// Estimates at one point.
struct Estimates {
    near: f32,
    sky: f32,
    sum: f32,
    /// The weight of the sky among those above zero.
    sky_weight: f32,
    /// Sum of the weights of those above zero; each but the sky counts as 1.
    shining: f32,
}

impl Estimates {
    fn share(&self, (estimate, weight): (f32, f32)) -> f32 {
        if estimate > 0.0 { (1.0 - EVEN) * (estimate / self.sum) + EVEN * weight / self.shining } else { 0.0 }
    }
}

impl LightSet {
    /// Number of groups; the first, of lights with a position, may be empty.
    #[must_use]
    pub fn group_count(&self) -> usize {
        1 + self.parts.directionals.len() + usize::from(self.parts.environment.is_some())
    }

    /// The groups that are sampled one by one at vertices which are worth a ray to each; none where there is but one, or many.
    /// A sky that is nearly the same on all sides is not worth one. One group may be left then: its samples would only be
    /// noisier if a few of them were the sky's.
    #[must_use]
    pub fn split_groups(&self) -> std::ops::Range<usize> {
        let is_even = self.parts.environment.as_ref().is_some_and(|sky| sky.unevenness() < WORTH_A_RAY);
        let groups = usize::from(self.near.tree.is_empty())..self.group_count() - usize::from(is_even);
        let least = if is_even { 1 } else { 2 };
        if (least..=MOST_SPLIT).contains(&groups.len()) { groups } else { 0..0 }
    }

    /// Chooses a group by a number in [0, 1); `None` if none contributes.
    pub(super) fn choose_group(&self, p: Vec3, ns: Vec3, u: f32) -> Option<Choice> {
        let count = self.group_count();
        if count == 1 {
            return (!self.near.tree.is_empty()).then_some(Choice { index: 0, probability: 1.0, rest: u });
        }
        let estimates = self.estimates(p, ns);
        let (mut rest, mut last) = (u, None);
        for index in 0..count {
            let share = estimates.share(self.estimate(&estimates, index, ns));
            if share > 0.0 {
                let within = (rest / share).clamp(0.0, ALMOST_ONE);
                last = Some(Choice { index, probability: share, rest: within });
                if rest < share {
                    break;
                }
                rest -= share;
            }
        }
        last
    }

    /// The probability of a group.
    pub(super) fn group_share(&self, index: usize, p: Vec3, ns: Vec3) -> f32 {
        if self.group_count() == 1 {
            return 1.0;
        }
        let estimates = self.estimates(p, ns);
        estimates.share(self.estimate(&estimates, index, ns))
    }

    fn estimates(&self, p: Vec3, ns: Vec3) -> Estimates {
        let near = self.near.tree.contribution(p, ns, |light| self.contribution(light, p, ns));
        let sky = self.parts.environment.as_ref().map_or(0.0, |environment| environment.irradiance(ns));
        let sky_weight = self.parts.environment.as_ref().map_or(0.0, EnvironmentLight::unevenness);
        let mut estimates = Estimates { near, sky: sky * sky_weight, sky_weight, sum: 0.0, shining: 0.0 };
        for index in 0..self.group_count() {
            let (estimate, weight) = self.estimate(&estimates, index, ns);
            estimates.sum += estimate;
            estimates.shining += if estimate > 0.0 { weight } else { 0.0 };
        }
        estimates
    }

    /// The light of a group, and its weight in even choices.
    fn estimate(&self, estimates: &Estimates, index: usize, ns: Vec3) -> (f32, f32) {
        if index == 0 {
            return (estimates.near, 1.0);
        }
        self.parts.directionals.get(index - 1).map_or((estimates.sky, estimates.sky_weight), |light| {
            let cos = if ns == Vec3::ZERO { 1.0 } else { ns.dot(light.towards).max(LEAST_COSINE) };
            (luminance(light.irradiance.into()) * cos, 1.0)
        })
    }
}
