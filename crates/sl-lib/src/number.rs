// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of the library's functions: a float, its substitute while a shader is compiled, or either with
//! derivatives. [`Real`] is a float or its substitute; [`Number`] is that or a [`Dual`](crate::Dual) of it. A
//! function that takes any [`Number`] is written once and serves the interpreter, derivatives and machine
//! code for lanes.
//! Invariant: an operation gives the same bits by itself and in lanes; nothing is fused.
//! Tests: the tests of `gnurt-jit`.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

/// The operators that every number has.
pub trait Arithmetic:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
{
}

impl<T> Arithmetic for T where
    T: Copy
        + Neg<Output = Self>
        + Add<Output = Self>
        + Sub<Output = Self>
        + Mul<Output = Self>
        + Div<Output = Self>
        + Add<f32, Output = Self>
        + Sub<f32, Output = Self>
        + Mul<f32, Output = Self>
{
}

/// 32-bit words: hashes and the bits of floats. Sums and differences wrap.
pub trait UInts:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + BitXor<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + Add<u32, Output = Self>
    + BitXor<u32, Output = Self>
    + BitAnd<u32, Output = Self>
    + BitOr<u32, Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// The result of a comparison.
    type Mask: Mask;

    /// `x`, as one of these.
    fn constant(self, x: u32) -> Self;
    /// Which are equal to `x`.
    fn equal(self, x: u32) -> Self::Mask;
    /// Which are below `x`, without signs.
    fn below(self, x: u32) -> Self::Mask;
    /// `a` where the mask is set, else `b`.
    fn pick(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Bit `self` of `bits`: 0 or 1. The bit numbers are below 32.
    fn bit_of(self, bits: u32) -> Self;
    /// The remainder in `[0, period)` of signed division; periods are at least 1.
    fn wrapped(self, period: Self) -> Self;
    /// The larger of each pair, with signs.
    fn signed_max(self, other: Self) -> Self;
    /// The smaller of each pair, with signs.
    fn signed_min(self, other: Self) -> Self;
    /// Which are greater than the other's, with signs.
    fn above(self, other: Self) -> Self::Mask;
    /// Which are the other's.
    fn same(self, other: Self) -> Self::Mask;
    /// Products, which wrap.
    fn product(self, other: Self) -> Self;
    /// Quotients with signs; 0 where the divisor is 0.
    fn quotient(self, other: Self) -> Self;
    /// Remainders with the signs of the dividends; 0 where the divisor is 0.
    fn remainder(self, other: Self) -> Self;
    /// Bits moved up by the lowest five bits of another.
    fn moved_up(self, by: Self) -> Self;
    /// Bits moved down, the sign following.
    fn moved_down(self, by: Self) -> Self;

    /// The bits rotated to the left.
    #[inline(always)]
    fn rotated(self, by: u32) -> Self {
        (self << by) | (self >> (32 - by))
    }
}

/// Results of comparisons: a boolean, or its substitute.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {}

impl<T: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>> Mask for T {}

/// A float, or its substitute.
pub trait Real: Arithmetic + Div<f32, Output = Self> {
    /// As many words.
    type UInts: UInts<Mask = Self::Mask>;
    /// As many answers.
    type Mask: Mask;

