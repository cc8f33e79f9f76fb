// SPDX-License-Identifier: GPL-3.0-or-later
//! Leaves of triangles: blocks of eight, corner by corner and axis by axis in lanes.
//! The test is [WBW13]. Space: object.
//! Invariant: lanes that are left over repeat the block's first triangle, which changes no answer.
//! Tests: `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x4, f32x8, f32x16, prelude::*};

use crate::collect::Collect;
use crate::hit::INVALID_ID;
use crate::nearest::NOWHERE;
use crate::point::{NearestPoint, Probe, on_triangle};
use crate::ray::Ray;
use crate::triangle::{
    Sheared, ShearedRay, SingleRay, TriangleHit, axes_from, meet_inside, meet_single, pass_edges, relative_to,
};

/// Triangles of a block, and children of a wide BVH's node.
pub const WIDTH: usize = 8;

/// Eight triangles.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// By corner, then by axis.
    pub corners: [[[f32; WIDTH]; 3]; 3],
    /// Numbers in the object.
    pub numbers: [u32; WIDTH],
}

/// One ray prepared for blocks.
#[derive(Clone, Copy)]
pub struct BlockRay<S: Simd> {
    pub(crate) axes: [usize; 3],
    pub(crate) sheared: Sheared<f32x8<S>>,
    /// The direction of the original ray, along the same axes: rarely needed.
    dir: [f32; 3],
    t_near: f32x8<S>,
}

impl<S: Simd> BlockRay<S> {
    /// `ray` must be valid and of regular length.
    #[inline(always)]
    pub fn new(simd: S, ray: &Ray) -> Self {
        Self::along(simd, ray, ray.longest_axis())
    }

    /// The same where the axis is known along which it moves most.
    #[inline(always)]
    pub fn along(simd: S, ray: &Ray, longest_axis: usize) -> Self {
        let axes = axes_from(longest_axis);
        // Not by `map`, which would be a separate call.
        let [x, y, z] = axes;
        let dir = [ray.dir[x], ray.dir[y], ray.dir[z]];
        // As `shear`, in one division.
        let [a, b, c] = dir;
        let shear = f32x4::load_array(simd, [a, b, 1.0, 1.0]) / f32x4::splat(simd, c);
        let shear = [shear[0], shear[1], shear[2]];
        let sheared = Sheared { org: [ray.org[x], ray.org[y], ray.org[z]], shear };
        Self::sheared(simd, axes, SingleRay { sheared, dir }, ray.t_near)
    }

    /// From the data of a ray in the space with these axes.
    #[inline(always)]
    pub fn sheared(simd: S, axes: [usize; 3], single: SingleRay, t_near: f32) -> Self {
        let SingleRay { sheared: Sheared { org: [x, y, z], shear: [sx, sy, sz] }, dir } = single;
        let sheared = Sheared {
            org: [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)],
            shear: [f32x8::splat(simd, sx), f32x8::splat(simd, sy), f32x8::splat(simd, sz)],
        };
        Self { axes, sheared, dir, t_near: f32x8::splat(simd, t_near) }
    }

    /// Offers the hits with one triangle in each of some lanes, by bits: `offer` those that floats decide, `doubt` the others,
    /// by bits as [`TriangleBlock::meet_in_doubt`] has them. Corners are relative to the origin, along this ray's axes.
    #[inline(always)]
    pub(crate) fn meet<C: Collect>(
        &self,
        simd: S,
        corners: [[f32x8<S>; 3]; 3],
        lanes: u64,
        collect: &mut C,
        offer: impl FnOnce(u64, &[[f32; WIDTH]; 3], &mut C),
        doubt: impl FnOnce([u64; 3], &[[f32; WIDTH]; 3], ([usize; 3], SingleRay, f32), &mut C),
    ) {
        let shear = &self.sheared.shear;
        let edges = pass_edges(simd, corners, shear);
        if !edges.inside.any_true() {
            return;
        }
        let reached = edges.reach(shear[2], self.t_near, f32x8::splat(simd, collect.reach()));
        if !reached.lanes.any_true() {
            return;
        }
        let (met, uncertain) = reached.meet(simd);
        let bits = met.hit.to_bitmask() & lanes;
        // Doubtful lanes leave the fast path: if they were removed from `bits` here, each hit would wait for
        // the bound.
        let doubtful = if collect.needs_position() { reached.doubtful(simd, met.t) } else { uncertain };
        if (doubtful | uncertain).any_true() {
            let (doubtful, uncertain) = (doubtful.to_bitmask() & lanes, uncertain.to_bitmask() & lanes);
            let hits = [met.t.to_array(), met.u.to_array(), met.v.to_array()];
            let single = (self.axes, self.single(), self.t_near[0]);
            doubt([bits & !doubtful, doubtful & !uncertain, uncertain], &hits, single, collect);
            return;
        }
        if bits != 0 {
            let hits = [met.t.to_array(), met.u.to_array(), met.v.to_array()];
            offer(bits, &hits, collect);
        }
    }

    /// The input of [`sheared`](Self::sheared), extracted from the lanes, because it is rarely needed.
    #[inline(always)]
    fn single(&self) -> SingleRay {
        let ([x, y, z], [sx, sy, sz]) = (self.sheared.org, self.sheared.shear);
        let sheared = Sheared { org: [x[0], y[0], z[0]], shear: [sx[0], sy[0], sz[0]] };
        SingleRay { sheared, dir: self.dir }
    }
}

