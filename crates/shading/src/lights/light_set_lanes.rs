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
        if !around.any_true() {
            return self.sample_lanes(group, facing, (p, Some(ns)), u);
        }
        let of_all_sides = self.sample_lanes(group, around, (p, None), u);
        if !facing.any_true() {
            return of_all_sides;
        }
        self.sample_lanes(group, facing, (p, Some(ns)), u).or(facing, of_all_sides)
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
        match &self.near.lanes {
            // One group: its choice takes nothing of the number.
            Some(lanes) if self.group_count() == 1 || group == Some(0) => {
                lanes.sample(&self.parts, active, (p, ns), u, f32x16::splat(simd, 1.0))
            }
            Some(lanes) if group.is_none() => {
                let (mut rest, mut lane_probability, mut near, mut far) =
                    (u[0], u[0], 0, LightSampleX16::none(f32x16::splat(simd, 0.0)));
                for i in LanesOf(active.to_bitmask()) {
                    let Some(group) = self.choose_group(p.get(i), normal(i), u[0][i]) else { continue };
                    if group.index == 0 {
                        near |= 1 << i;
                        (rest[i], lane_probability[i]) = (group.rest, group.probability);
                    } else {
                        let uv = [u[1][i], u[2][i]];
                        let sample = self.sample_far(group.index - 1, normal(i), uv, group.probability);
                        far.put(i, sample.filter(is_sound));
                    }
                }
                let near = Mask::from_bitmask(simd, near);
                lanes.sample(&self.parts, near, (p, ns), [rest, u[1], u[2]], lane_probability).or(near, far)
            }
            _ => {
                let mut out = LightSampleX16::none(f32x16::splat(simd, 0.0));
                for i in LanesOf(active.to_bitmask()) {
                    out.put(i, self.sample_among(group, p.get(i), normal(i), [u[0][i], u[1][i], u[2][i]]));
                }
                out
            }
        }
    }
}
