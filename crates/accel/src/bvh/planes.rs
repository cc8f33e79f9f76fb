// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile's rays prepared for planes: sixteen of them against one box, or one of them against eight.
//! Source: as `slab.rs`, in lanes of rays. Proof: `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x8, f32x16, prelude::*};

use super::Node8;
use super::slab::{NodeRay, SLACK};
use crate::kd::FLATTEST;
use crate::packet::Heading;
use crate::tile::{LANES, NearestTile, PerRay, RayTile, TILE, chunk};

/// See [`NodeRay`], whose arithmetic this is.
#[repr(C, align(64))]
pub(super) struct TilePlanes {
    inv: [PerRay; 3],
    near: [PerRay; 3],
    far: [PerRay; 3],
}

impl TilePlanes {
    pub(super) const EMPTY: Self =
        Self { inv: [[0.0; TILE]; 3], near: [[0.0; TILE]; 3], far: [[0.0; TILE]; 3] };

    /// Prepares the first `count` rays.
    #[inline(always)]
    pub(super) fn prepare<S: Simd>(&mut self, simd: S, rays: &RayTile, count: usize, reach: f32) {
        for at in (0..count).step_by(LANES) {
            simd.part(
                #[inline(always)]
                || self.prepare_chunk(simd, rays, reach, at),
            );
        }
    }

    #[inline(always)]
    fn prepare_chunk<S: Simd>(&mut self, simd: S, rays: &RayTile, reach: f32, at: usize) {
        let dir = rays.dir_lanes(simd, [0, 1, 2], at);
        let org = rays.org_lanes(simd, [0, 1, 2], at);
        let flattest = dir[0].abs().max(dir[1].abs()).max(dir[2].abs()) * f32x16::splat(simd, FLATTEST);
        let away = org[0].abs().max(org[1].abs()).max(org[2].abs());
        let slack = f32x16::splat(simd, SLACK) * (f32x16::splat(simd, 2.0 * reach) + away);
        for k in 0..3 {
            let inv = f32x16::splat(simd, 1.0) / dir[k].abs().max(flattest).copysign(dir[k]);
            let (pad, met) = (slack * inv.abs(), org[k] * inv);
            inv.store_slice(&mut self.inv[k][at..at + LANES]);
            (met + pad).store_slice(&mut self.near[k][at..at + LANES]);
            (met - pad).store_slice(&mut self.far[k][at..at + LANES]);
        }
    }

    /// Which of the rays from `at` on meet the box at `place` before their ends.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "a box and sixteen rays")]
    pub(super) fn meet<S: Simd>(
        &self,
        simd: S,
        node: &Node8,
        place: usize,
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
    pub(super) fn alone<S: Simd>(&self, simd: S, i: usize, rows: [usize; 3], t_near: f32) -> NodeRay<S> {
        let at = |values: &[PerRay; 3]| {
            [
                f32x8::splat(simd, values[0][i]),
                f32x8::splat(simd, values[1][i]),
                f32x8::splat(simd, values[2][i]),
            ]
        };
        NodeRay::from_parts([at(&self.inv), at(&self.near), at(&self.far)], rows, f32x8::splat(simd, t_near))
    }
}
