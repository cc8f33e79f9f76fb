// SPDX-License-Identifier: GPL-3.0-or-later
//! Leaves of triangles in double precision: blocks of eight. The test is [WBW13], with a bound of its error.
//! Space: object.
//!
//! Corners less the origin are off by `u * m`: `m` is the greatest of them, `u` half a unit in the last place. Sheared ones are off
//! by `6 * u * m`. An edge is a difference of products of sheared corners, of which the greatest is `s`: it is off by less than
//! `2 * 2 * s * 6 * u * m + 4 * u * s * s`. To that comes the error of the line: `4 * s * (2 * off + off_shear * m)`. No corner of
//! the tree is farther from the origin than `m` of the line: all this is `s` times a constant of the line.
//! Tests: `tests/doubles.rs` of `gnurt-accel`.

use gnurt_accel_core::INVALID_ID;
use gnurt_accel_core::exact::{Along, LOST_SLOPE, Meeting, PLAIN};
use gnurt_simd::{Simd, f64x8, prelude::*};

use super::line::{Given, Lanes};
use crate::node::WIDTH;

/// Eight triangles.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct DoubleBlock {
    /// By corner, then by axis.
    corners: [[[f64; WIDTH]; 3]; 3],
    pub(super) numbers: [u32; WIDTH],
    /// Lanes in use, as bits.
    used: u32,
}

/// Lanes of a block, as bits, and those whose triangles a line passes inside for certain, if they are among them.
pub(super) struct Candidates {
    open: u32,
    certain: u32,
}

impl Iterator for Candidates {
    /// A lane, and whether the line passes inside for certain.
    type Item = (usize, bool);

    #[inline(always)]
    fn next(&mut self) -> Option<(usize, bool)> {
        if self.open == 0 {
            return None;
        }
        let lane = self.open.trailing_zeros() as usize & (WIDTH - 1);
        self.open &= self.open - 1;
        Some((lane, self.certain >> lane & 1 != 0))
    }
}

impl Candidates {
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.open == 0
    }

    /// Those of these lanes.
    #[inline(always)]
    pub(super) fn of(self, lanes: u32) -> Self {
        Self { open: self.open & lanes, certain: self.certain }
    }
}

/// Where a line meets the planes of a block's triangles, by lane.
pub(super) struct Alongs<S: Simd> {
    t: f64x8<S>,
    off: f64x8<S>,
}

impl<S: Simd> Alongs<S> {
    /// Lanes that are not certainly out of an interval, as bits.
    #[inline(always)]
    pub(super) fn within(&self, near: f64, far: f64) -> u32 {
        let is_beyond = (self.t + self.off).simd_lt(near) | (self.t - self.off).simd_gt(far);
        !is_beyond.to_bitmask() as u32
    }

    #[inline(always)]
    pub(super) fn at(&self, lane: usize) -> Along {
        Along { t: self.t[lane & (WIDTH - 1)], off: self.off[lane & (WIDTH - 1)] }
    }
}

impl DoubleBlock {
    /// Where the line meets the planes of the triangles.
    #[inline(always)]
    pub(super) fn alongs<S: Simd>(&self, simd: S, line: &Given<S>) -> Alongs<S> {
        let splat = |x: f64| f64x8::splat(simd, x);
        let row = |corner: usize, k: usize| f64x8::from_slice(simd, &self.corners[corner][k]);
        let corners = [
            [row(0, 0), row(0, 1), row(0, 2)],
            [row(1, 0), row(1, 1), row(1, 2)],
            [row(2, 0), row(2, 1), row(2, 2)],
        ];
        let met = Meeting::new(corners, line.org, line.dir, splat);
        let off = met.off(splat);
        let lies = |x: f64x8<S>| x.simd_ge(PLAIN.start) & x.simd_lt(PLAIN.end);
        let is_plain = lies(met.size)
            & lies(met.area)
            & met.of_slope.simd_le(met.size * splat(LOST_SLOPE))
            & off.simd_lt(f64::INFINITY);
        Alongs { t: met.t, off: is_plain.select(off, splat(f64::INFINITY)) }
    }

