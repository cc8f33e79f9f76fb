// SPDX-License-Identifier: GPL-3.0-or-later
//! Sobol' points in two dimensions, shuffled and scrambled by hashes: random numbers as a pure function of a
//! key.
//! Source: [Bur20] (hash-based Owen scrambling and shuffling, padding of 2D sets); Owen [Owe95]; the two dimensions are
//! those of [Sob67]. Differs: the key holds pixel, path branch, depth and purpose.
//! Invariant: for a fixed key and purpose, samples 0..2^k are a (0, 2)-sequence: each elementary interval of area 2^-k
//! holds exactly one. Tests: `tests::{every_elementary_interval_holds_one, purposes_and_seeds_are_independent}`.

use super::hash::hash_combine;
use crate::batch::SampleKey;

/// Purposes of pairs of random numbers: two users of one key and depth must have different ones.
pub mod purpose {
    /// Position within the pixel.
    pub const PIXEL: u32 = 0;
    /// Direction of a scattered ray, and the choice of the lobe that it is drawn from.
    pub const DIRECTION: u32 = 1;
    /// Choice between mirrored and refracted; whether a path goes on.
    pub const CHOICE: u32 = 2;
    /// Choice of a light, and the position on it.
    pub const LIGHT_POSITION: u32 = 3;
    /// Whether a surface that is there in part is met.
    pub const COVERAGE: u32 = 5;
    /// Position on the camera's lens.
    pub const LENS: u32 = 6;
    /// Time within which the shutter is open.
    pub const TIME: u32 = 7;
    /// Flight through a medium.
    pub const FLIGHT: u32 = 8;
    /// A distance in a medium by the angle at which a lamp is seen.
    pub const LAMP_DISTANCE: u32 = 9;
    /// Choice of a lamp behind smooth surfaces, and whether to search for it.
    pub const CAUSTIC: u32 = 10;
    /// Position on that lamp.
    pub const CAUSTIC_POSITION: u32 = 11;
    /// A distance in a medium that a flight passed: a forced collision.
    pub const FORCED_DISTANCE: u32 = 12;
    /// Choice of a light of the first group, and the position on it, where groups are sampled one by one; group i has
    /// `LIGHT_GROUP + i`.
    pub const LIGHT_GROUP: u32 = 0x10;
    /// First pair of a walk below a surface; pair i has `WALK + i`.
    pub const WALK: u32 = 0x40;
    /// First of those for shaders outside of this crate.
    pub const SHADER: u32 = 0x100;
    /// Point on light 0; light i has `LIGHT + i`.
    pub const LIGHT: u32 = 0x1000_0000;
}

/// Two numbers in [0, 1) for one sample, stratified over the samples of its pixel.
#[must_use]
pub fn sample_pair(seed: u64, key: SampleKey, depth: u32, purpose: u32) -> [f32; 2] {
    Draws::new(seed, key, depth).pair(purpose)
}

/// All pairs of one sample at one depth: cheaper than [`sample_pair`] where several are needed.
#[derive(Clone, Copy, Debug)]
pub struct Draws {
    sample: u32,
    /// Hash of all but the purpose.
    set: u32,
}

impl Draws {
    /// Those of this sample.
    #[must_use]
    #[inline]
    pub fn new(seed: u64, key: SampleKey, depth: u32) -> Self {
        let values = [seed as u32, (seed >> 32) as u32, key.pixel, key.branch, depth];
        Self { sample: key.sample, set: values.into_iter().fold(0x9e37_79b9, hash_combine) }
    }

    /// A hash of the whole key and further words: the beginning of numbers that are not stratified.
    #[must_use]
    #[inline]
    pub fn hash(self, more: [u32; 2]) -> u32 {
        [self.sample].into_iter().chain(more).fold(self.set, hash_combine)
    }

    /// The hash for a purpose, and the index of the sample in its sequence.
    #[inline]
    fn shuffled(self, purpose: u32) -> (u32, u32) {
        let set = hash_combine(self.set, purpose);
        // Shuffling the order keeps every aligned block of 2^k samples together, so progressive pictures stay stratified.
        (set, owen_scramble(self.sample, set))
    }

