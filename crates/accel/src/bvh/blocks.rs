// SPDX-License-Identifier: GPL-3.0-or-later
//! Leaves of triangles: blocks of eight, corner by corner and axis by axis in lanes.
//! Source: original; the test is [WBW13]. Space: object.
//! Invariant: lanes that are left over repeat the block's first triangle, which changes no answer.
//! Proof: `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x8, f32x16, mask32x8, prelude::*};

use super::WIDTH;
use crate::geometry::Screened;
use crate::triangle::{LanesMeeting, Sheared, axes_from, meet_lanes};
use crate::{INVALID_ID, Ray};

/// Eight triangles.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct TriangleBlock {
    /// By corner, then by axis.
    pub(crate) corners: [[[f32; WIDTH]; 3]; 3],
    /// Numbers in the object.
    pub(crate) numbers: [u32; WIDTH],
}

/// One ray prepared for blocks.
#[derive(Clone, Copy)]
pub(crate) struct BlockRay<S: Simd> {
    axes: [usize; 3],
    sheared: Sheared<f32x8<S>>,
    t_near: f32x8<S>,
    all: mask32x8<S>,
}

impl<S: Simd> BlockRay<S> {
    /// `ray` must be sound and of regular length.
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray) -> Self {
        let at = |value: f32| f32x8::splat(simd, value);
        let axes = axes_from(ray.longest_axis());
        let [x, y, z] = axes;
        let along = ray.dir[z];
        let sheared = Sheared {
            org: [at(ray.org[x]), at(ray.org[y]), at(ray.org[z])],
            shear: [at(ray.dir[x] / along), at(ray.dir[y] / along), at(1.0 / along)],
        };
        Self { axes, sheared, t_near: at(ray.t_near), all: mask32x8::splat(simd, true) }
    }
}

impl TriangleBlock {
    /// From numbers of triangles; `INVALID_ID` where there is none, which is not so for the first.
    pub(crate) fn new(screened: &Screened, numbers: &[u32; WIDTH]) -> Self {
        let mut block = Self { corners: [[[0.0; WIDTH]; 3]; 3], numbers: *numbers };
        for lane in 0..WIDTH {
            if block.numbers[lane] == INVALID_ID {
                block.numbers[lane] = block.numbers[0];
            }
            let corners = screened.corners(block.numbers[lane]);
            for (corner, position) in corners.iter().enumerate() {
                for (axis, &x) in position.iter().enumerate() {
                    block.corners[corner][axis][lane] = x;
                }
            }
        }
        block
    }

    /// Where `ray` meets them up to `t_far`.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(&self, simd: S, ray: &BlockRay<S>, t_far: f32) -> LanesMeeting<S, f32x8<S>> {
        let [x, y, z] = ray.axes;
        let [a, b, c] = &self.corners;
        let corners = [
            [row(simd, &a[x]), row(simd, &a[y]), row(simd, &a[z])],
            [row(simd, &b[x]), row(simd, &b[y]), row(simd, &b[z])],
            [row(simd, &c[x]), row(simd, &c[y]), row(simd, &c[z])],
        ];
        meet_lanes(simd, corners, &ray.sheared, ray.all, ray.t_near, f32x8::splat(simd, t_far))
    }

    /// Boxes of the triangles along one axis: least and greatest coordinates.
    #[inline(always)]
    pub(crate) fn extent<S: Simd>(&self, simd: S, axis: usize) -> [f32x8<S>; 2] {
        let [a, b, c] = &self.corners;
        let (a, b, c) = (row(simd, &a[axis]), row(simd, &b[axis]), row(simd, &c[axis]));
        [a.min(b).min(c), a.max(b).max(c)]
    }

    /// One corner of one triangle along three axes, in all lanes.
    #[inline(always)]
    pub(crate) fn corner<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        corner: usize,
        axes: [usize; 3],
    ) -> [f32x16<S>; 3] {
        let [x, y, z] = axes;
        let corner = &self.corners[corner];
        [
            f32x16::splat(simd, corner[x][lane & 7]),
            f32x16::splat(simd, corner[y][lane & 7]),
            f32x16::splat(simd, corner[z][lane & 7]),
        ]
    }
}

#[inline(always)]
fn row<S: Simd>(simd: S, values: &[f32; WIDTH]) -> f32x8<S> {
    f32x8::from_slice(simd, values)
}
