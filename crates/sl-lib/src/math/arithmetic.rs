// SPDX-License-Identifier: GPL-3.0-or-later
//! Division, remainders, rounding, roots and the larger of two, with the language's safe meaning: nothing here makes a NaN
//! or an infinity of numbers.
//! And for the cube root's first guess Hacker's Delight, chapter 11. Meaning: OSL 1.14.
//! Tests: `tests/mathematics.rs`.

use crate::number::{Number, Real, UInts};

/// a / b, and 0 where that is not a finite number.
#[inline(always)]
pub fn div<N: Number>(a: N, b: N) -> N {
    let (u, v) = (a.value(), b.value());
    let quotient = finite_or_zero(u / v);
    a.chain2(b, quotient, || {
        let inverse = finite_or_zero(v.of(1.0) / v);
        (inverse, -(quotient * inverse))
    })
}

#[inline(always)]
fn finite_or_zero<R: Real>(x: R) -> R {
    R::choose(x.abs().at_most(x.of(f32::MAX)), x, x.of(0.0))
}

/// a / b rounded towards zero, and 0 where b is 0.
#[must_use]
pub fn div_int(a: i32, b: i32) -> i32 {
    if b == 0 { 0 } else { a.wrapping_div(b) }
}

/// The remainder of [`div_int`], with the sign of a.
#[must_use]
pub fn rem_int(a: i32, b: i32) -> i32 {
    if b == 0 { 0 } else { a.wrapping_rem(b) }
}

/// `mod` of whole numbers: a less b times the rounded quotient, as OSL computes it; 0 where b is 0 only if a is.
#[must_use]
pub fn mod_int(a: i32, b: i32) -> i32 {
    // The language divides whole numbers first, and then has nothing left to round: floor() of it changes nothing.
    a.wrapping_sub(b.wrapping_mul(div_int(a, b)))
}

/// The remainder of a / b with the sign of a; 0 where b is 0 or the quotient is beyond all floats.
#[inline(always)]
pub fn fmod<N: Number>(a: N, b: N) -> N {
    let (u, v) = (a.value(), b.value());
    let quotient = u / v;
    let rest = u - quotient.trunc() * v;
    let sound = quotient.abs().at_most(u.of(f32::MAX));
    a.with_value(N::Real::choose(sound, rest, u.of(0.0)))
}

/// a - b floor(a / b): the remainder with the sign of b; a itself where b is 0. Only `a` hands on derivatives, and `b` by the quotient.
#[inline(always)]
pub fn modulo<N: Number>(a: N, b: N) -> N {
    let quotient = finite_or_zero(a.value() / b.value());
    a - b * N::lift(quotient.floor())
}

/// The square root; 0 of negative numbers.
#[inline(always)]
pub fn sqrt<N: Number>(x: N) -> N {
    let (value, zero) = (x.value(), x.value().of(0.0));
    let root = N::Real::choose(zero.at_most(value), value.sqrt(), zero);
    x.chain(root, || N::Real::choose(zero.less(value), zero.of(0.5) / root, zero))
}

/// 1 / sqrt(x); 0 for x <= 0 and NaN.
#[inline(always)]
pub fn inversesqrt<N: Number>(x: N) -> N {
    let (value, zero) = (x.value(), x.value().of(0.0));
    let positive = zero.less(value);
    let root = N::Real::choose(positive, zero.of(1.0) / value.sqrt(), zero);
    x.chain(root, || N::Real::choose(positive, (root * -0.5) / value, zero))
}

/// The cube root, also of negative numbers.
#[inline(always)]
pub fn cbrt<N: Number>(x: N) -> N {
    let value = x.value();
    let size = value.abs();
    let zero = size.of(0.0);
    let guess = N::Real::from_bits(third(size.bits()) + 0x2a51_37a0);
    let root = newton_for_cube_root(newton_for_cube_root(guess, size), size);
    let root = N::Real::choose(size.equal(zero), zero, root).copysign(value);
    x.chain(root, || N::Real::choose(size.equal(zero), zero, zero.of(1.0) / ((root * 3.0) * root)))
}

#[inline(always)]
fn newton_for_cube_root<R: Real>(a: R, of: R) -> R {
    (a * 2.0 + of / (a * a)) * 0.333_333_34
}

/// A third of words without sign, rounded down, by shifts: lanes have no division.
#[inline(always)]
fn third<W: UInts>(x: W) -> W {
    let q = (x >> 2) + (x >> 4);
    let q = q + (q >> 4);
    let q = q + (q >> 8);
    let q = q + (q >> 16);
    let rest = x - (q + q + q);
    q + (((rest << 3) + (rest << 1) + rest) >> 5)
}

/// Without the sign.
#[inline(always)]
pub fn abs<N: Number>(x: N) -> N {
    let value = x.value();
    let positive = value.of(0.0).at_most(value);
    N::pick(positive, x, -x).with_value(value.abs())
}

/// Without the sign; the smallest integer stays unchanged.
#[must_use]
pub fn abs_int(x: i32) -> i32 {
    x.wrapping_abs()
}

/// -1, 0 or 1.
#[inline(always)]
pub fn sign<R: Real>(x: R) -> R {
    let zero = x.of(0.0);
    let of_rest = R::choose(x.equal(zero), zero, x.of(1.0));
    R::choose(x.less(zero), x.of(-1.0), of_rest)
}

/// The next whole number at or below.
#[inline(always)]
pub fn floor<R: Real>(x: R) -> R {
    x.floor()
}

/// The next whole number at or above.
#[inline(always)]
pub fn ceil<R: Real>(x: R) -> R {
    x.ceil()
}

/// The next whole number towards zero.
#[inline(always)]
pub fn trunc<R: Real>(x: R) -> R {
    x.trunc()
}

/// The nearest whole number, ties away from zero.
#[inline(always)]
pub fn round<R: Real>(x: R) -> R {
    let towards_zero = x.trunc();
    let far = x.of(0.5).at_most((x - towards_zero).abs());
    R::choose(far, towards_zero + x.of(1.0).copysign(x), towards_zero)
}

/// The smaller one, with its derivatives; the first where they are equal.
#[inline(always)]
pub fn min<N: Number>(a: N, b: N) -> N {
    N::pick(a.value().at_most(b.value()), a, b)
}

/// The larger one, with its derivatives; the second where they are equal.
#[inline(always)]
pub fn max<N: Number>(a: N, b: N) -> N {
    N::pick(b.value().less(a.value()), a, b)
}

/// `x`, but at most `high`, but at least `low`.
#[inline(always)]
pub fn clamp<N: Number>(x: N, low: N, high: N) -> N {
    max(min(x, high), low)
}

/// sqrt(a^2 + b^2).
#[inline(always)]
pub fn hypot<N: Number>(a: N, b: N) -> N {
    sqrt(a * a + b * b)
}

/// sqrt(a^2 + b^2 + c^2).
#[inline(always)]
pub fn hypot3<N: Number>(a: N, b: N, c: N) -> N {
    sqrt(a * a + b * b + c * c)
}

/// Radians as degrees.
#[inline(always)]
pub fn degrees<N: Number>(x: N) -> N {
    x * (180.0 / std::f64::consts::PI) as f32
}

/// Degrees as radians.
#[inline(always)]
pub fn radians<N: Number>(x: N) -> N {
    x * (std::f64::consts::PI / 180.0) as f32
}
