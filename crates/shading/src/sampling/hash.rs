// SPDX-License-Identifier: GPL-3.0-or-later
//! Hashing of words into words, for random numbers that are functions of a key. Source: [Bur20].
//! Tests: the tests of `sobol`.

/// A well-mixed function of two words.
#[must_use]
#[inline]
pub fn hash_combine(a: u32, b: u32) -> u32 {
    mix(a ^ mix(b.wrapping_add(0x9e37_79b9)).wrapping_add(a << 6).wrapping_add(a >> 2))
}

/// A bijection of words in which every input bit reaches every output bit.
#[inline]
pub(super) fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x21f0_aaad);
    x ^= x >> 15;
    x = x.wrapping_mul(0xd35a_2d97);
    x ^ (x >> 15)
}