    /// `x`, as one of these.
    fn of(self, x: f32) -> Self;
    /// Which are less than the other's. NaN never is, here and below.
    fn less(self, other: Self) -> Self::Mask;
    /// Which are at most the other's.
    fn at_most(self, other: Self) -> Self::Mask;
    /// Which equal the other's.
    fn equal(self, other: Self) -> Self::Mask;
    /// `a` where the mask is set, else `b`.
    fn choose(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Without the sign.
    fn abs(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The next whole number at or below.
    fn floor(self) -> Self;
    /// The next whole number at or above.
    fn ceil(self) -> Self;
    /// The next whole number towards zero.
    fn trunc(self) -> Self;
    /// With the sign bit of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// The bits of the floats.
    fn bits(self) -> Self::UInts;
    /// The same for operations on bits: all NaNs get the bits of one, because the bits of a NaN result are
    /// unspecified.
    #[inline(always)]
    fn known_bits(self) -> Self::UInts {
        Self::choose(self.equal(self), self, self.of(f32::NAN)).bits()
    }
    /// The floats with these bits.
    fn from_bits(bits: Self::UInts) -> Self;
    /// Signed whole numbers, rounded towards zero; out of range the nearest, 0 for NaN.
    fn to_int(self) -> Self::UInts;
    /// The floats nearest to signed whole numbers.
    fn from_int(x: Self::UInts) -> Self;
    /// The floats nearest to whole numbers without sign.
    fn from_unsigned(x: Self::UInts) -> Self;
    /// Calls large code: for a float out of line, so that callers stay small; during recording, inline.
    fn outline<T>(work: impl FnOnce() -> T) -> T;

    /// `low` where below it or NaN, `high` where above.
    #[inline(always)]
    fn clamped(self, low: f32, high: f32) -> Self {
        let (low, high) = (self.of(low), self.of(high));
        let lowered = Self::choose(self.at_most(high), self, high);
        Self::choose(low.at_most(self), lowered, low)
    }

    /// The next whole number at or below, as an integer.
    #[inline(always)]
    fn floor_int(self) -> Self::UInts {
        let towards_zero = self.to_int();
        let too_high = self.less(Self::from_int(towards_zero));
        Self::UInts::pick(too_high, towards_zero + u32::MAX, towards_zero)
    }

    /// `1 - (1 - self)`, which makes zeros of numbers too small for half precision of one.
    #[inline(always)]
    fn without_denormals(self) -> Self {
        let one = self.of(1.0);
        one - (one - self)
    }
}

/// A [`Real`], or one with derivatives.
pub trait Number: Arithmetic {
    /// The kind of value.
    type Real: Real<Mask = Self::Mask>;
    /// The result of a comparison of values.
    type Mask: Mask;

    /// Without derivatives.
    fn value(self) -> Self::Real;
    /// With derivatives of zero.
    fn lift(value: Self::Real) -> Self;
    /// A function of this, by its value and, where there are derivatives, its slope.
    fn chain(self, value: Self::Real, slope: impl FnOnce() -> Self::Real) -> Self;
    /// A function of this and another, by its value and its two slopes.
    fn chain2(
        self,
        other: Self,
        value: Self::Real,
        slopes: impl FnOnce() -> (Self::Real, Self::Real),
    ) -> Self;
    /// `a` where the mask is set, else `b`.
    fn pick(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// With the sign flipped where the lowest bit of a word is set.
    fn negated_where(self, bit: <Self::Real as Real>::UInts) -> Self;
    /// This value with another value and the same derivatives, as after the subtraction of a whole number.
    fn with_value(self, value: Self::Real) -> Self;
    /// Its derivatives, if it has some.
    fn slopes(self) -> Option<[Self::Real; 2]>;
    /// From a value and, where there are derivatives, both of them.
    fn from_parts(value: Self::Real, slopes: impl FnOnce() -> [Self::Real; 2]) -> Self;
    /// Times a number without derivatives.
    fn scaled(self, by: Self::Real) -> Self;

    /// `x`, as one of these.
    #[inline(always)]
    fn constant(self, x: f32) -> Self {
        Self::lift(self.value().of(x))
    }

    /// `x - self`.
    #[inline(always)]
    fn subtracted_from(self, x: f32) -> Self {
        self.constant(x) - self
    }
}

impl<R: Real> Number for R {
    type Real = R;
    type Mask = R::Mask;

    #[inline(always)]
    fn value(self) -> R {
        self
    }

    #[inline(always)]
    fn lift(value: R) -> R {
        value
    }

    #[inline(always)]
    fn chain(self, value: R, _slope: impl FnOnce() -> R) -> R {
        value
    }

    #[inline(always)]
    fn chain2(self, _other: R, value: R, _slopes: impl FnOnce() -> (R, R)) -> R {
        value
    }

    #[inline(always)]
    fn pick(mask: R::Mask, a: R, b: R) -> R {
        R::choose(mask, a, b)
    }

    #[inline(always)]
    fn negated_where(self, bit: R::UInts) -> R {
        R::from_bits(self.bits() ^ (bit << 31))
    }

    #[inline(always)]
    fn with_value(self, value: R) -> R {
        value
    }

    #[inline(always)]
    fn slopes(self) -> Option<[R; 2]> {
        None
    }

    #[inline(always)]
    fn from_parts(value: R, _slopes: impl FnOnce() -> [R; 2]) -> R {
        value
    }

    #[inline(always)]
    fn scaled(self, by: R) -> R {
        self * by
    }
}

/// One word whose sums wrap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UInt(pub u32);

macro_rules! uint_operator {
    ($($trait:ident $method:ident = $operation:expr;)*) => {$(
        impl $trait for UInt {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($operation(self.0, other.0))
            }
        }

        impl $trait<u32> for UInt {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: u32) -> Self {
                Self($operation(self.0, other))
            }
        }
    )*};
}

uint_operator! {
    Add add = u32::wrapping_add;
    Sub sub = u32::wrapping_sub;
    BitXor bitxor = |a, b| a ^ b;
    BitAnd bitand = |a, b| a & b;
    BitOr bitor = |a, b| a | b;
    Shl shl = |a: u32, b| a << b;
    Shr shr = |a: u32, b| a >> b;
}

impl UInts for UInt {
    type Mask = bool;

