// SPDX-License-Identifier: GPL-3.0-or-later
//! Weights of triangles' corners where lines meet them, eight lines at a time: the arithmetic of [`Line::weights`] in lanes, with the
//! same bits. Space: that of the query. Tests: `tests/doubles.rs` of `gnurt-accel`.

use gnurt_simd::{Simd, f64x8, prelude::*};

use super::line::Line;
use super::meeting::{EDGES, FINE_WEIGHT};
use super::path::UNIT;

/// Lines that go together.
pub const EIGHT: usize = 8;

impl Line {
    /// The weights of the second and the third corner of each line's own triangle, whose corners are exact; as bits, of which lines
    /// they are good, so that others have to be asked one by one.
    #[inline(always)]
    pub fn weights_of_eight<S: Simd>(
        simd: S,
        lines: &[Self; EIGHT],
        corners: [&[[f64; 3]; 3]; EIGHT],
    ) -> ([[f64; 2]; EIGHT], u32) {
        let splat = |x: f64| f64x8::splat(simd, x);
        let row = |values: [f64; EIGHT]| f64x8::from_slice(simd, &values);
        let (mut org, mut dir, mut near) = ([splat(0.0); 3], [splat(0.0); 3], [[splat(0.0); 3]; 3]);
        for k in 0..3 {
            org[k] = row([0, 1, 2, 3, 4, 5, 6, 7].map(|i| lines[i].org[k]));
            dir[k] = row([0, 1, 2, 3, 4, 5, 6, 7].map(|i| lines[i].dir[k]));
            for corner in 0..3 {
                near[corner][k] = row([0, 1, 2, 3, 4, 5, 6, 7].map(|i| corners[i][corner][k]));
            }
        }
        let size = dir[0].abs() + dir[1].abs() + dir[2].abs();
        let away = |a: [f64x8<S>; 3], b: [f64x8<S>; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let largest = |v: [f64x8<S>; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
        let (mut values, mut error) = ([splat(0.0); 3], splat(0.0));
        for (at, (i, j)) in EDGES.into_iter().enumerate() {
            let (r, w) = (away(near[i], org), away(near[j], near[i]));
            let c = [r[1] * w[2] - r[2] * w[1], r[2] * w[0] - r[0] * w[2], r[0] * w[1] - r[1] * w[0]];
            values[at] = dir[0] * c[0] + dir[1] * c[1] + dir[2] * c[2];
            let (r, w) = (largest(r), largest(w));
            let (off_r, off_w) = (splat(UNIT) * r, splat(UNIT) * w);
            let off = splat(2.0) * (r * off_w + w * off_r + off_r * off_w) + splat(8.0 * UNIT) * r * w;
            error += size * off * splat(1.01) + splat(f64::MIN_POSITIVE);
        }
        let side = (values[0] + values[1] + values[2]).simd_lt(0.0).select(splat(-1.0), splat(1.0));
        let [a, b, c] = [side * values[0], side * values[1], side * values[2]];
        let whole = a + b + c;
        // Not so of what is no number, and of zeros, whose signs lanes may keep.
        let is_fine = a.simd_gt(0.0)
            & b.simd_gt(0.0)
            & c.simd_gt(0.0)
            & whole.simd_lt(f64::INFINITY)
            & error.simd_le(splat(FINE_WEIGHT) * whole);
        let (u, v) = (b / whole, c / whole);
        let mut weights = [[0.0; 2]; EIGHT];
        for (i, weights) in weights.iter_mut().enumerate() {
            *weights = [u[i], v[i]];
        }
        (weights, is_fine.to_bitmask() as u32)
    }
}
