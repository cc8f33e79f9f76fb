// SPDX-License-Identifier: GPL-3.0-or-later
//! Sixteen lanes as a [`Real`], so that every function of the library has a wide form.
//! Source: original. Invariant: as in `number`; conversions to whole numbers saturate in lanes as they do alone.
//! Proof: `tests/lanes.rs`.

use gnurt_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};

use crate::number::{Real, Words};

/// How many points are shaded at once.
pub const LANES: usize = 16;

impl<S: Simd> Words for u32x16<S> {
    type Mask = mask32x16<S>;

    #[inline(always)]
    fn constant(self, x: u32) -> Self {
        Self::splat(self.token(), x)
    }

    #[inline(always)]
    fn equal(self, x: u32) -> mask32x16<S> {
        self.simd_eq(x)
    }

    #[inline(always)]
    fn below(self, x: u32) -> mask32x16<S> {
        self.simd_lt(x)
    }

    #[inline(always)]
    fn pick(mask: mask32x16<S>, a: Self, b: Self) -> Self {
        mask.select(a, b)
    }

    #[inline(always)]
    fn bit_of(self, bits: u32) -> Self {
        (self.constant(bits) >> self) & 1
    }

    #[inline(always)]
    fn wrapped(self, period: Self) -> Self {
        // No CPU divides whole numbers in lanes.
        let mut out = [0; LANES];
        for (i, out) in out.iter_mut().enumerate() {
            *out = (self[i] as i32).rem_euclid(period[i] as i32) as u32;
        }
        Self::from_slice(self.token(), &out)
    }

    #[inline(always)]
    fn signed_max(self, other: Self) -> Self {
        let (a, b): (i32x16<S>, i32x16<S>) = (self.bitcast(), other.bitcast());
        a.max(b).bitcast()
    }
}

impl<S: Simd> Real for f32x16<S> {
    type Words = u32x16<S>;
    type Mask = mask32x16<S>;

    #[inline(always)]
    fn of(self, x: f32) -> Self {
        Self::splat(self.token(), x)
    }

    #[inline(always)]
    fn less(self, other: Self) -> mask32x16<S> {
        self.simd_lt(other)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> mask32x16<S> {
        self.simd_le(other)
    }

    #[inline(always)]
    fn equal(self, other: Self) -> mask32x16<S> {
        self.simd_eq(other)
    }

    #[inline(always)]
    fn choose(mask: mask32x16<S>, a: Self, b: Self) -> Self {
        mask.select(a, b)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        <Self as SimdBase<S>>::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        <Self as SimdFloat<S>>::sqrt(self)
    }

    #[inline(always)]
    fn floor(self) -> Self {
        <Self as SimdFloat<S>>::floor(self)
    }

    #[inline(always)]
    fn ceil(self) -> Self {
        <Self as SimdFloat<S>>::ceil(self)
    }

    #[inline(always)]
    fn trunc(self) -> Self {
        <Self as SimdFloat<S>>::trunc(self)
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        <Self as SimdFloat<S>>::copysign(self, sign)
    }

    #[inline(always)]
    fn bits(self) -> u32x16<S> {
        self.bitcast()
    }

    #[inline(always)]
    fn from_bits(bits: u32x16<S>) -> Self {
        bits.bitcast()
    }

    #[inline(always)]
    fn to_int(self) -> u32x16<S> {
        i32x16::truncate_from_precise(self).bitcast()
    }

    #[inline(always)]
    fn from_int(x: u32x16<S>) -> Self {
        let x: i32x16<S> = x.bitcast();
        Self::float_from(x)
    }

    #[inline(always)]
    fn from_unsigned(x: u32x16<S>) -> Self {
        Self::float_from(x)
    }

    #[inline(always)]
    fn apart<T>(work: impl FnOnce() -> T) -> T {
        work()
    }
}
