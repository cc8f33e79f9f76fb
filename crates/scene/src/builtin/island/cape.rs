// SPDX-License-Identifier: GPL-3.0-or-later
//! The cape under the lighthouse. Space: world, sea level at y = 0. Tests: `tests/builtin.rs`.

use super::super::noise::{rolling, smoothstep};

/// Position of the lighthouse.
pub(super) const POSITION: [f32; 2] = [2.75, 2.35];
/// Height of the rock under it.
pub(super) const CAPE: f32 = 0.34;

/// Raises a cape with a flat top under the lighthouse.
pub(super) fn shape_ground(x: f32, z: f32, h: f32) -> f32 {
    let (dx, dz) = (x - POSITION[0], z - POSITION[1]);
    let distance = (dx * dx + dz * dz).sqrt();
    let wobble = 0.1 * rolling(2.2 * x, 2.2 * z, 4, 131);
    let cape = smoothstep(1.05, 0.42, distance + wobble);
    h + (CAPE - h) * cape
}

/// Whether trees and rocks would collide with it.
pub(super) fn is_near(x: f32, z: f32) -> bool {
    (x - POSITION[0]).hypot(z - POSITION[1]) < 0.62
}
