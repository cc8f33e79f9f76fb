// SPDX-License-Identifier: GPL-3.0-or-later
//! Where lines meet the planes of triangles in doubles, with a bound of the error: one line, or several in lanes.
//! Space: that of the query. Tests: `meeting::tests::bounds_hold`.
//!
//! The normal's error counts little. Let `n` be the rounded normal, off by `e`; `r` the way from the origin to a corner, `d` the
//! direction, and `t` exact. Then `n . r - t * (n . d) = e . (r - t * d)`, and `r - t * d` is a vector of the triangle's plane, no
//! longer than its edges where the line passes through it. So the quotient of `n . r` and `n . d` is off by that much, and by
//! the rounding of both products, divided by `n . d`.

use super::path::UNIT;
use crate::float::Number;

/// Beyond these, products of doubles underflow or overflow.
pub const PLAIN: std::ops::Range<f64> = 1e-200..1e200;

/// The part of a slope that may be lost to rounding.
pub const LOST_SLOPE: f64 = 1e-3;

/// Where a line meets a plane, and what the bound of the error is made of.
#[derive(Clone, Copy)]
pub struct Meeting<V> {
    pub t: V,
    /// The slope towards the normal, without its sign.
    pub size: V,
    /// The error of the slope.
    pub of_slope: V,
    /// The greatest of a normal by edges of this length.
    pub area: V,
    /// The normal's components, without signs.
    pub(super) normal: V,
    pub(super) of_depth: V,
    of_normal: V,
}

#[inline(always)]
fn all<V: Number>(v: [V; 3]) -> V {
    v[0].size() + v[1].size() + v[2].size()
}

#[inline(always)]
fn largest<V: Number>(v: [V; 3]) -> V {
    v[0].size().or_more(v[1].size()).or_more(v[2].size())
}

#[inline(always)]
fn away<V: Number>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn products<V: Number>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

impl<V: Number> Meeting<V> {
    /// Of triangles whose corners are exact.
    #[inline(always)]
    pub fn new([a, b, c]: [[V; 3]; 3], org: [V; 3], dir: [V; 3], number: impl Fn(f64) -> V) -> Self {
        let twice = number(2.0 * UNIT);
        let (u, v, r) = (away(b, a), away(c, a), away(a, org));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let (depths, slopes) = (products(n, r), products(n, dir));
        let slope = slopes[0] + slopes[1] + slopes[2];
        // Two differences, two products and their difference are rounded.
        let of = |i: usize, j: usize, k: usize| {
            ((u[i] * v[j]).size() + (u[j] * v[i]).size()) * u[k].size().or_more(v[k].size())
        };
        Self {
            t: (depths[0] + depths[1] + depths[2]) / slope,
            size: slope.size(),
            of_slope: twice * all(slopes),
            area: largest(u) * largest(v),
            normal: all(n),
            of_depth: twice * all(depths),
            of_normal: twice * (of(1, 2, 0) + of(2, 0, 1) + of(0, 1, 2)),
        }
    }

    /// A bound of the error of `t`, if the line passes through the triangle, and nothing under- or overflows.
    #[inline(always)]
    pub fn off(&self, number: impl Fn(f64) -> V) -> V {
        self.off_by(self.of_normal, self.of_depth, number)
    }

    /// The same for these errors of the normal and of the depth.
    #[inline(always)]
    pub(super) fn off_by(&self, of_normal: V, of_depth: V, number: impl Fn(f64) -> V) -> V {
        let far = self.t.size();
        number(1.01) * (of_normal + of_depth + far * self.of_slope) / self.size + number(UNIT) * far
    }
}