    #[inline(always)]
    fn constant(self, x: u32) -> Self {
        Self(x)
    }

    #[inline(always)]
    fn equal(self, x: u32) -> bool {
        self.0 == x
    }

    #[inline(always)]
    fn below(self, x: u32) -> bool {
        self.0 < x
    }

    #[inline(always)]
    fn pick(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }

    #[inline(always)]
    fn bit_of(self, bits: u32) -> Self {
        Self((bits >> self.0) & 1)
    }

    #[inline(always)]
    fn wrapped(self, period: Self) -> Self {
        Self((self.0 as i32).rem_euclid(period.0 as i32) as u32)
    }

    #[inline(always)]
    fn signed_max(self, other: Self) -> Self {
        Self((self.0 as i32).max(other.0 as i32) as u32)
    }

    #[inline(always)]
    fn signed_min(self, other: Self) -> Self {
        Self((self.0 as i32).min(other.0 as i32) as u32)
    }

    #[inline(always)]
    fn above(self, other: Self) -> bool {
        self.0 as i32 > other.0 as i32
    }

    #[inline(always)]
    fn same(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn product(self, other: Self) -> Self {
        Self(self.0.wrapping_mul(other.0))
    }

    #[inline(always)]
    fn quotient(self, other: Self) -> Self {
        let (a, b) = (self.0 as i32, other.0 as i32);
        Self(if b == 0 { 0 } else { a.wrapping_div(b) as u32 })
    }

    #[inline(always)]
    fn remainder(self, other: Self) -> Self {
        let (a, b) = (self.0 as i32, other.0 as i32);
        Self(if b == 0 { 0 } else { a.wrapping_rem(b) as u32 })
    }

    #[inline(always)]
    fn moved_up(self, by: Self) -> Self {
        Self(self.0.wrapping_shl(by.0))
    }

    #[inline(always)]
    fn moved_down(self, by: Self) -> Self {
        Self((self.0 as i32).wrapping_shr(by.0) as u32)
    }

    #[inline(always)]
    fn rotated(self, by: u32) -> Self {
        Self(self.0.rotate_left(by))
    }
}

impl Real for f32 {
    type UInts = UInt;
    type Mask = bool;

    #[inline(always)]
    fn of(self, x: f32) -> f32 {
        x
    }

    #[inline(always)]
    fn less(self, other: f32) -> bool {
        self < other
    }

    #[inline(always)]
    fn at_most(self, other: f32) -> bool {
        self <= other
    }

    #[inline(always)]
    fn equal(self, other: f32) -> bool {
        self == other
    }

    #[inline(always)]
    fn choose(mask: bool, a: f32, b: f32) -> f32 {
        if mask { a } else { b }
    }

    #[inline(always)]
    fn abs(self) -> f32 {
        f32::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> f32 {
        f32::sqrt(self)
    }

    #[inline(always)]
    fn floor(self) -> f32 {
        f32::floor(self)
    }

    #[inline(always)]
    fn ceil(self) -> f32 {
        f32::ceil(self)
    }

    #[inline(always)]
    fn trunc(self) -> f32 {
        f32::trunc(self)
    }

    #[inline(always)]
    fn copysign(self, sign: f32) -> f32 {
        f32::copysign(self, sign)
    }

    #[inline(always)]
    fn bits(self) -> UInt {
        UInt(self.to_bits())
    }

    #[inline(always)]
    fn from_bits(bits: UInt) -> f32 {
        f32::from_bits(bits.0)
    }

    #[inline(always)]
    fn to_int(self) -> UInt {
        UInt(self as i32 as u32)
    }

    #[inline(always)]
    fn from_int(x: UInt) -> f32 {
        x.0 as i32 as f32
    }

    #[inline(always)]
    fn from_unsigned(x: UInt) -> f32 {
        x.0 as f32
    }

    #[inline(never)]
    fn outline<T>(work: impl FnOnce() -> T) -> T {
        work()
    }
}