    /// The pair for this [`purpose`].
    #[must_use]
    #[inline]
    pub fn pair(self, purpose: u32) -> [f32; 2] {
        let (set, index) = self.shuffled(purpose);
        let [x, y] = sobol(index);
        [owen_scramble(x, hash_combine(set, 1)), owen_scramble(y, hash_combine(set, 2))].map(unit_interval)
    }

    /// The same pair, and a third number: samples whose third number is in one half, or quarter, are stratified as pairs
    /// too. For a choice, and for what is drawn after it.
    #[must_use]
    #[inline]
    pub fn triple(self, purpose: u32) -> [f32; 3] {
        let [x, y] = self.pair(purpose);
        let (set, index) = self.shuffled(purpose);
        let turned = THIRD.iter().enumerate().fold(0, |sum, (k, &column)| sum ^ ((index >> k & 1) * column));
        [x, y, unit_interval(owen_scramble(turned.reverse_bits(), hash_combine(set, 3)))]
    }
}

/// Columns of the third dimension's matrix, bit-reversed.
pub(super) const THIRD: [u32; 32] = third_dimension();

/// Of the polynomial x² + x + 1 with the first numbers 1 and 3 \[JK08\].
const fn third_dimension() -> [u32; 32] {
    let mut m = [0_u64; 32];
    (m[0], m[1]) = (1, 3);
    let mut columns = [0; 32];
    let mut k = 0;
    while k < 32 {
        if k >= 2 {
            m[k] = (2 * m[k - 1]) ^ (4 * m[k - 2]) ^ m[k - 2];
        }
        columns[k] = ((m[k] << (31 - k)) as u32).reverse_bits();
        k += 1;
    }
    columns
}

/// Point `index` of the two-dimensional Sobol' sequence, as fractions of 2^32.
#[inline]
fn sobol(index: u32) -> [u32; 2] {
    // Columns of the second dimension's matrix are the rows of Pascal's triangle modulo 2. By Lucas, bit j of
    // the mirrored number is the sum of all bits of the index whose position holds the bits of j: a sum whose
    // reach doubles.
    let mut sums = index;
    for (shift, mask) in
        [(1, 0x5555_5555), (2, 0x3333_3333), (4, 0x0f0f_0f0f), (8, 0x00ff_00ff), (16, 0x0000_ffff)]
    {
        sums ^= (sums >> shift) & mask;
    }
    [index.reverse_bits(), sums.reverse_bits()]
}

/// Permutes the tree of nested halves: each bit is flipped by a hash of the bits above it.
#[inline]
fn owen_scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits().wrapping_add(seed);
    // In a product with an even number each bit only reaches higher bits; reversed, only lower ones.
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

