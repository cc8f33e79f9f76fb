// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile's rays prepared for planes: sixteen of them against one box, or one of them against eight.
//! Source: as `node_ray.rs`, in lanes of rays. Proof: `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x16, prelude::*};

use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::heading::Heading;
use gnurt_accel_core::slab::Slabs;
use gnurt_accel_core::tile::{LANES, NearestTile, PerRay, RayTile, chunk};

use crate::node::Node8;
use crate::node_ray::NodeRay;

/// [`Slabs`] of each ray.
#[repr(C, align(64))]
pub(crate) struct TilePlanes {
    inv: [PerRay; 3],
    near: [PerRay; 3],
    far: [PerRay; 3],
}

impl TilePlanes {
    pub(crate) const EMPTY: Self =
        Self { inv: [[0.0; TILE]; 3], near: [[0.0; TILE]; 3], far: [[0.0; TILE]; 3] };

    /// Prepares the first `count` rays.
    #[inline(always)]
    pub(crate) fn prepare<S: Simd>(&mut self, simd: S, rays: &RayTile, count: usize, greatest: f32) {
        for at in (0..count).step_by(LANES) {
            self.prepare_chunk(simd, rays, greatest, at);
        }
    }

    #[inline(always)]
    fn prepare_chunk<S: Simd>(&mut self, simd: S, rays: &RayTile, greatest: f32, at: usize) {
        let dir = rays.dir_lanes(simd, [0, 1, 2], at);
        let org = rays.org_lanes(simd, [0, 1, 2], at);
        let slabs = Slabs::new(org, dir, greatest, |x| f32x16::splat(simd, x));
        for k in 0..3 {
            slabs.inv[k].store_slice(&mut self.inv[k][at..at + LANES]);
            slabs.near[k].store_slice(&mut self.near[k][at..at + LANES]);
            slabs.far[k].store_slice(&mut self.far[k][at..at + LANES]);
        }
    }

    /// Which of the rays from `at` on, all of one heading, meet the box at `place` before their ends.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(
        &self,
        simd: S,
        (node, place): (&Node8, usize),
        heading: Heading,
        rays: &RayTile,
        nearest: &NearestTile,
        at: usize,
    ) -> u64 {
        let mut enter = chunk(simd, &rays.t_near, at);
        let mut leave = chunk(simd, &nearest.t, at);
        for k in 0..3 {
            let row = 2 * k + usize::from(heading.backwards[k]);
            let inv = chunk(simd, &self.inv[k], at);
            let near = f32x16::splat(simd, node.rows[row & 7][place & 7]);
            let far = f32x16::splat(simd, node.rows[(row ^ 1) & 7][place & 7]);
            enter = enter.max(near.mul_sub(inv, chunk(simd, &self.near[k], at)));
            leave = leave.min(far.mul_sub(inv, chunk(simd, &self.far[k], at)));
        }
        enter.simd_le(leave).to_bitmask()
    }

    /// Ray `i` by itself, whose nearer planes are in `rows`.
    #[inline(always)]
    pub(crate) fn alone<S: Simd>(&self, simd: S, i: usize, rows: [usize; 3], t_near: f32) -> NodeRay<S> {
        let i = i % TILE;
        let at = |[x, y, z]: &[PerRay; 3]| [x[i], y[i], z[i]];
        let slabs = Slabs { inv: at(&self.inv), near: at(&self.near), far: at(&self.far) };
        NodeRay::of_slabs(simd, &slabs, rows, t_near)
    }
}
