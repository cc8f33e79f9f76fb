// SPDX-License-Identifier: GPL-3.0-or-later
//! Boxes in double precision. Tests: `tests/far_away.rs`.

use crate::Aabb;

/// A box in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Box64 {
    pub(super) min: [f64; 3],
    pub(super) max: [f64; 3],
}

impl Box64 {
    pub(super) const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    pub(super) fn is_empty(&self) -> bool {
        (0..3).any(|k| self.min[k] > self.max[k])
    }

    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            min: [0, 1, 2].map(|k| self.min[k].min(other.min[k])),
            max: [0, 1, 2].map(|k| self.max[k].max(other.max[k])),
        }
    }

    /// With all coordinates rounded to the nearest floats.
    pub(super) fn nearest(&self) -> Aabb {
        Aabb { min: self.min.map(|x| x as f32), max: self.max.map(|x| x as f32) }
    }

    /// A box of floats around it.
    pub(super) fn rounded(&self) -> Aabb {
        let outward = |x: f64, towards: f32, next: fn(f32) -> f32| {
            let near = x as f32;
            if (f64::from(near) - x) * f64::from(towards) < 0.0 { next(near) } else { near }
        };
        Aabb {
            min: self.min.map(|x| outward(x, -1.0, f32::next_down)),
            max: self.max.map(|x| outward(x, 1.0, f32::next_up)),
        }
    }
}

impl From<Aabb> for Box64 {
    fn from(bounds: Aabb) -> Self {
        Self { min: bounds.min.map(f64::from), max: bounds.max.map(f64::from) }
    }
}