impl TriangleBlock {
    pub const ZERO: Self = Self { corners: [[[0.0; WIDTH]; 3]; 3], numbers: [0; WIDTH] };

    /// From numbers of triangles and their corners; `INVALID_ID` where there is none, which is not so for the first.
    pub fn new(corners: impl Fn(u32) -> [[f32; 3]; 3], numbers: &[u32; WIDTH]) -> Self {
        let mut block = Self { numbers: *numbers, ..Self::ZERO };
        for lane in 0..WIDTH {
            if block.numbers[lane] == INVALID_ID {
                block.numbers[lane] = block.numbers[0];
            }
            let number = block.numbers[lane];
            block.put(lane, &corners(number), number);
        }
        block
    }

    /// Puts a triangle into a lane.
    #[inline(always)]
    pub fn put(&mut self, lane: usize, corners: &[[f32; 3]; 3], number: u32) {
        let lane = lane & (WIDTH - 1);
        for (to, position) in self.corners.iter_mut().zip(corners) {
            for (row, &x) in to.iter_mut().zip(position) {
                row[lane] = x;
            }
        }
        self.numbers[lane] = number;
    }

    /// Puts a triangle into all lanes.
    #[inline(always)]
    pub fn put_everywhere(&mut self, corners: &[[f32; 3]; 3], number: u32) {
        for (to, position) in self.corners.iter_mut().zip(corners) {
            for (row, &x) in to.iter_mut().zip(position) {
                *row = [x; WIDTH];
            }
        }
        self.numbers = [number; WIDTH];
    }

    /// Offers the hits of `ray`.
    #[inline(always)]
    pub fn meet<S: Simd, C: Collect>(&self, simd: S, ray: &BlockRay<S>, slot: u32, collect: &mut C) {
        self.meet_at(simd, ray, [slot, NOWHERE], collect);
    }

    /// The same, given the slot and the [place](crate::nearest::Nearest::place) of the first triangle.
    #[inline(always)]
    pub fn meet_at<S: Simd, C: Collect>(&self, simd: S, ray: &BlockRay<S>, whose: [u32; 2], collect: &mut C) {
        let [x, y, z] = ray.axes;
        let [a, b, c] = &self.corners;
        let a = [row(simd, &a[x]), row(simd, &a[y]), row(simd, &a[z])];
        let b = [row(simd, &b[x]), row(simd, &b[y]), row(simd, &b[z])];
        let c = [row(simd, &c[x]), row(simd, &c[y]), row(simd, &c[z])];
        let corners = relative_to([a, b, c], &ray.sheared.org);
        ray.meet(
            simd,
            corners,
            u64::MAX,
            collect,
            #[inline(always)]
            |bits, hits, collect| self.offer(bits, hits, whose, collect),
            #[inline(always)]
            |bits, hits, single, collect| self.meet_in_doubt(bits, hits, single, whose, collect),
        );
    }

    /// Offers the hits of lanes, by bits.
    #[inline(always)]
    fn offer<C: Collect>(
        &self,
        mut bits: u64,
        [t, u, v]: &[[f32; WIDTH]; 3],
        [slot, place]: [u32; 2],
        collect: &mut C,
    ) {
        while bits != 0 {
            let i = bits.trailing_zeros() as usize & 7;
            bits &= bits - 1;
            if t[i] <= collect.reach() {
                let hit = TriangleHit { t: t[i], u: u[i], v: v[i] };
                collect.offer_at(hit, self.numbers[i], slot, place | i as u32);
            }
        }
    }

