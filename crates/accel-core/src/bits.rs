// SPDX-License-Identifier: GPL-3.0-or-later
//! Sets of a tile's rays as bits of a word. Tests: `tests::bits_are_numbered`.

/// Rays per tile: one bit each in a word.
pub const TILE: usize = 64;

/// The lowest `count` bits; `count` is at most 64.
#[inline(always)]
pub fn all(count: usize) -> u64 {
    if count == TILE { u64::MAX } else { (1 << count) - 1 }
}

/// Calls `f` with the position of every set bit.
#[inline(always)]
pub fn each(mut bits: u64, mut f: impl FnMut(usize)) {
    while bits != 0 {
        f(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_numbered() {
        assert_eq!([all(0), all(3), all(64)], [0, 7, u64::MAX], "so many bits");
        let mut numbers = Vec::new();
        each(1 << 63 | 0b1001, |number| numbers.push(number));
        assert_eq!(numbers, [0, 3, 63], "lowest first");
    }
}