    /// Of numbers of triangles and their corners; `INVALID_ID` where there is none.
    pub(super) fn new(corners: impl Fn(u32) -> [[f64; 3]; 3], numbers: &[u32; WIDTH]) -> Self {
        let mut block = Self { corners: [[[0.0; WIDTH]; 3]; 3], numbers: *numbers, used: 0 };
        for (lane, &number) in numbers.iter().enumerate().filter(|(_, number)| **number != INVALID_ID) {
            block.used |= 1 << lane;
            for (rows, corner) in block.corners.iter_mut().zip(corners(number)) {
                for (row, x) in rows.iter_mut().zip(corner) {
                    row[lane] = x;
                }
            }
        }
        block
    }

    /// One triangle.
    #[inline(always)]
    pub(super) fn corners(&self, lane: usize) -> [[f64; 3]; 3] {
        let lane = lane & (WIDTH - 1);
        let [a, b, c] = &self.corners;
        [
            [a[0][lane], a[1][lane], a[2][lane]],
            [b[0][lane], b[1][lane], b[2][lane]],
            [c[0][lane], c[1][lane], c[2][lane]],
        ]
    }

    /// Lanes in use.
    pub(super) fn lanes(&self) -> impl Iterator<Item = usize> + use<> {
        let used = self.used;
        (0..WIDTH).filter(move |lane| used >> lane & 1 != 0)
    }

    /// Triangles that the line may touch before `depth`.
    #[inline(always)]
    pub(super) fn candidates<S: Simd>(&self, simd: S, line: &Lanes<S>, depth: f64) -> Candidates {
        let [a, b, c] =
            [self.relative(simd, 0, line), self.relative(simd, 1, line), self.relative(simd, 2, line)];
        let (x, y, z) = (a[2] * line.sign, b[2] * line.sign, c[2] * line.sign);
        let beyond = x.min(y).min(z).simd_gt(f64x8::splat(simd, depth)) | x.max(y).max(z).simd_lt(line.near);
        let (p, q, r) = (sheared(&a, line), sheared(&b, line), sheared(&c, line));
        let edges = [edge(&q, &r), edge(&r, &p), edge(&p, &q)];
        let s = size(&p).max(size(&q)).max(size(&r));
        let error = s * line.error + f64x8::splat(simd, f64::MIN_POSITIVE);
        let least = edges[0].min(edges[1]).min(edges[2]);
        let most = edges[0].max(edges[1]).max(edges[2]);
        let zero = f64x8::splat(simd, 0.0) - error;
        let outside = least.simd_lt(zero) & most.simd_gt(error);
        let open = self.used & !((outside | beyond).to_bitmask() as u32);
        if open == 0 {
            return Candidates { open: 0, certain: 0 };
        }
        let certain = least.simd_gt(error) | most.simd_lt(zero);
        Candidates { open, certain: certain.to_bitmask() as u32 }
    }

    /// A corner less the origin, along the line's axes. Written out: `map` would be a call.
    #[inline(always)]
    fn relative<S: Simd>(&self, simd: S, corner: usize, line: &Lanes<S>) -> [f64x8<S>; 3] {
        let (rows, [x, y, z]) = (&self.corners[corner], line.axes);
        [
            f64x8::from_slice(simd, &rows[x]) - line.org[0],
            f64x8::from_slice(simd, &rows[y]) - line.org[1],
            f64x8::from_slice(simd, &rows[z]) - line.org[2],
        ]
    }
}

#[inline(always)]
fn sheared<S: Simd>(p: &[f64x8<S>; 3], line: &Lanes<S>) -> [f64x8<S>; 2] {
    [p[0] - line.shear[0] * p[2], p[1] - line.shear[1] * p[2]]
}

#[inline(always)]
fn edge<S: Simd>(p: &[f64x8<S>; 2], q: &[f64x8<S>; 2]) -> f64x8<S> {
    p[0] * q[1] - p[1] * q[0]
}

#[inline(always)]
fn size<S: Simd>(p: &[f64x8<S>; 2]) -> f64x8<S> {
    p[0].abs().max(p[1].abs())
}
