// SPDX-License-Identifier: GPL-3.0-or-later
//! Sine, cosine and their relatives, in radians.
//! Source: the polynomials that OSL evaluates (of SLEEF, and fits published by their authors as comments in OpenImageIO's
//! `fmath.h`), so that shaders print the same digits. Differs: rounds to full rotations away from ties.
//! Invariants: never NaN for numbers; arguments of `asin` and `acos` are clamped to [-1, 1]. Errors, as
//! absolute differences: sine and cosine 5e-7 up to 1000 radians, `asin` and `acos` 5e-5, `atan` and `atan2`
//! 1e-5.
//! Tests: `tests/mathematics.rs`, against `f64`.

use std::f32::consts::{FRAC_1_PI, FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

use super::exponential::exp;
use crate::number::{Number, Real, UInts};

/// A quarter of pi in four parts, the first ones short enough for exact products with small whole numbers.
const QUARTER_PI_PARTS: [f32; 4] = [0.785_156_25, 0.000_241_875_65, 3.774_766_8e-8, 1.281_672e-12];

/// The nearest whole number, ties away from zero.
#[inline(always)]
fn nearest<R: Real>(x: R) -> R::UInts {
    (x + x.of(0.5).copysign(x)).to_int()
}

/// `x` less `quadrants` times `quarters` quarters of pi.
#[inline(always)]
fn reduced<R: Real>(x: R, quadrants: R::UInts, quarters: f32) -> R {
    let quadrants = R::from_int(quadrants);
    let mut x = x;
    for part in &QUARTER_PI_PARTS {
        x = quadrants * (-part * quarters) + x;
    }
    x
}

/// `x` at a polynomial with these coefficients, highest power first.
#[inline(always)]
fn polynomial<R: Real, const N: usize>(x: R, coefficients: [f32; N]) -> R {
    let mut sum = x.of(coefficients[0]);
    for coefficient in &coefficients[1..] {
        sum = sum * x + *coefficient;
    }
    sum
}

/// Sine and cosine of values.
#[inline(always)]
fn sin_cos_values<R: Real>(x: R) -> (R, R) {
    let quadrants = nearest(x * FRAC_1_PI);
    let x = reduced(x, quadrants, 4.0);
    let x = x.of(FRAC_PI_2) - (x.of(FRAC_PI_2) - x);
    let square = x * x;
    let odd = quadrants & 1;
    let x = x.negated_where(odd);
    let sine = polynomial(square, [2.608_316e-6, -0.000_198_106_9, 0.008_333_079, -0.166_666_6]);
    let sine = square * (sine * x) + x;
    let cosine =
        polynomial(square, [-2.718_118_4e-7, 2.479_904_5e-5, -0.001_388_887_9, 0.041_666_664, -0.5, 1.0]);
    (sine.clamped(-1.0, 1.0), cosine.negated_where(odd).clamped(-1.0, 1.0))
}

/// Sine.
#[inline(always)]
pub fn sin<N: Number>(x: N) -> N {
    let (sine, cosine) = sin_cos_values(x.value());
    x.chain(sine, || cosine)
}

/// Cosine.
#[inline(always)]
pub fn cos<N: Number>(x: N) -> N {
    let (sine, cosine) = sin_cos_values(x.value());
    x.chain(cosine, || -sine)
}

/// Sine and cosine.
#[inline(always)]
pub fn sincos<N: Number>(x: N) -> (N, N) {
    let (sine, cosine) = sin_cos_values(x.value());
    (x.chain(sine, || cosine), x.chain(cosine, || -sine))
}

/// Tangent; good for arguments up to 8192.
#[inline(always)]
pub fn tan<N: Number>(x: N) -> N {
    let value = x.value();
    let quadrants = nearest(value * FRAC_2_PI);
    let reduced = reduced(value, quadrants, 2.0);
    let odd = (quadrants & 1).equal(1);
    // Not where the reciprocal is taken: it would be of zero.
    let crushed = reduced.of(FRAC_PI_4) - (reduced.of(FRAC_PI_4) - reduced);
    let reduced = N::Real::choose(odd, reduced, crushed);
    let square = reduced * reduced;
    let series = polynomial(
        square,
        [0.009_272_458, 0.003_319_85, 0.024_299_808, 0.053_449_53, 0.133_383, 0.333_331_85],
    );
    let tangent = square * (series * reduced) + reduced;
    let tangent = N::Real::choose(odd, tangent.of(-1.0) / tangent, tangent);
    x.chain(
        tangent,
        #[inline(always)]
        || {
            let (_, cosine) = sin_cos_values(value);
            cosine.of(1.0) / (cosine * cosine)
        },
    )
}

/// The arc cosine of the absolute value.
#[inline(always)]
fn acos_of_abs<R: Real>(x: R) -> R {
    let (a, one) = (x.abs(), x.of(1.0));
    let m = R::choose(a.less(one), one - (one - a), one);
    let series = ((m * -0.021_640_95 + 0.077_980_48) * m + -0.213_300_99) * m + FRAC_PI_2;
    (one - m).sqrt() * series
}

/// 1 / sqrt(1 - x^2), and 0 where there is none.
#[inline(always)]
fn slope_of_arc<R: Real>(x: R) -> R {
    let one = x.of(1.0);
    R::choose(x.abs().less(one), one / (one - x * x).sqrt(), x.of(0.0))
}

/// Arc cosine in [0, pi].
#[inline(always)]
pub fn acos<N: Number>(x: N) -> N {
    let value = x.value();
    let a = acos_of_abs(value);
    let angle = N::Real::choose(value.less(value.of(0.0)), value.of(PI) - a, a);
    x.chain(angle, || -slope_of_arc(value))
}

/// Arc sine in [-pi/2, pi/2].
#[inline(always)]
pub fn asin<N: Number>(x: N) -> N {
    let value = x.value();
    let angle = value.of(FRAC_PI_2) - acos_of_abs(value);
    x.chain(angle.copysign(value), || slope_of_arc(value))
}

/// The arc tangent of numbers in [0, 1].
#[inline(always)]
fn atan_up_to_one<R: Real>(k: R) -> R {
    let s = k.without_denormals();
    let t = s * s;
    s * (t * 0.430_165_68 + 1.0) / ((t * 0.057_935_5 + 0.763_008) * t + 1.0)
}

/// Arc tangent in [-pi/2, pi/2].
#[inline(always)]
pub fn atan<N: Number>(x: N) -> N {
    let value = x.value();
    let (a, one) = (value.abs(), value.of(1.0));
    let steep = one.less(a);
    let r = atan_up_to_one(N::Real::choose(steep, one / a, a));
    let angle = N::Real::choose(steep, value.of(FRAC_PI_2) - r, r);
    x.chain(angle.copysign(value), || one / (value * value + 1.0))
}

/// The angle of the direction (x, y), in [-pi, pi]; 0 or pi where both are zero. A NaN counts as without a
/// sign.
#[inline(always)]
pub fn atan2<N: Number>(y: N, x: N) -> N {
    let (v, u) = (y.value(), x.value());
    let (a, b, zero, one) = (u.abs(), v.abs(), u.of(0.0), u.of(1.0));
    let steep = a.less(b);
    let ratio = N::Real::choose(steep, a, b) / N::Real::choose(steep, b, a);
    let ratio = N::Real::choose(a.equal(b), one, ratio);
    let r = atan_up_to_one(N::Real::choose(b.equal(zero), zero, ratio));
    let r = N::Real::choose(steep, u.of(FRAC_PI_2) - r, r);
    let leftwards = one.copysign(u).less(zero) & u.equal(u);
    let angle = N::Real::choose(leftwards, u.of(PI) - r, r).copysign(v);
    y.chain2(x, angle, || {
        let square = u * u + v * v;
        let inverse = N::Real::choose(square.equal(zero), zero, one / square);
        (u * inverse, -(v * inverse))
    })
}

/// Hyperbolic sine of values.
#[inline(always)]
fn sinh_value<R: Real>(x: R) -> R {
    let a = x.abs();
    let e = exp(a);
    let large = e * 0.5 - a.of(0.5) / e;
    let crushed = a.without_denormals();
    let square = crushed * crushed;
    let series = polynomial(square, [2.039_455_1e-4, 8.329_903e-3, 0.166_667_34]);
    let small = (series * crushed) * square + crushed;
    R::choose(a.of(1.0).less(a), large, small).copysign(x)
}

/// Hyperbolic cosine of values.
#[inline(always)]
fn cosh_value<R: Real>(x: R) -> R {
    let e = exp(x.abs());
    e * 0.5 + e.of(0.5) / e
}

/// Hyperbolic sine.
#[inline(always)]
pub fn sinh<N: Number>(x: N) -> N {
    x.chain(sinh_value(x.value()), || cosh_value(x.value()))
}

/// Hyperbolic cosine.
#[inline(always)]
pub fn cosh<N: Number>(x: N) -> N {
    x.chain(cosh_value(x.value()), || sinh_value(x.value()))
}

/// Hyperbolic tangent.
#[inline(always)]
pub fn tanh<N: Number>(x: N) -> N {
    let value = x.value();
    let one = value.of(1.0);
    let e = exp(value.abs() * 2.0);
    let tangent = (one - one.of(2.0) / (e + 1.0)).copysign(value);
    x.chain(tangent, || {
        let cosine = cosh_value(value);
        one / (cosine * cosine)
    })
}
