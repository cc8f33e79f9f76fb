// SPDX-License-Identifier: GPL-3.0-or-later
//! Powers, exponentials, logarithms, the error function.
//! Source: the polynomials that OSL evaluates, as in `trigonometry`; the error function is formula 7.1.28 of Abramowitz and
//! Stegun.
//! Invariants: never NaN and never infinite for numbers. Logarithms clamp at the smallest normal float;
//! powers of two are in [2^-126, 2^126], so `pow` is clamped to that range. Errors, relative: `exp2` and
//! `exp` 3e-5, logarithms 8e-6 absolute, `erf` 2e-6 absolute. Tests: `tests/mathematics.rs`.

use std::f32::consts::{FRAC_2_SQRT_PI, LN_2, LN_10, LOG2_E};

use crate::number::{Number, Real, UInts};

/// ln 2 / ln 10, rounded once.
const LOG10_2: f32 = std::f32::consts::LOG10_2;

/// 2^x of values.
#[inline(always)]
fn exp2_value<R: Real>(x: R) -> R {
    let x = x.clamped(-126.0, 126.0);
    let whole = x.to_int();
    let x = (x - R::from_int(whole)).without_denormals();
    let r = x * 1.333_365e-3 + 9.810_353e-3;
    let r = x * r + 5.551_834e-2;
    let r = x * r + 0.240_179_33;
    let r = x * r + 0.693_144_86;
    let r = x * r + 1.0;
    R::from_bits(r.bits() + (whole << 23))
}

/// log2(x) of values.
#[inline(always)]
fn log2_value<R: Real>(x: R) -> R {
    let bits = x.clamped(f32::MIN_POSITIVE, f32::MAX).bits();
    let exponent = R::from_int((bits >> 23) + (-127_i32 as u32));
    let f = R::from_bits((bits & 0x007f_ffff) | 0x3f80_0000) - 1.0;
    let f2 = f * f;
    let f4 = f2 * f2;
    let high = f * -0.009_310_496 + 0.052_064_69;
    let low = f * 0.478_684_8 + -0.721_165_9;
    let high = f * high + -0.137_531_24;
    let high = f * high + 0.241_873_7;
    let high = f * high + -0.347_305_48;
    let low = f * low + 1.442_689_9;
    ((f4 * high) + (f * low)) + exponent
}

/// 2^x.
#[inline(always)]
pub fn exp2<N: Number>(x: N) -> N {
    let value = exp2_value(x.value());
    x.chain(value, || value * LN_2)
}

/// e^x.
#[inline(always)]
pub fn exp<N: Number>(x: N) -> N {
    let value = exp2_value(x.value() * LOG2_E);
    x.chain(value, || value)
}

/// e^x - 1, good for small x too.
#[inline(always)]
pub fn expm1<N: Number>(x: N) -> N {
    let value = x.value();
    let power = exp(value);
    let y = value.without_denormals();
    let small = ((y * y) * 0.5 + y).copysign(value);
    let is_small = value.abs().less(value.of(0.03));
    x.chain(N::Real::choose(is_small, small, power - 1.0), || power)
}

/// The derivative of a logarithm: 1 / (x times `factor`), and 0 where the logarithm is clamped.
#[inline(always)]
fn slope_of_log<R: Real>(x: R, factor: f32) -> R {
    let scaled = x * factor;
    R::choose(scaled.less(x.of(f32::MIN_POSITIVE)), x.of(0.0), x.of(1.0) / scaled)
}

/// Logarithm to base 2.
#[inline(always)]
pub fn log2<N: Number>(x: N) -> N {
    x.chain(log2_value(x.value()), || slope_of_log(x.value(), LN_2))
}

/// Natural logarithm.
#[inline(always)]
pub fn log<N: Number>(x: N) -> N {
    x.chain(log2_value(x.value()) * LN_2, || slope_of_log(x.value(), 1.0))
}

/// Logarithm to base 10.
#[inline(always)]
pub fn log10<N: Number>(x: N) -> N {
    x.chain(log2_value(x.value()) * LOG10_2, || slope_of_log(x.value(), LN_10))
}

/// The exponent of the absolute value, as a float; it has no derivative.
#[inline(always)]
pub fn logb<R: Real>(x: R) -> R {
    let bits = x.abs().clamped(f32::MIN_POSITIVE, f32::MAX).bits();
    R::from_int((bits >> 23) + (-127_i32 as u32))
}

/// x^y of values: 1 where y is 0, else 0 where x is 0 or where x is negative and y is no whole number.
#[inline(always)]
fn pow_value<R: Real>(x: R, y: R) -> R {
    let (zero, one, largest) = (x.of(0.0), x.of(1.0), x.of(f32::MAX));
    let power = exp2_value(y * log2_value(x.abs()));
    // All floats from here on are even whole numbers.
    let small = y.abs().less(x.of(16_777_216.0));
    let odd = small & (y.to_int() & 1).equal(1);
    let broken = small & !y.trunc().equal(y);
    let of_negative = R::choose(broken, zero, R::choose(odd, -power, power));
    let square = x * x;
    let square = R::choose(largest.less(square), largest, square);
    let result = R::choose(x.less(zero), of_negative, power);
    let result = R::choose(y.equal(x.of(2.0)), square, result);
    let result = R::choose(y.equal(one), x, result);
    let result = R::choose(x.equal(zero), zero, result);
    R::choose(y.equal(zero), one, result)
}

/// x^y: 1 where y is 0, else 0 where x is 0 or where x is negative and y is no whole number.
#[inline(always)]
pub fn pow<N: Number>(x: N, y: N) -> N {
    let (u, v) = (x.value(), y.value());
    let value = pow_value(u, v);
    x.chain2(
        y,
        value,
        #[inline(always)]
        || {
            let zero = u.of(0.0);
            let log = N::Real::choose(zero.less(u), log(u), zero);
            (v * pow_value(u, v - 1.0), log * value)
        },
    )
}

/// The error function of values.
#[inline(always)]
fn erf_value<R: Real>(x: R) -> R {
    let b = x.abs().without_denormals();
    let r = b * 4.306_38e-5 + 0.000_276_567_2;
    let r = r * b + 0.000_152_014_3;
    let r = r * b + 0.009_270_527;
    let r = r * b + 0.042_282_01;
    let r = r * b + 0.070_523_076;
    let r = r * b + 1.0;
    let r2 = r * r;
    let r4 = r2 * r2;
    let r8 = r4 * r4;
    let one = x.of(1.0);
    (one - one / (r8 * r8)).copysign(x)
}

/// The slope of the error function.
#[inline(always)]
fn slope_of_erf<R: Real>(x: R) -> R {
    exp(-x * x) * FRAC_2_SQRT_PI
}

/// The error function.
#[inline(always)]
pub fn erf<N: Number>(x: N) -> N {
    x.chain(erf_value(x.value()), || slope_of_erf(x.value()))
}

/// 1 less the error function.
#[inline(always)]
pub fn erfc<N: Number>(x: N) -> N {
    let value = erf_value(x.value());
    x.chain(value.of(1.0) - value, || -slope_of_erf(x.value()))
}
