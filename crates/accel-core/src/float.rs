// SPDX-License-Identifier: GPL-3.0-or-later
//! Floats one by one and in lanes, for arithmetic that is written once for both.
//! Invariant: a function over [`Number`] gives a lane the bits that it gives a float.
//! Tests: `tests::lanes_do_what_floats_do`.

use std::ops::{Add, Div, Mul, Sub};

use gnurt_simd::{Simd, f32x8, f32x16, f64x8, prelude::*};

/// Components of a direction are at least this much of the longest.
pub const FLATTEST: f32 = 1.0 / (1 << 30) as f32;

/// The lesser of two numbers, neither of them NaN: one instruction, unlike `f32::min`.
#[inline(always)]
pub fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater of two numbers, neither of them NaN.
#[inline(always)]
pub fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// A float, or several in lanes; none of them NaN.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Without its sign.
    fn size(self) -> Self;
    /// The greater one.
    fn or_more(self, other: Self) -> Self;
    /// With the sign of `other`.
    fn signed_as(self, other: Self) -> Self;
}

macro_rules! floats_are_numbers {
    ($($float:ident)*) => {$(
        impl Number for $float {
            #[inline(always)]
            fn size(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn or_more(self, other: Self) -> Self {
                if self > other { self } else { other }
            }

            #[inline(always)]
            fn signed_as(self, other: Self) -> Self {
                self.copysign(other)
            }
        }
    )*};
}

floats_are_numbers!(f32 f64);

macro_rules! lanes_are_numbers {
    ($($lanes:ident)*) => {$(
        impl<S: Simd> Number for $lanes<S> {
            #[inline(always)]
            fn size(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn or_more(self, other: Self) -> Self {
                self.max(other)
            }

            #[inline(always)]
            fn signed_as(self, other: Self) -> Self {
                self.copysign(other)
            }
        }
    )*};
}

lanes_are_numbers!(f32x8 f32x16 f64x8);

#[cfg(test)]
mod tests {
    use gnurt_simd::{Level, dispatch};

    use super::*;

    #[test]
    fn lanes_do_what_floats_do() {
        let (a, b) = (-3.5f32, 0.25f32);
        for level in Level::available() {
            let lanes = dispatch!(level, simd => {
                let (x, y) = (f32x8::splat(simd, a), f32x8::splat(simd, b));
                [x.size()[7], x.or_more(y)[7], y.signed_as(x)[7]]
            });
            assert_eq!(lanes, [a.size(), a.or_more(b), b.signed_as(a)], "at {level}");
        }
    }
}
