// SPDX-License-Identifier: GPL-3.0-or-later
//! Seeded random numbers: the same on every machine, forever.
//! Source: \[SLF14\] (SplitMix64). Tests: `tests::is_uniform_and_repeats`.

/// A stream of numbers that its seed determines.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The stream of `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in `[0, 1)`.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// A number in `[low, high)`, up to rounding.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// An integer in `0..n`; `n > 0`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// A point of the cube `[-1, 1]^3`.
    pub fn point(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.between(-1.0, 1.0))
    }

    /// One of some values; there must be one.
    pub fn pick<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_uniform_and_repeats() {
        let (mut a, mut b) = (Random::new(3), Random::new(3));
        let mean = (0..10_000).map(|_| a.unit()).sum::<f32>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.02, "the mean of many is {mean}");
        (0..10_000).for_each(|_| _ = b.bits());
        assert_eq!(a.bits(), b.bits(), "one seed, one stream");
    }
}