    /// For lanes that floats cannot decide: by bits those that hit, those that pass inside, and those that
    /// are fully undecided. The ray by value: one whose address is taken lives in memory.
    #[cold]
    #[inline(never)]
    pub fn meet_in_doubt<C: Collect>(
        &self,
        [bits, mut inside, mut uncertain]: [u64; 3],
        hits: &[[f32; WIDTH]; 3],
        (axes, ray, t_near): ([usize; 3], SingleRay, f32),
        [slot, place]: [u32; 2],
        collect: &mut C,
    ) {
        self.offer(bits, hits, [slot, place], collect);
        while inside != 0 {
            let i = inside.trailing_zeros() as usize & 7;
            inside &= inside - 1;
            if let Some(triangle_hit) = meet_inside(&self.corners_of(i, axes), &ray, t_near, collect.reach())
            {
                collect.offer_at(triangle_hit, self.numbers[i], slot, place | i as u32);
            }
        }
        while uncertain != 0 {
            let i = uncertain.trailing_zeros() as usize & 7;
            uncertain &= uncertain - 1;
            let (corners, needs_position) = (self.corners_of(i, axes), collect.needs_position());
            if let Some(triangle_hit) = meet_single(&corners, &ray, needs_position, t_near, collect.reach()) {
                collect.offer_at(triangle_hit, self.numbers[i], slot, place | i as u32);
            }
        }
    }

    /// The corners of one triangle along three axes.
    #[cold]
    #[inline(never)]
    pub fn corners_of(&self, lane: usize, axes: [usize; 3]) -> [[f32; 3]; 3] {
        [0, 1, 2].map(|corner: usize| axes.map(|axis| self.corners[corner][axis][lane & 7]))
    }

    /// Offers the hits of `ray`, one triangle after the other: faster where there are no lanes.
    #[inline(always)]
    pub fn meet_in_turn<C: Collect>(&self, ray: &ShearedRay, t_near: f32, slot: u32, collect: &mut C) {
        for (lane, &number) in self.numbers.iter().enumerate() {
            if lane > 0 && number == self.numbers[0] {
                return;
            }
            let corner = |k: usize| {
                let [x, y, z] = &self.corners[k];
                [x[lane], y[lane], z[lane]]
            };
            if let Some(triangle_hit) = ray.meet(
                &[corner(0), corner(1), corner(2)],
                collect.needs_position(),
                t_near,
                collect.reach(),
            ) {
                collect.offer(triangle_hit, number, slot);
            }
        }
    }

    /// Boxes of the triangles along one axis: least and greatest coordinates.
    #[inline(always)]
    pub fn extent<S: Simd>(&self, simd: S, axis: usize) -> [f32x8<S>; 2] {
        let [a, b, c] = &self.corners;
        let (a, b, c) = (row(simd, &a[axis]), row(simd, &b[axis]), row(simd, &c[axis]));
        [a.min(b).min(c), a.max(b).max(c)]
    }

    /// One corner of one triangle along three axes, in all lanes.
    #[inline(always)]
    pub fn corner<S: Simd>(&self, simd: S, lane: usize, corner: usize, axes: [usize; 3]) -> [f32x16<S>; 3] {
        let [x, y, z] = axes;
        let corner = &self.corners[corner];
        [
            f32x16::splat(simd, corner[x][lane & 7]),
            f32x16::splat(simd, corner[y][lane & 7]),
            f32x16::splat(simd, corner[z][lane & 7]),
        ]
    }
}

impl TriangleBlock {
    /// Improves `nearest` by the triangles.
    pub fn nearest(&self, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        // A block that is not full repeats some of its triangles.
        let is_new = |&lane: &usize| !self.numbers[..lane].contains(&self.numbers[lane]);
        for lane in (0..WIDTH).filter(is_new) {
            let coordinate = |corner: usize, k: usize| f64::from(self.corners[corner][k][lane]);
            let corner = |i: usize| probe.offset([coordinate(i, 0), coordinate(i, 1), coordinate(i, 2)]);
            let (offset, uv) = on_triangle([corner(0), corner(1), corner(2)]);
            nearest.offer(offset, uv, self.numbers[lane], slot);
        }
    }
}

#[inline(always)]
fn row<S: Simd>(simd: S, values: &[f32; WIDTH]) -> f32x8<S> {
    f32x8::from_slice(simd, values)
}
