// SPDX-License-Identifier: GPL-3.0-or-later
//! Seeded random numbers: the same rays on every machine. Source: \[SLF14\] (SplitMix64).

/// A stream of numbers that its seed determines.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in `[0, 1)`.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// Puts the values in random order.
    pub(crate) fn shuffle<T>(&mut self, values: &mut [T]) {
        for i in (1..values.len()).rev() {
            values.swap(i, (self.bits() % (i as u64 + 1)) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shuffling_loses_nothing() {
        let mut values: Vec<u32> = (0..1000).collect();
        Random::new(1).shuffle(&mut values);
        let moved = values.iter().zip(0..).filter(|(value, position)| **value != *position).count();
        assert!(moved > 950, "{moved} of 1000 have a new place");
        values.sort_unstable();
        assert!(values.iter().copied().eq(0..1000), "each is still there");
    }
}
