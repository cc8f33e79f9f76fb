// SPDX-License-Identifier: GPL-3.0-or-later
//! Up to 64 rays from one point, in the form of the kernels: the shadow rays of a virtual light. [RSH05]
//! explains why rays of one origin are efficient together: their interval of origins is a point.
//! Space: that of the queried structure.
//! Invariant: the result of a ray is that of the same ray by itself. Tests: `tests/pencils.rs`.

use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::tile::{PerRay, RayTile};

/// Up to 64 rays from one point, with near ends of zero, which see everything.
///
/// A lane whose far end is below zero holds no ray. Lanes that lie side by side should hold rays that do.
#[derive(Clone, Debug)]
pub struct Pencil {
    /// Where all rays start.
    pub org: [f32; 3],
    /// Its directions are those of the rays, the rest is filled in when they are traced.
    pub(crate) rays: RayTile,
    pub(crate) t_far: PerRay,
}

impl Pencil {
    /// Rays that fit.
    pub const MOST: usize = TILE;

    /// No rays.
    pub const EMPTY: Self = Self { org: [0.0; 3], rays: RayTile::EMPTY, t_far: [-1.0; TILE] };

    /// Directions, any length but zero, as x, y and z arrays, and far ends.
    #[inline(always)]
    pub fn lanes(&mut self) -> (&mut [[f32; Self::MOST]; 3], &mut [f32; Self::MOST]) {
        (&mut self.rays.dir, &mut self.t_far)
    }

    /// Sets the time of all rays; see [`Ray::time`](crate::Ray::time). It is 0 at first.
    pub fn set_time(&mut self, time: f32) {
        if self.rays.is_timed || time != 0.0 {
            (self.rays.time, self.rays.is_timed) = ([time; TILE], true);
        }
    }

    /// Far ends; below zero = no ray.
    #[inline(always)]
    #[must_use]
    pub fn t_far(&self) -> &[f32; Self::MOST] {
        &self.t_far
    }
}

impl Default for Pencil {
    fn default() -> Self {
        Self::EMPTY
    }
}
