// SPDX-License-Identifier: GPL-3.0-or-later
//! The few lane operations that the library lacks or spells long.
//! Source: original. Proof: `tests::loads_pad_and_selects_choose`.

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};

/// Loads up to 8 values; lanes past the end of `values` hold `padding`.
#[inline(always)]
pub fn load_or<S: Simd>(simd: S, values: &[f32], padding: f32) -> f32x8<S> {
    if values.len() >= 8 {
        f32x8::from_slice(simd, &values[..8])
    } else {
        let mut lanes = [padding; 8];
        lanes[..values.len()].copy_from_slice(values);
        f32x8::from_slice(simd, &lanes)
    }
}

/// Lane by lane: `a` where `mask` is set, else `b`.
#[inline(always)]
pub fn select<S: Simd>(mask: mask32x8<S>, a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    mask.select(a, b)
}

/// The value of one lane; `i < 8`.
#[inline(always)]
pub fn lane<S: Simd>(value: f32x8<S>, i: usize) -> f32 {
    value.as_array()[i & 7]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Level;

    #[inline(always)]
    fn choose<S: Simd>(simd: S, values: &[f32]) -> [f32; 8] {
        let loaded = load_or(simd, values, 9.0);
        let big = loaded.simd_gt(f32x8::splat(simd, 2.0));
        assert_eq!(lane(loaded, 1), 2.0, "lane 1 is the second value");
        select(big, loaded, f32x8::splat(simd, 0.0)).to_array()
    }

    #[test]
    fn loads_pad_and_selects_choose() {
        for level in Level::available() {
            let few = crate::dispatch!(level, simd => choose(simd, &[1.0, 2.0, 3.0]));
            assert_eq!(few, [0.0, 0.0, 3.0, 9.0, 9.0, 9.0, 9.0, 9.0], "padding at {level}");
            let many =
                crate::dispatch!(level, simd => choose(simd, &[3.0, 2.0, 4.0, 1.0, 5.0, 0.0, 6.0, 7.0, 8.0]));
            assert_eq!(many, [3.0, 0.0, 4.0, 0.0, 5.0, 0.0, 6.0, 7.0], "a full register at {level}");
        }
    }
}
