// SPDX-License-Identifier: GPL-3.0-or-later
//! Up to 64 rays from one point, in the form in which kernels take them: what a virtual light's shadow rays are.
//! Source: original; [RSH05] for why rays of one origin go well together: their interval of origins is a point.
//! Space: that of the structure that is asked.
//! Invariant: the answer for a ray is that of the same ray alone. Proof: `tests/pencils.rs`.

/// Up to 64 rays from one point, with near ends of zero, which see everything.
///
/// A lane whose far end is below zero holds no ray. Lanes that lie side by side should hold rays that do.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Pencil {
    /// Directions, any length but zero: x, y and z arrays.
    pub dir: [[f32; Self::MOST]; 3],
    /// Far ends; below zero = no ray.
    pub t_far: [f32; Self::MOST],
    /// Where all rays start.
    pub org: [f32; 3],
}

impl Pencil {
    /// Rays that fit.
    pub const MOST: usize = crate::tile::TILE;

    /// No rays.
    pub const EMPTY: Self = Self { dir: [[0.0; Self::MOST]; 3], t_far: [-1.0; Self::MOST], org: [0.0; 3] };
}

impl Default for Pencil {
    fn default() -> Self {
        Self::EMPTY
    }
}
