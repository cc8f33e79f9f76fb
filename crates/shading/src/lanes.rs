// SPDX-License-Identifier: GPL-3.0-or-later
//! Sixteen points at once: vectors and rows of lanes, for code that is written once and compiled for each CPU level.
//! Space: that of the caller.
//! Invariant: every lane does the roundings of `glam`'s scalar form in its order, so that lanes and scalar code give the
//! same bits. All of it is inlined into the functions that `gnurt_simd::dispatch_wide!` enters: loops over
//! lanes are written out, because a closure passed to an adapter of arrays or iterators may become a call,
//! and with it each operation in it.
//! Tests: `tests`, and those of its users.

use glam::Vec3;
use gnurt_simd::{Simd, f32x16, mask32x16, prelude::*, u32x16};

use crate::real::Vector;

/// How many points.
pub const LANES: usize = 16;

/// Floats.
pub type Floats<S> = f32x16<S>;
/// Words.
pub type UInts<S> = u32x16<S>;
/// Which lanes.
pub type Mask<S> = mask32x16<S>;

/// Three floats in each lane.
pub type Vec3x16<S> = Vector<f32x16<S>>;

impl<S: Simd> Vec3x16<S> {
    /// The same in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, v: Vec3) -> Self {
        Self { x: f32x16::splat(simd, v.x), y: f32x16::splat(simd, v.y), z: f32x16::splat(simd, v.z) }
    }

    /// Lane `i` in all lanes.
    #[inline(always)]
    pub fn spread(self, i: usize) -> Self {
        Self::splat(self.x.token(), self.get(i))
    }
}

/// Rows to columns: lane `i` of result `k` is lane `k` of row `i`.
#[inline(always)]
pub fn transpose<S: Simd>(rows: [Floats<S>; LANES]) -> [Floats<S>; LANES] {
    // Each round sends entry (row, lane) of eight bits to the entry whose bits are rotated by one: row bits
    // become lane bits.
    let mut now = rows;
    for _ in 0..4 {
        let mut next = now;
        for i in 0..LANES / 2 {
            next[2 * i] = now[i].zip_low(now[i + LANES / 2]);
            next[2 * i + 1] = now[i].zip_high(now[i + LANES / 2]);
        }
        now = next;
    }
    now
}

/// The lanes of a set, ascending.
#[derive(Clone, Copy, Debug)]
pub struct LanesOf(pub u64);

impl Iterator for LanesOf {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        // Bounded for the compiler, too.
        let lane = self.0.trailing_zeros() as usize % LANES;
        self.0 &= self.0 - 1;
        Some(lane)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_simd::{Level, dispatch_wide};

    #[inline(always)]
    fn transposed<S: Simd>(simd: S) -> [[f32; LANES]; LANES] {
        let rows = std::array::from_fn(|i| f32x16::from_fn(simd, |k| (100 * i + k) as f32));
        transpose(rows).map(Into::into)
    }

    #[test]
    fn rows_become_columns() {
        let columns = dispatch_wide!(Level::default(), simd => transposed(simd), else return);
        for (k, column) in columns.iter().enumerate() {
            assert_eq!(*column, std::array::from_fn(|i| (100 * i + k) as f32), "column {k}");
        }
    }

    #[inline(always)]
    fn in_lanes<S: Simd>(simd: S, a: &[Vec3; LANES], b: &[Vec3; LANES]) -> [(f32, Vec3, Vec3); LANES] {
        let lanes = |v: &[Vec3; LANES]| {
            let part = |k: usize| f32x16::from_fn(simd, |i| v[i][k]);
            Vec3x16::new(part(0), part(1), part(2))
        };
        let (a, b) = (lanes(a), lanes(b));
        let (dot, unit, over) = (a.dot(b), a.normalize(), a.over(b.x));
        std::array::from_fn(|i| (dot[i], unit.get(i), over.get(i)))
    }

    #[test]
    fn lanes_have_the_bits_of_scalars() {
        let vectors = |m: f32| {
            std::array::from_fn(|i| Vec3::new(0.3 + m * i as f32, 7.1 / (m + i as f32), -1.7 * m).fract())
        };
        let (a, b) = (vectors(0.37), vectors(1.93));
        let found = dispatch_wide!(Level::default(), simd => in_lanes(simd, &a, &b), else return);
        for (i, found) in found.into_iter().enumerate() {
            assert_eq!(found, (a[i].dot(b[i]), a[i].normalize(), a[i] / b[i].x), "lane {i}");
        }
    }
}
