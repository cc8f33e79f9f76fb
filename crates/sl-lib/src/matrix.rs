// SPDX-License-Identifier: GPL-3.0-or-later
//! Matrices of 4 x 4 floats that points are multiplied to from the left: `p M`, translation in the last row.
//! Source: the OSL 1.14 language reference, "Matrix functions"; the inverse by cofactors.
//! Invariant: a matrix without an inverse has the identity as one, as with OSL.
//! Tests: `tests/vectors.rs`.

use crate::math::div;
use crate::number::{Number, Real};

/// A matrix, by rows.
pub type Matrix = [[f32; 4]; 4];

/// The matrix that changes nothing.
pub const IDENTITY: Matrix = diagonal(1.0);

/// A number along the diagonal, as the language defines `matrix(x)`.
#[must_use]
pub const fn diagonal(x: f32) -> Matrix {
    [[x, 0.0, 0.0, 0.0], [0.0, x, 0.0, 0.0], [0.0, 0.0, x, 0.0], [0.0, 0.0, 0.0, x]]
}

/// a b: first a, then b.
#[must_use]
pub fn multiply<R: Real>(a: &[[R; 4]; 4], b: &[[R; 4]; 4]) -> [[R; 4]; 4] {
    a.map(|row| {
        [0, 1, 2, 3].map(|k: usize| row[0] * b[0][k] + row[1] * b[1][k] + row[2] * b[2][k] + row[3] * b[3][k])
    })
}

/// Each number times another.
#[must_use]
pub fn scale<R: Real>(m: &[[R; 4]; 4], by: R) -> [[R; 4]; 4] {
    m.map(|row| row.map(|x| x * by))
}

/// a times the inverse of b.
#[must_use]
pub fn divide(a: &Matrix, b: &Matrix) -> Matrix {
    multiply(a, &inverse(b))
}

/// Rows as columns.
#[must_use]
pub fn transpose<R: Real>(m: &[[R; 4]; 4]) -> [[R; 4]; 4] {
    [0, 1, 2, 3].map(|i: usize| [0, 1, 2, 3].map(|k: usize| m[k][i]))
}

/// A matrix of numbers that are made of those of another. Loops, because `map` in `map` is called number by number.
fn each<T: Copy, U: Copy + Default>(m: &[[T; 4]; 4], f: impl Fn(T) -> U) -> [[U; 4]; 4] {
    let mut out = [[U::default(); 4]; 4];
    for (to, from) in out.iter_mut().flatten().zip(m.iter().flatten()) {
        *to = f(*from);
    }
    out
}

/// The determinants of 2 x 2 parts of two rows: of columns 01, 02, 03, 12, 13, 23.
fn minors(a: [f32; 4], b: [f32; 4]) -> [f64; 6] {
    let of = |i: usize, k: usize| f64::from(a[i]) * f64::from(b[k]) - f64::from(a[k]) * f64::from(b[i]);
    [of(0, 1), of(0, 2), of(0, 3), of(1, 2), of(1, 3), of(2, 3)]
}

fn determinant_of(s: [f64; 6], c: [f64; 6]) -> f64 {
    s[0] * c[5] - s[1] * c[4] + s[2] * c[3] + s[3] * c[2] - s[4] * c[1] + s[5] * c[0]
}

/// The determinant.
#[must_use]
pub fn determinant(m: &Matrix) -> f32 {
    determinant_of(minors(m[0], m[1]), minors(m[2], m[3])) as f32
}

