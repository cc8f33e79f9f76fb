// SPDX-License-Identifier: GPL-3.0-or-later
//! [`Draws`](super::Draws) for sixteen samples at once.
//! Source: as `sobol`, whose numbers these are, bit for bit. Differs: reversals of words are slow in lanes,
//! and most reversals of the scalar form cancel each other.
//! Tests: `tests::the_same_numbers`.

use gnurt_simd::{Simd, f32x16, prelude::*, u32x16};

use super::hash::mix;
use super::sobol::THIRD;
use crate::batch::SampleKey;
use crate::lanes::{Floats, LANES, UInts};

/// All pairs of sixteen samples.
#[derive(Clone, Copy, Debug)]
pub struct DrawsX16<S: Simd> {
    /// The number of the sample within its pixel, bit-reversed.
    sample: UInts<S>,
    /// Hash of all but the purpose.
    set: UInts<S>,
}

impl<S: Simd> DrawsX16<S> {
    /// Those of these samples; see [`SampleKey`](crate::SampleKey).
    #[inline(always)]
    #[must_use]
    pub fn new(simd: S, seed: u64, [pixel, sample, branch]: [UInts<S>; 3], depth: UInts<S>) -> Self {
        let seeded = [seed as u32, (seed >> 32) as u32].into_iter().fold(0x9e37_79b9, super::hash_combine);
        let mut set = u32x16::splat(simd, seeded);
        for value in [pixel, branch, depth] {
            set = combine(set, mix_lanes(value + 0x9e37_79b9));
        }
        Self { sample: reverse(sample), set }
    }

    /// The hash for a purpose, and the shuffled number of the sample.
    #[inline(always)]
    fn shuffled(self, purpose: u32) -> (UInts<S>, UInts<S>) {
        let set = combine_known(self.set, purpose);
        (set, reverse(owen(self.sample + set)))
    }

    /// The pair for this [`purpose`](super::purpose).
    #[inline(always)]
    #[must_use]
    pub fn pair(self, purpose: u32) -> [Floats<S>; 2] {
        let (set, index) = self.shuffled(purpose);
        [scrambled(index, set, 1), scrambled(second_dimension(index), set, 2)]
    }

    /// The same pair and a third number: see [`Draws::triple`](super::Draws::triple).
    #[inline(always)]
    #[must_use]
    pub fn triple(self, purpose: u32) -> [Floats<S>; 3] {
        let (set, index) = self.shuffled(purpose);
        let mut third = u32x16::splat(index.token(), 0);
        for (k, column) in THIRD.into_iter().enumerate() {
            third ^= ((index >> k as u32) & 1) * column;
        }
        [scrambled(index, set, 1), scrambled(second_dimension(index), set, 2), scrambled(third, set, 3)]
    }
}

/// [`sample_pair`](super::sample_pair) of many keys; `out` gets as many pairs.
#[inline(always)]
pub fn sample_pairs<S: Simd>(
    simd: S,
    seed: u64,
    keys: &[SampleKey],
    depth: u32,
    purpose: u32,
    out: &mut Vec<[f32; 2]>,
) {
    out.clear();
    for some in keys.chunks(LANES) {
        let draws = DrawsX16::new(simd, seed, key_values(simd, some), u32x16::splat(simd, depth));
        let [x, y] = draws.pair(purpose);
        for i in 0..some.len().min(LANES) {
            out.push([x[i], y[i]]);
        }
    }
}

/// Pixels, samples and branches of the first sixteen keys; zeros where there are fewer.
#[inline(always)]
pub fn key_values<S: Simd>(simd: S, keys: &[SampleKey]) -> [UInts<S>; 3] {
    let mut values = [[0; LANES]; 3];
    for (i, key) in keys.iter().take(LANES).enumerate() {
        (values[0][i], values[1][i], values[2][i]) = (key.pixel, key.sample, key.branch);
    }
    let [pixels, samples, branches] = &values;
    [u32x16::from_slice(simd, pixels), u32x16::from_slice(simd, samples), u32x16::from_slice(simd, branches)]
}

/// `hash_combine` of `a` and a word that is mixed already.
#[inline(always)]
fn combine<S: Simd>(a: UInts<S>, mixed: UInts<S>) -> UInts<S> {
    mix_lanes(a ^ (mixed + (a << 6) + (a >> 2)))
}

/// `hash_combine` with a word that all lanes share.
#[inline(always)]
fn combine_known<S: Simd>(a: UInts<S>, b: u32) -> UInts<S> {
    combine(a, u32x16::splat(a.token(), mix(b.wrapping_add(0x9e37_79b9))))
}