/// The upper 24 bits as a number in [0, 1): all that a float can hold below 1.
fn unit_interval(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::hash::mix;

    fn key(pixel: u32, sample: u32) -> SampleKey {
        SampleKey { pixel, sample, branch: 0 }
    }

    #[test]
    fn every_elementary_interval_holds_one() {
        for pixel in [0, 1, 77] {
            for log in 0..=10 {
                let n = 1_u32 << log;
                // Any aligned block of 2^log samples, not only the first one.
                let first = n * 3;
                let points: Vec<_> =
                    (first..first + n).map(|s| sample_pair(9, key(pixel, s), 2, 5)).collect();
                for columns_log in 0..=log {
                    let (columns, rows) = (1_u32 << columns_log, 1_u32 << (log - columns_log));
                    let mut occupied = vec![false; n as usize];
                    for [x, y] in &points {
                        let cell = (y * rows as f32) as u32 * columns + (x * columns as f32) as u32;
                        assert!(!occupied[cell as usize], "two points in one of {columns} x {rows} cells");
                        occupied[cell as usize] = true;
                    }
                }
            }
        }
    }

    /// Any aligned block of samples has as many third numbers in each half, quarter and so on; and each half of them is
    /// stratified in the other two numbers.
    #[test]
    fn choices_leave_stratified_pairs() {
        for pixel in [0, 1, 77] {
            let points: Vec<_> = (64..128).map(|s| Draws::new(9, key(pixel, s), 2).triple(5)).collect();
            for log in 0..=6 {
                let mut counts = vec![0; 1 << log];
                points.iter().for_each(|[_, _, z]| counts[(z * (1 << log) as f32) as usize] += 1);
                assert!(counts.iter().all(|&n| n == 64 >> log), "third numbers: {counts:?}");
            }
            for (half, columns) in [(0, 4), (1, 4), (0, 16), (1, 16), (0, 1), (1, 1)] {
                let mut counts = [0; 16];
                for [x, y, _] in points.iter().filter(|[_, _, z]| (z * 2.0) as u32 == half) {
                    let rows = 16 / columns;
                    counts[(y * rows as f32) as usize * columns + (x * columns as f32) as usize] += 1;
                }
                assert_eq!(counts, [2; 16], "half {half}, {columns} columns");
            }
        }
    }

    /// Pearson's correlation of first numbers over many pixels, between two purposes, seeds, depths, neighbours.
    #[test]
    fn purposes_and_seeds_are_independent() {
        const N: u32 = 20_000;
        let draw =
            |seed, pixel, depth, purpose| f64::from(sample_pair(seed, key(pixel, 0), depth, purpose)[0]);
        let correlation = |other: &dyn Fn(u32) -> f64| {
            let sum: f64 = (0..N).map(|i| (draw(0, i, 0, 0) - 0.5) * (other(i) - 0.5)).sum();
            sum / f64::from(N) * 12.0
        };
        let limit = 4.0 / f64::from(N).sqrt();
        let others: [(&str, &dyn Fn(u32) -> f64); 4] = [
            ("purpose", &|i| draw(0, i, 0, 1)),
            ("seed", &|i| draw(1, i, 0, 0)),
            ("depth", &|i| draw(0, i, 1, 0)),
            ("neighbour", &|i| draw(0, i + 1, 0, 0)),
        ];
        for (name, other) in others {
            let r = correlation(other);
            assert!(r.abs() < limit, "{name}: correlation {r} above {limit}");
        }
    }

    /// Chi-square of single points over many pixels, 16 x 16 cells: stratification within a pixel cannot hide a bias.
    #[test]
    fn each_sample_is_uniform_over_pixels() {
        const N: u32 = 1 << 18;
        for sample in [0, 1, 2, 3, 7] {
            let mut counts = [0.0_f64; 256];
            for pixel in 0..N {
                let [x, y] = sample_pair(3, key(pixel, sample), 0, purpose::LIGHT);
                counts[(y * 16.0) as usize * 16 + (x * 16.0) as usize] += 1.0;
            }
            let expected = f64::from(N) / 256.0;
            let chi_square: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
            assert!((160.0..360.0).contains(&chi_square), "sample {sample}: chi-square {chi_square}");
        }
    }

    /// Column by column, as the matrix is defined.
    fn sobol_by_columns(mut index: u32) -> [u32; 2] {
        let x = index.reverse_bits();
        let (mut y, mut column) = (0, 1 << 31);
        while index != 0 {
            y ^= if index & 1 != 0 { column } else { 0 };
            index >>= 1;
            column ^= column >> 1;
        }
        [x, y]
    }

    #[test]
    fn points_are_those_of_the_matrices() {
        for i in 0..100_000_u32 {
            let index = if i < 1000 { i } else { mix(i) };
            assert_eq!(sobol(index), sobol_by_columns(index), "point {index}");
        }
    }

    #[test]
    fn numbers_stay_below_one() {
        assert!(unit_interval(u32::MAX) < 1.0, "1 is never reached");
        assert_eq!(unit_interval(0), 0.0, "0 is");
    }
}
