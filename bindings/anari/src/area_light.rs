// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights with an extent: the radiance that leaves a place on them in a direction.
//! Source: ANARI 1.1, KHR_LIGHT_{POINT, QUAD, RING}. Space: world. Tests: tests/lights.rs.

use glam::Vec3;

/// Sides that shine; the front is where the geometric normal points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Front,
    Back,
    Both,
}

/// Factors by direction.
#[derive(Clone, Debug)]
pub(crate) struct Distribution {
    /// Rows by the angle around the axis, each by the angle to it from 0 to 180 degrees.
    pub(crate) values: Vec<f32>,
    /// Values in a row.
    pub(crate) width: usize,
    /// Where the first row lies, perpendicular to the axis.
    pub(crate) first: Vec3,
}

/// A light with an extent.
#[derive(Clone, Debug)]
pub(crate) struct AreaLight {
    pub(crate) radiance: Vec3,
    pub(crate) side: Side,
    /// Unit axis of the cone and of the distribution.
    pub(crate) axis: Vec3,
    /// Half angles at which the cone ends and at which it has full radiance.
    pub(crate) cone: Option<[f32; 2]>,
    pub(crate) distribution: Option<Distribution>,
}

impl AreaLight {
    /// Radiance that leaves to `out` where the unit geometric normal is `normal`.
    pub(crate) fn radiance(&self, normal: Vec3, out: Vec3) -> Vec3 {
        let cos = normal.dot(out);
        let shines = match self.side {
            Side::Front => cos > 0.0,
            Side::Back => cos < 0.0,
            Side::Both => cos != 0.0,
        };
        if !shines {
            return Vec3::ZERO;
        }
        let angle = self.axis.dot(out).clamp(-1.0, 1.0).acos();
        let within = self.cone.map_or(1.0, |[outer, inner]| falloff(angle, outer, inner));
        let share = self.distribution.as_ref().map_or(1.0, |by| by.value(self.axis, out, angle));
        self.radiance * (within * share)
    }
}

/// 1 within the inner angle, 0 beyond the outer one, smooth between.
fn falloff(angle: f32, outer: f32, inner: f32) -> f32 {
    if angle <= inner {
        return 1.0;
    }
    let share = ((outer - angle) / (outer - inner)).clamp(0.0, 1.0);
    if share.is_finite() { share * share * (3.0 - 2.0 * share) } else { 0.0 }
}

impl Distribution {
    fn value(&self, axis: Vec3, out: Vec3, angle: f32) -> f32 {
        let (width, rows) = (self.width, self.values.len() / self.width.max(1));
        if width == 0 || rows == 0 {
            return 1.0;
        }
        let row = |row: usize| {
            let position = angle / std::f32::consts::PI * (width - 1) as f32;
            let first = (position as usize).min(width - 1);
            let next = (first + 1).min(width - 1);
            let [a, b] = [first, next].map(|k| self.values[row * width + k]);
            a + (b - a) * (position - first as f32)
        };
        if rows == 1 {
            return row(0).max(0.0);
        }
        let second = axis.cross(self.first);
        let turn = out.dot(second).atan2(out.dot(self.first)) / std::f32::consts::TAU;
        let position = turn.rem_euclid(1.0) * rows as f32;
        let first = position as usize % rows;
        let (a, b) = (row(first), row((first + 1) % rows));
        (a + (b - a) * position.fract()).max(0.0)
    }
}
