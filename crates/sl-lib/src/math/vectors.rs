// SPDX-License-Identifier: GPL-3.0-or-later
//! Vectors: arrays of three numbers, with derivatives where those have them.
//! Source: the OSL 1.14 language reference, "Geometric functions". Space: that of the caller's vectors.
//! Invariant: nothing here makes a NaN of numbers: a vector without length normalises to zero.
//! Tests: `tests/vectors.rs`.

use super::arithmetic::{clamp, div, sqrt};
use super::trigonometry::sincos;
use crate::number::{Number, Real};

/// a + b.
#[inline(always)]
pub fn add<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a - b.
#[inline(always)]
pub fn subtract<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a times a number.
#[inline(always)]
pub fn scale<N: Number>(a: [N; 3], by: N) -> [N; 3] {
    [a[0] * by, a[1] * by, a[2] * by]
}

/// The scalar product.
#[inline(always)]
pub fn dot<N: Number>(a: [N; 3], b: [N; 3]) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
#[inline(always)]
pub fn cross<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The length.
#[inline(always)]
pub fn length<N: Number>(v: [N; 3]) -> N {
    sqrt(dot(v, v))
}

/// How far two points are from each other.
#[inline(always)]
pub fn distance<N: Number>(a: [N; 3], b: [N; 3]) -> N {
    length(subtract(a, b))
}

/// How far `q` is from the segment from `a` to `b`.
#[inline(always)]
pub fn distance_to_segment<N: Number>(a: [N; 3], b: [N; 3], q: [N; 3]) -> N {
    let offset = subtract(b, a);
    let t = div(dot(subtract(q, a), offset), dot(offset, offset));
    let t = clamp(t, t.constant(0.0), t.constant(1.0));
    distance(q, add(a, scale(offset, t)))
}

/// With length 1; zero where it has none.
#[inline(always)]
pub fn normalize<N: Number>(v: [N; 3]) -> [N; 3] {
    scale(v, div(v[0].constant(1.0), length(v)))
}

/// `n`, flipped so that it faces against `i` as `reference` does not: -n where `i` and `reference` point the
/// same way.
#[inline(always)]
pub fn faceforward<N: Number>(n: [N; 3], i: [N; 3], reference: [N; 3]) -> [N; 3] {
    let along = dot(i, reference).value();
    let flip = along.of(0.0).less(along);
    [N::pick(flip, -n[0], n[0]), N::pick(flip, -n[1], n[1]), N::pick(flip, -n[2], n[2])]
}

/// The mirror image of direction `i` at a surface with unit normal `n`.
#[inline(always)]
pub fn reflect<N: Number>(i: [N; 3], n: [N; 3]) -> [N; 3] {
    subtract(i, scale(n, dot(n, i) * 2.0))
}

/// Direction `i` behind a surface with unit normal `n`; `eta` is the index of refraction before it over the one behind. Zero
/// where all is reflected.
#[inline(always)]
pub fn refract<N: Number>(i: [N; 3], n: [N; 3], eta: N) -> [N; 3] {
    let along = dot(i, n);
    let k = (eta * eta * (along * along).subtracted_from(1.0)).subtracted_from(1.0);
    let bent = subtract(scale(i, eta), scale(n, eta * along + sqrt(k)));
    let (none, zero) = (k.value().less(k.value().of(0.0)), k.constant(0.0));
    [N::pick(none, zero, bent[0]), N::pick(none, zero, bent[1]), N::pick(none, zero, bent[2])]
}

/// Reflection and refraction at a smooth surface between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fresnel<N> {
    /// The part that is reflected.
    pub reflected: N,
    /// The part that goes through, with the square of `eta` for the solid angle it then fills.
    pub transmitted: N,
    /// Where the reflected part goes.
    pub reflection: [N; 3],
    /// Where the other part goes; zero where there is none.
    pub refraction: [N; 3],
}

/// Light from direction `i` at a surface with unit normal `n`; `eta` as in [`refract`].
#[inline(always)]
pub fn fresnel<N: Number>(i: [N; 3], n: [N; 3], eta: N) -> Fresnel<N> {
    let along = dot(i, n);
    let c = N::pick(along.value().less(along.value().of(0.0)), -along, along);
    let g2 = div(c.constant(1.0), eta * eta) - 1.0 + c * c;
    let total = g2.value().less(g2.value().of(0.0));
    let g = sqrt(g2);
    let beta = g - c;
    let f = div(c * (g + c) - 1.0, c * beta + 1.0);
    let ratio = div(beta, g + c);
    let f = ((f * f) + 1.0) * 0.5 * (ratio * ratio);
    Fresnel {
        reflected: N::pick(total, c.constant(1.0), f),
        transmitted: N::pick(total, c.constant(0.0), f.subtracted_from(1.0) * eta * eta),
        reflection: reflect(i, n),
        refraction: refract(i, n, eta),
    }
}

/// Point `p` rotated by `angle` radians around the line from `a` to `b`, counterclockwise seen against it.
#[inline(always)]
pub fn rotate<N: Number>(p: [N; 3], angle: N, a: [N; 3], b: [N; 3]) -> [N; 3] {
    let [x, y, z] = normalize(subtract(b, a));
    let (sine, cosine) = sincos(angle);
    let rest = cosine.subtracted_from(1.0);
    let from_a = subtract(p, a);
    let along = |i: N| i * i + (i * i).subtracted_from(1.0) * cosine;
    let rows = [
        [along(x), x * y * rest - z * sine, x * z * rest + y * sine],
        [x * y * rest + z * sine, along(y), y * z * rest - x * sine],
        [x * z * rest - y * sine, y * z * rest + x * sine, along(z)],
    ];
    add([dot(from_a, rows[0]), dot(from_a, rows[1]), dot(from_a, rows[2])], a)
}

/// The geometric normal that a point's derivatives span, not normalised; `flipped` where the surface's handedness is.
#[inline(always)]
pub fn calculatenormal<R: Real>(dx: [R; 3], dy: [R; 3], flipped: bool) -> [R; 3] {
    if flipped { cross(dy, dx) } else { cross(dx, dy) }
}

/// The area that a pixel covers at a point with these derivatives.
#[inline(always)]
pub fn area<R: Real>(dx: [R; 3], dy: [R; 3]) -> R {
    length(cross(dx, dy))
}
