// SPDX-License-Identifier: GPL-3.0-or-later
//! The unit sphere as the unit square, by an octahedron: only arithmetic that rounds alike on all computers.
//! Source: [MSS*10] (octahedral normal vectors); the ratio of areas follows from the distance of its faces.
//! Tests: `tests::octahedron_*`.

use glam::{Vec2, Vec3};

/// The point of the square, in [0, 1], for a unit direction.
pub(super) fn square_of(dir: Vec3) -> Vec2 {
    let p = dir / dir.abs().element_sum();
    let (x, y) = if p.z < 0.0 {
        ((1.0 - p.y.abs()) * 1.0_f32.copysign(p.x), (1.0 - p.x.abs()) * 1.0_f32.copysign(p.y))
    } else {
        (p.x, p.y)
    };
    (Vec2::new(x, y) * 0.5 + 0.5).clamp(Vec2::ZERO, Vec2::ONE)
}

/// The unit direction for a point of the square.
pub(super) fn direction_of(square: Vec2) -> Vec3 {
    let Vec2 { x, y } = square * 2.0 - 1.0;
    let z = 1.0 - x.abs() - y.abs();
    let (x, y) = if z < 0.0 {
        ((1.0 - y.abs()) * 1.0_f32.copysign(x), (1.0 - x.abs()) * 1.0_f32.copysign(y))
    } else {
        (x, y)
    };
    Vec3::new(x, y, z).normalize_or(Vec3::Z)
}

/// Solid angle over area of the square at a unit direction.
pub(super) fn stretch(dir: Vec3) -> f32 {
    // The point of the octahedron is `dir / sum`, its distance 1 / sum; faces are sqrt(1/3) away.
    let sum = dir.abs().element_sum();
    4.0 * sum * sum * sum
}
