// SPDX-License-Identifier: GPL-3.0-or-later
//! Discs: where a line goes through one, and the nearest point of one. Space: object. Tests: `tests/discs.rs` of
//! `gnurt-accel`.

use super::Probe;
use super::shapes::{dot, minus};

/// The parameter at which a line goes through a disc: one that faces the line where it has no normal.
#[inline]
pub fn through_disc(
    [org, dir]: [[f64; 3]; 2],
    center: [f32; 3],
    radius: f32,
    normal: Option<[f32; 3]>,
) -> Option<f64> {
    let to = minus(center.map(f64::from), org);
    let normal = normal.map_or(dir, |normal| normal.map(f64::from));
    // Infinite or NaN along the disc.
    let t = dot(to, normal) / dot(dir, normal);
    let off = [0, 1, 2].map(|k| t * dir[k] - to[k]);
    let radius = f64::from(radius);
    (dot(off, off) <= radius * radius).then_some(t)
}

/// The offset from the probe to the nearest point of a disc, where distances count. Of one that faces rays that is its
/// centre: where the disc is depends on the ray. Where the probe's axes stretch space unevenly, it is the nearest in the
/// searched space.
pub fn on_disc(probe: &Probe, center: [f32; 3], radius: f32, normal: Option<[f32; 3]>) -> [f64; 3] {
    let center = center.map(f64::from);
    let Some(normal) = normal.map(|normal| normal.map(f64::from)) else { return probe.offset(center) };
    let from = minus(probe.point, center);
    let height = dot(from, normal) / dot(normal, normal);
    let flat = [0, 1, 2].map(|k| from[k] - height * normal[k]);
    let length = dot(flat, flat).sqrt();
    let share = if length > f64::from(radius) { f64::from(radius) / length } else { 1.0 };
    probe.offset([0, 1, 2].map(|k| center[k] + share * flat[k]))
}