#[inline(always)]
fn mix_lanes<S: Simd>(x: UInts<S>) -> UInts<S> {
    let x = x ^ (x >> 16);
    let x = x * 0x21f0_aaad;
    let x = x ^ (x >> 15);
    let x = x * 0xd35a_2d97;
    x ^ (x >> 15)
}

/// The second coordinate of a Sobol' point, bit-reversed.
#[inline(always)]
fn second_dimension<S: Simd>(index: UInts<S>) -> UInts<S> {
    let mut sums = index;
    for (shift, mask) in
        [(1, 0x5555_5555), (2, 0x3333_3333), (4, 0x0f0f_0f0f), (8, 0x00ff_00ff), (16, 0x0000_ffff)]
    {
        sums ^= (sums >> shift) & mask;
    }
    sums
}

/// A bit-reversed coordinate, scrambled by the set's hash with `n`, as a number in [0, 1).
#[inline(always)]
fn scrambled<S: Simd>(turned: UInts<S>, set: UInts<S>, n: u32) -> Floats<S> {
    let value = reverse(owen(turned + combine_known(set, n))) >> 8;
    Floats::<S>::float_from(value) * f32x16::splat(turned.token(), 1.0 / 16_777_216.0)
}

/// The steps of `owen_scramble` between its two reversals, except for the first sum.
#[inline(always)]
fn owen<S: Simd>(mut x: UInts<S>) -> UInts<S> {
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        x ^= x * factor;
    }
    x
}

/// The bits of each word, last one first.
#[inline(always)]
fn reverse<S: Simd>(mut x: UInts<S>) -> UInts<S> {
    for (shift, mask) in [(1, 0x5555_5555), (2, 0x3333_3333), (4, 0x0f0f_0f0f), (8, 0x00ff_00ff)] {
        x = ((x >> shift) & mask) | ((x & mask) << shift);
    }
    (x >> 16) | (x << 16)
}

#[cfg(test)]
mod tests {
    use super::super::{Draws, purpose};
    use super::*;
    use gnurt_simd::{Level, dispatch_wide};

    type Pairs = [[f32; 2]; 3];

    #[inline(always)]
    fn in_lanes<S: Simd>(simd: S, seed: u64, keys: &[SampleKey; LANES], depth: u32) -> [Pairs; LANES] {
        let draws = DrawsX16::new(simd, seed, key_values(simd, keys), u32x16::splat(simd, depth));
        let (light, direction) = (draws.pair(purpose::LIGHT_POSITION), draws.pair(purpose::DIRECTION));
        let choice = draws.pair(purpose::CHOICE);
        std::array::from_fn(|i| [light, direction, choice].map(|pair| pair.map(|numbers| numbers[i])))
    }

    #[inline(always)]
    fn triples_in_lanes<S: Simd>(
        simd: S,
        seed: u64,
        keys: &[SampleKey; LANES],
        depth: u32,
    ) -> [[f32; 3]; LANES] {
        let draws = DrawsX16::new(simd, seed, key_values(simd, keys), u32x16::splat(simd, depth));
        let triple = draws.triple(purpose::DIRECTION);
        std::array::from_fn(|i| triple.map(|numbers| numbers[i]))
    }

    #[test]
    fn the_same_numbers() {
        for round in 0..64_u32 {
            let (seed, depth) = (u64::from(round) * 0x1_2345_6789, round % 11);
            let keys = std::array::from_fn(|i| {
                let pixel = round * 977 + i as u32;
                SampleKey {
                    pixel,
                    sample: pixel.wrapping_mul(2_654_435_761) >> (round % 32),
                    branch: round / 2,
                }
            });
            let found =
                dispatch_wide!(Level::default(), simd => in_lanes(simd, seed, &keys, depth), else return);
            let triples = dispatch_wide!(Level::default(), simd => triples_in_lanes(simd, seed, &keys, depth), else return);
            for (number, (key, found)) in keys.into_iter().zip(found).enumerate() {
                let draws = Draws::new(seed, key, depth);
                let expected =
                    [purpose::LIGHT_POSITION, purpose::DIRECTION, purpose::CHOICE].map(|p| draws.pair(p));
                assert_eq!(found, expected, "{key:?}");
                let three = draws.triple(purpose::DIRECTION);
                assert_eq!((&three[..2], triples[number]), (&expected[1][..], three), "{key:?}");
            }
            let some = &keys[..1 + round as usize % LANES];
            let mut pairs = vec![[7.0; 2]];
            dispatch_wide!(Level::default(), simd => sample_pairs(simd, seed, some, depth, purpose::PIXEL, &mut pairs), else return);
            let expected: Vec<_> =
                some.iter().map(|&key| super::super::sample_pair(seed, key, depth, purpose::PIXEL)).collect();
            assert_eq!(pairs, expected, "{} at once", some.len());
        }
    }
}
