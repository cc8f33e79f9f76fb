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

    /// The rays from `at` on, all of one heading.
    #[inline(always)]
    pub(crate) fn chunk<S: Simd>(
        &self,
        simd: S,
        heading: Heading,
        rays: &RayTile,
        nearest: &NearestTile,
        at: usize,
    ) -> ChunkPlanes<S> {
        let of = |[x, y, z]: &[PerRay; 3]| [chunk(simd, x, at), chunk(simd, y, at), chunk(simd, z, at)];
        ChunkPlanes {
            inv: of(&self.inv),
            near: of(&self.near),
            far: of(&self.far),
            enter: chunk(simd, &rays.t_near, at),
            leave: chunk(simd, &nearest.t, at),
            rows: heading.rows(),
        }
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

/// Sixteen rays of one heading, prepared for planes.
pub(crate) struct ChunkPlanes<S: Simd> {
    inv: [f32x16<S>; 3],
    near: [f32x16<S>; 3],
    far: [f32x16<S>; 3],
    enter: f32x16<S>,
    leave: f32x16<S>,
    rows: [usize; 3],
}

impl<S: Simd> ChunkPlanes<S> {
    /// Which of them meet the box at `place` before their ends.
    #[inline(always)]
    pub(crate) fn meet(&self, simd: S, node: &Node8, place: usize) -> u64 {
        let plane = |row: usize| f32x16::splat(simd, node.rows[row & 7][place & 7]);
        let [x, y, z] = self.rows;
        let near = |k: usize, row: usize| plane(row).mul_sub(self.inv[k], self.near[k]);
        let far = |k: usize, row: usize| plane(row ^ 1).mul_sub(self.inv[k], self.far[k]);
        let enter = near(0, x).max(near(1, y)).max(near(2, z).max(self.enter));
        let leave = far(0, x).min(far(1, y)).min(far(2, z).min(self.leave));
        enter.simd_le(leave).to_bitmask()
    }
}
