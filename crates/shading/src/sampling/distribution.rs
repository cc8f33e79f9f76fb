// SPDX-License-Identifier: GPL-3.0-or-later
//! Choosing one of many in proportion to weights, by inverting the cumulative sum.
//! Source: [PJH23] section A.1. Inversion rather than an alias table: neighbouring numbers give neighbouring choices,
//! so stratified numbers stay stratified; a choice costs log2 n steps.
//! Invariant: an element of weight 0 is never chosen. Tests: `tests::{choices_follow_weights,
//! rest_is_uniform}`.

/// Weights to choose by.
#[derive(Clone, Debug)]
pub struct Distribution {
    /// Sum of the weights before each index, and of all of them at the end.
    cumulative: Vec<f64>,
}

/// A choice that was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Which one.
    pub index: usize,
    /// The probability of the choice.
    pub probability: f32,
    /// The remainder of the random number, again uniform in [0, 1).
    pub rest: f32,
}

impl Distribution {
    /// `None` if no weight is above zero. Weights that are negative or not finite count as zero.
    #[must_use]
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sum = 0.0;
        let mut cumulative = vec![0.0];
        cumulative.extend(weights.into_iter().map(|weight| {
            sum += if weight > 0.0 && weight.is_finite() { weight } else { 0.0 };
            sum
        }));
        (sum > 0.0 && sum.is_finite()).then_some(Self { cumulative })
    }

    /// Number of weights.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cumulative.len() - 1
    }

    /// Whether there are no weights: never, see [`new`](Self::new).
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sum of all weights.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.cumulative[self.len()]
    }

    /// Probability with which `index` is chosen.
    #[must_use]
    pub fn probability(&self, index: usize) -> f32 {
        ((self.cumulative[index + 1] - self.cumulative[index]) / self.total()) as f32
    }

    /// Chooses by a number in [0, 1).
    #[must_use]
    pub fn sample(&self, u: impl Into<f64>) -> Choice {
        let at = u.into() * self.total();
        // The last index whose sum before it is not above `at`; weights of zero are skipped because their sums repeat.
        let above = self.cumulative.partition_point(|&sum| sum <= at);
        let index = if above <= self.len() { above - 1 } else { self.last_positive() };
        let [low, high] = [self.cumulative[index], self.cumulative[index + 1]];
        let rest = ((at - low) / (high - low)) as f32;
        Choice { index, probability: self.probability(index), rest: rest.clamp(0.0, ALMOST_ONE) }
    }

    fn last_positive(&self) -> usize {
        self.cumulative.partition_point(|&sum| sum < self.total()) - 1
    }
}

/// The largest float below 1.
pub(crate) const ALMOST_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_follow_weights() {
        let weights = [0.0, 1.0, 0.0, f64::NAN, 5.0, -3.0, 2.0, 0.0];
        let distribution = Distribution::new(weights).expect("some weights are positive");
        const N: usize = 80_000;
        let mut counts = [0_usize; 8];
        for i in 0..N {
            counts[distribution.sample((i as f32 + 0.5) / N as f32).index] += 1;
        }
        assert_eq!(counts, [0, N / 8, 0, 0, N * 5 / 8, 0, N / 4, 0], "in proportion");
        assert_eq!(distribution.sample(0.0).index, 1, "0 skips leading zeros");
        assert_eq!(distribution.sample(ALMOST_ONE).index, 6, "the end skips trailing zeros");
        assert_eq!(distribution.sample(1.0).index, 6, "even 1 is survived");
        assert_eq!(distribution.probability(4), 0.625, "the probability is known");
        assert!(Distribution::new([0.0, -1.0]).is_none(), "nothing to choose");
        assert!(Distribution::new([]).is_none(), "nothing at all");
    }

    #[test]
    fn rest_is_uniform() {
        let distribution = Distribution::new([1.0, 3.0]).expect("positive");
        assert!((distribution.sample(0.125).rest - 0.5).abs() < 1e-6, "half way through the first");
        assert!((distribution.sample(0.25).rest).abs() < 1e-6, "start of the second");
        assert!((distribution.sample(0.625).rest - 0.5).abs() < 1e-6, "half way through the second");
    }
}