/// The inverse, and the identity where there is none or where it is beyond all floats.
#[must_use]
pub fn inverse(m: &Matrix) -> Matrix {
    let (s, c) = (minors(m[0], m[1]), minors(m[2], m[3]));
    let factor = determinant_of(s, c).recip();
    let [a, b, d, e] = each(m, f64::from);
    let rows = [
        [
            b[1] * c[5] - b[2] * c[4] + b[3] * c[3],
            -a[1] * c[5] + a[2] * c[4] - a[3] * c[3],
            e[1] * s[5] - e[2] * s[4] + e[3] * s[3],
            -d[1] * s[5] + d[2] * s[4] - d[3] * s[3],
        ],
        [
            -b[0] * c[5] + b[2] * c[2] - b[3] * c[1],
            a[0] * c[5] - a[2] * c[2] + a[3] * c[1],
            -e[0] * s[5] + e[2] * s[2] - e[3] * s[1],
            d[0] * s[5] - d[2] * s[2] + d[3] * s[1],
        ],
        [
            b[0] * c[4] - b[1] * c[2] + b[3] * c[0],
            -a[0] * c[4] + a[1] * c[2] - a[3] * c[0],
            e[0] * s[4] - e[1] * s[2] + e[3] * s[0],
            -d[0] * s[4] + d[1] * s[2] - d[3] * s[0],
        ],
        [
            -b[0] * c[3] + b[1] * c[1] - b[2] * c[0],
            a[0] * c[3] - a[1] * c[1] + a[2] * c[0],
            -e[0] * s[3] + e[1] * s[1] - e[2] * s[0],
            d[0] * s[3] - d[1] * s[1] + d[2] * s[0],
        ],
    ];
    let inverse: Matrix = each(&rows, |x| (x * factor) as f32);
    if inverse.iter().flatten().all(|x| x.is_finite()) { inverse } else { IDENTITY }
}

/// The product of a point with column `k`, without the last row.
#[inline(always)]
fn column<N: Number>(m: &[[N::Real; 4]; 4], v: [N; 3], k: usize) -> N {
    v[0].scaled(m[0][k]) + v[1].scaled(m[1][k]) + v[2].scaled(m[2][k])
}

#[inline(always)]
fn moved_column<N: Number>(m: &[[N::Real; 4]; 4], p: [N; 3], k: usize) -> N {
    let sum = column(m, p, k);
    sum.with_value(sum.value() + m[3][k])
}

/// A point in the space that the matrix leads to; zero where that is at infinity.
#[inline(always)]
pub fn transform_point<N: Number>(m: &[[N::Real; 4]; 4], p: [N; 3]) -> [N; 3] {
    // Written out: `map` becomes a call, and loops over points no vectors.
    let (x, y) = (moved_column(m, p, 0), moved_column(m, p, 1));
    let (z, w) = (moved_column(m, p, 2), moved_column(m, p, 3));
    [div(x, w), div(y, w), div(z, w)]
}

/// A direction or a distance there.
#[inline(always)]
pub fn transform_vector<N: Number>(m: &[[N::Real; 4]; 4], v: [N; 3]) -> [N; 3] {
    [column(m, v, 0), column(m, v, 1), column(m, v, 2)]
}

/// A normal there, not normalised. For many normals invert and transpose once and use [`transform_vector`].
#[inline(always)]
pub fn transform_normal<N: Number<Real = f32>>(m: &Matrix, n: [N; 3]) -> [N; 3] {
    transform_vector(&transpose(&inverse(m)), n)
}

/// Named spaces, for `transform("from", "to", ..)` and `matrix("from", ..)`.
pub trait Spaces {
    /// The matrix from `space` to the common space; `None` for an unknown space.
    fn common_from(&self, space: &str) -> Option<Matrix>;

    /// The inverse matrix, for callers that have it stored.
    fn to_common_inverse(&self, space: &str) -> Option<Matrix> {
        self.common_from(space).map(|m| inverse(&m))
    }
}

/// The matrix from one named space to another. "common" is the space of the shader's own points.
///
/// # Errors
/// The first name that is not known; the program's message is `Unknown transformation "name"`.
pub fn transform_between<'a>(spaces: &impl Spaces, from: &'a str, to: &'a str) -> Result<Matrix, &'a str> {
    let identity = |name: &str| (name == "common").then_some(IDENTITY);
    let start = identity(from).or_else(|| spaces.common_from(from)).ok_or(from)?;
    let end = identity(to).or_else(|| spaces.to_common_inverse(to)).ok_or(to)?;
    if from == "common" {
        return Ok(end);
    }
    Ok(if to == "common" { start } else { multiply(&start, &end) })
}
