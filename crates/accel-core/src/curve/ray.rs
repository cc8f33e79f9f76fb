// SPDX-License-Identifier: GPL-3.0-or-later
//! A ray as tests of curves take it, and its hits. Tests: `tests/curves.rs` of `gnurt-accel`.

use super::{Vector, dot, scaled};

/// A hit of a ray with a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveHit {
    pub t: f64,
    pub u: f64,
    pub v: f64,
}

/// Takes hits, and answers whether those behind a hit on the same curve count, too.
pub type Offer<'a> = &'a mut dyn FnMut(CurveHit) -> bool;

/// A ray, and axes across it.
#[derive(Clone, Copy, Debug)]
pub struct RayFrame {
    pub org: Vector,
    pub dir: Vector,
    /// Two across, and the direction, all of length 1.
    pub axes: [Vector; 3],
    /// That of the direction.
    pub length: f64,
}

impl RayFrame {
    /// That of a ray whose direction is not zero.
    #[inline]
    pub fn new(org: Vector, dir: Vector) -> Self {
        let length = dot(dir, dir).sqrt();
        let [x, y, z] = scaled(dir, 1.0 / length);
        // Without a branch at any direction: [DBC*17].
        let sign = 1.0f64.copysign(z);
        let (a, b) = (-1.0 / (sign + z), -x * y / (sign + z));
        let first = [1.0 + sign * x * x * a, sign * b, -sign * x];
        let second = [b, sign + y * y * a, -y];
        Self { org, dir, axes: [first, second, [x, y, z]], length }
    }

    /// A vector by the axes.
    #[inline(always)]
    pub(super) fn by_axes(&self, v: Vector) -> Vector {
        [dot(self.axes[0], v), dot(self.axes[1], v), dot(self.axes[2], v)]
    }
}
