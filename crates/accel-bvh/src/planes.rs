// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile's rays prepared for planes: sixteen of them against one box, or one of them against eight.
//! Source: as `node_ray.rs`, in lanes of rays. Tests: `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x16, prelude::*};

use gnurt_accel_core::Aabb;
use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::slab::Slabs;
use gnurt_accel_core::tile::{LANES, NearestTile, PerRay, RayTile, chunk};
use gnurt_accel_core::traversal::TileTraversal;

use crate::node::Node8;
use crate::node_ray::NodeRay;
use crate::treelet::NodesAtKeys;

/// A member of a treelet that moves: where its box is at keys.
pub(crate) struct MovingMember<'a> {
    pub(crate) keys: &'a NodesAtKeys,
    /// The block, counted with the nodes, and the slot in it.
    pub(crate) block: usize,
    pub(crate) lane: usize,
}

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

    /// The first `count` rays, relative to `origin`, for a tree whose greatest coordinate is `greatest`.
    #[inline(always)]
    pub(crate) fn of<S: Simd>(
        simd: S,
        rays: &RayTile,
        count: usize,
        origin: [f32; 3],
        greatest: f32,
    ) -> Self {
        let mut planes = Self::EMPTY;
        for at in (0..count).step_by(LANES) {
            planes.prepare_chunk(simd, rays, origin, greatest, at);
        }
        planes
    }

    /// Prepares the first `count` rays.
    #[inline(always)]
    pub(crate) fn prepare<S: Simd>(&mut self, simd: S, rays: &RayTile, count: usize, greatest: f32) {
        for at in (0..count).step_by(LANES) {
            self.prepare_chunk(simd, rays, [0.0; 3], greatest, at);
        }
    }

    #[inline(always)]
    fn prepare_chunk<S: Simd>(
        &mut self,
        simd: S,
        rays: &RayTile,
        origin: [f32; 3],
        greatest: f32,
        at: usize,
    ) {
        let dir = rays.dir_lanes(simd, [0, 1, 2], at);
        let [x, y, z] = rays.org_lanes(simd, [0, 1, 2], at);
        let from = origin.map(|x| f32x16::splat(simd, x));
        let org = [x - from[0], y - from[1], z - from[2]];
        let slabs = Slabs::new(org, dir, greatest, |x| f32x16::splat(simd, x));
        for k in 0..3 {
            slabs.inv[k].store_slice(&mut self.inv[k][at..at + LANES]);
            slabs.near[k].store_slice(&mut self.near[k][at..at + LANES]);
            slabs.far[k].store_slice(&mut self.far[k][at..at + LANES]);
        }
    }

    /// The rays from `at` on, all of one direction class.
    #[inline(always)]
    pub(crate) fn chunk<S: Simd>(
        &self,
        simd: S,
        direction_class: DirectionClass,
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
            rows: direction_class.rows(),
        }
    }

    /// The same for a moving box, each ray at its time.
    #[inline(always)]
    pub(crate) fn meet_moving<S: Simd>(
        &self,
        simd: S,
        &MovingMember { keys, block, lane }: &MovingMember,
        direction_class: DirectionClass,
        rays: &RayTile,
        nearest: &NearestTile,
        at: usize,
    ) -> u64 {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let time = chunk(simd, &rays.time, at);
        // NaN is not above zero.
        let time = time.simd_gt(zero).select(time.min(one), zero) * f32x16::splat(simd, keys.pieces() as f32);
        let mut bits = 0;
        for key in 0..keys.pieces() {
            let b = time - f32x16::splat(simd, key as f32);
            let is_here = b.simd_ge(zero) & b.simd_le(one);
            if keys.pieces() > 1 && !is_here.any_true() {
                continue;
            }
            let a = one - b;
            let (from, to) = (&keys.nodes(key)[block].rows, &keys.nodes(key + 1)[block].rows);
            let plane = |row: usize| {
                let [from, to] = [from, to].map(|rows| f32x16::splat(simd, rows[row & 7][lane & 7]));
                a * from + b * to
            };
            let mut enter = chunk(simd, &rays.t_near, at);
            let mut leave = chunk(simd, &nearest.t, at);
            for k in 0..3 {
                let row = 2 * k + usize::from(direction_class.backwards[k]);
                let inv = chunk(simd, &self.inv[k], at);
                enter = enter.max(plane(row).mul_sub(inv, chunk(simd, &self.near[k], at)));
                leave = leave.min(plane(row ^ 1).mul_sub(inv, chunk(simd, &self.far[k], at)));
            }
            bits |= (enter.simd_le(leave) & is_here).to_bitmask();
        }
        bits
    }

    /// Which of the rays from `at` on, whatever their directions, meet a box before their ends.
    #[inline(always)]
    pub(crate) fn meet_box<S: Simd>(
        &self,
        simd: S,
        traversal: &TileTraversal,
        bounds: &Aabb,
        at: usize,
    ) -> u64 {
        let mut enter = chunk(simd, &traversal.rays.t_near, at);
        let mut leave = chunk(simd, &traversal.nearest.t, at);
        for k in 0..3 {
            let inv = chunk(simd, &self.inv[k], at);
            let (low, high) = (f32x16::splat(simd, bounds.min[k]), f32x16::splat(simd, bounds.max[k]));
            let backwards = inv.is_sign_negative();
            let (near, far) = (backwards.select(high, low), backwards.select(low, high));
            enter = enter.max(near.mul_sub(inv, chunk(simd, &self.near[k], at)));
            leave = leave.min(far.mul_sub(inv, chunk(simd, &self.far[k], at)));
        }
        enter.simd_le(leave).to_bitmask()
    }

    /// Ray `i` by itself, whose nearer planes are in `rows`.
    #[inline(always)]
    pub(crate) fn single_rays<S: Simd>(
        &self,
        simd: S,
        i: usize,
        rows: [usize; 3],
        t_near: f32,
    ) -> NodeRay<S> {
        let i = i % TILE;
        let at = |[x, y, z]: &[PerRay; 3]| [x[i], y[i], z[i]];
        let slabs = Slabs { inv: at(&self.inv), near: at(&self.near), far: at(&self.far) };
        NodeRay::of_slabs(simd, &slabs, rows, t_near)
    }
}

/// Sixteen rays of one direction class, prepared for planes.
pub(crate) struct ChunkPlanes<S: Simd> {
    inv: [f32x16<S>; 3],
    near: [f32x16<S>; 3],
    far: [f32x16<S>; 3],
    enter: f32x16<S>,
    leave: f32x16<S>,
    rows: [usize; 3],
}

impl<S: Simd> ChunkPlanes<S> {
    /// Which of them meet the box at `child` before their ends.
    #[inline(always)]
    pub(crate) fn meet(&self, simd: S, node: &Node8, child: usize) -> u64 {
        let plane = |row: usize| f32x16::splat(simd, node.rows[row & 7][child & 7]);
        let [x, y, z] = self.rows;
        let near = |k: usize, row: usize| plane(row).mul_sub(self.inv[k], self.near[k]);
        let far = |k: usize, row: usize| plane(row ^ 1).mul_sub(self.inv[k], self.far[k]);
        let enter = near(0, x).max(near(1, y)).max(near(2, z).max(self.enter));
        let leave = far(0, x).min(far(1, y)).min(far(2, z).min(self.leave));
        enter.simd_le(leave).to_bitmask()
    }
}
