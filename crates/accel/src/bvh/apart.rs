// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays of a tile that have nothing in common but are prepared together, sixteen at a time.
//! Source: the arithmetic of [`NodeRay::new`] and [`BlockRay::new`] in lanes, with the same bits.
//! Proof: `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x16, mask32x16, prelude::*};

use super::blocks::BlockRay;
use super::planes::TilePlanes;
use super::slab::NodeRay;
use crate::tile::{Headings, LANES, PerRay, RayTile, TILE};
use crate::triangle::{Sheared, axes_from};

/// Rays prepared for nodes and blocks. Those of irregular length are not.
#[repr(C, align(64))]
pub(super) struct Apart {
    planes: TilePlanes,
    /// Along the axes of each ray's own sheared space.
    sheared: Sheared<PerRay>,
    pub(super) ways: Headings,
}

impl Apart {
    /// Prepares the first `count` rays, which go these `ways`, for a tree whose greatest coordinate is `reach`.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, rays: &RayTile, ways: Headings, count: usize, reach: f32) -> Self {
        let zero = [[0.0; TILE]; 3];
        let sheared = Sheared { org: zero, shear: zero };
        let mut apart = Self { planes: TilePlanes::EMPTY, sheared, ways };
        apart.planes.prepare(simd, rays, count, reach);
        for at in (0..count).step_by(LANES) {
            simd.part(
                #[inline(always)]
                || apart.shear(simd, rays, at),
            );
        }
        apart
    }

    #[inline(always)]
    fn shear<S: Simd>(&mut self, simd: S, rays: &RayTile, at: usize) {
        let dir = rays.dir_lanes(simd, [0, 1, 2], at);
        let [x, y, z] = [dir[0].abs(), dir[1].abs(), dir[2].abs()];
        let along = [x.simd_ge(y) & x.simd_ge(z), y.simd_ge(z)];
        let org = turned(rays.org_lanes(simd, [0, 1, 2], at), along);
        let [x, y, z] = turned(dir, along);
        for (k, over) in [x / z, y / z, f32x16::splat(simd, 1.0) / z].into_iter().enumerate() {
            org[k].store_slice(&mut self.sheared.org[k][at..at + LANES]);
            over.store_slice(&mut self.sheared.shear[k][at..at + LANES]);
        }
    }

    /// Ray `i` for nodes, whose nearer planes are in `rows`.
    #[inline(always)]
    pub(super) fn for_nodes<S: Simd>(&self, simd: S, i: usize, rows: [usize; 3], t_near: f32) -> NodeRay<S> {
        self.planes.alone(simd, i % TILE, rows, t_near)
    }

    /// Ray `i` for blocks.
    #[inline(always)]
    pub(super) fn for_blocks<S: Simd>(&self, simd: S, i: usize, t_near: f32) -> BlockRay<S> {
        let i = i % TILE;
        let Sheared { org: [x, y, z], shear: [a, b, c] } = &self.sheared;
        let sheared = Sheared { org: [x[i], y[i], z[i]], shear: [a[i], b[i], c[i]] };
        BlockRay::sheared(simd, axes_from(self.ways.of(i).longest_axis), sheared, t_near)
    }
}

/// Along the axes of the sheared space: what is along axis `k + 1` in cyclic order of rays that go along x, and so on.
#[inline(always)]
fn turned<S: Simd>([x, y, z]: [f32x16<S>; 3], [along_x, along_y]: [mask32x16<S>; 2]) -> [f32x16<S>; 3] {
    [
        along_x.select(y, along_y.select(z, x)),
        along_x.select(z, along_y.select(x, y)),
        along_x.select(x, along_y.select(y, z)),
    ]
}
