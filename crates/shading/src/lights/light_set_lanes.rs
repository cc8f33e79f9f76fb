// SPDX-License-Identifier: GPL-3.0-or-later
//! Light samples for sixteen points at once. Source: as `light_set`.
//! Invariant: the samples of [`LightSet::sample`](super::LightSet::sample), bit for bit.
//! Tests: `light_set_tests::lanes_choose_as_points_do`.

use glam::Vec3;
use gnurt_simd::{Simd, f32x16, prelude::*};

use super::light_lanes::LightSampleX16;
use super::light_parts::is_sound;
use super::light_set::LightSet;
use crate::lanes::{Floats, LanesOf, Mask, Vec3x16};

impl LightSet {
    /// [`sample_among`](Self::sample_among) for the lanes in `active`; those in `from_all_sides` request all sides, for
    /// any normals.
    #[inline(always)]
    #[must_use]
    pub fn sample_x16<S: Simd>(
        &self,
        group: Option<usize>,
        [active, from_all_sides]: [Mask<S>; 2],
        [p, ns]: [Vec3x16<S>; 2],
        u: [Floats<S>; 3],
    ) -> LightSampleX16<S> {
        let [facing, around] = [active & !from_all_sides, active & from_all_sides];
        // Each kind at one place: copies of the walk are large.
        let mut of_all_sides = None;
        if around.any_true() {
            of_all_sides = Some(self.sample_lanes(group, around, (p, None), u));
        }
        match of_all_sides {
            Some(around) if !facing.any_true() => around,
            around => {
                let found = self.sample_lanes(group, facing, (p, Some(ns)), u);
                around.map_or(found, |around| found.or(facing, around))
            }
        }
    }

    /// The same for lanes that face their unit normals, or that request all sides.
    #[inline(always)]
    fn sample_lanes<S: Simd>(
        &self,
        group: Option<usize>,
        active: Mask<S>,
        (p, ns): (Vec3x16<S>, Option<Vec3x16<S>>),
        u: [Floats<S>; 3],
    ) -> LightSampleX16<S> {
        let simd = u[0].token();
        let normal = |i: usize| ns.map_or(Vec3::ZERO, |ns| ns.get(i));
        let (mut rest, mut lane_probability) = (u[0], f32x16::splat(simd, 1.0));
        let mut others = LightSampleX16::none(f32x16::splat(simd, 0.0));
        let lanes = match &self.near.lanes {
            Some(lanes) if group.is_none_or(|group| group == 0) => lanes,
            _ => {
                for i in LanesOf(active.to_bitmask()) {
                    let u = [u[0][i], u[1][i], u[2][i]];
                    others.put(i, self.sample_among(group, p.get(i), normal(i), u));
                }
                return others;
            }
        };
        // Lanes that chose the tree; one group is chosen without taking anything of the number.
        let mut near = active;
        if group.is_none() && self.group_count() > 1 {
            let mut bits = 0;
            for i in LanesOf(active.to_bitmask()) {
                let Some(group) = self.choose_group(p.get(i), normal(i), u[0][i]) else { continue };
                if group.index == 0 {
                    bits |= 1 << i;
                    (rest[i], lane_probability[i]) = (group.rest, group.probability);
                } else {
                    let uv = [u[1][i], u[2][i]];
                    let sample = self.sample_far(group.index - 1, normal(i), uv, group.probability);
                    others.put(i, sample.filter(is_sound));
                }
            }
            near = Mask::from_bitmask(simd, bits);
        }
        lanes.sample(&self.parts, near, (p, ns), [rest, u[1], u[2]], lane_probability).or(near, others)
    }
}
