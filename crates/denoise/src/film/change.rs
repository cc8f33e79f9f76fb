// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether light on the same points differs between two frames by more than noise: means over squares of three
//! sizes, against the variance of these means. Small squares find edges of shadows, large ones find weak changes.
//! The weight is that of a biased measurement: `1 / (1 + bias^2 / variance)`, where the variance is what the
//! filter of one picture leaves.
//! Tests: `tests/film.rs`.

use rayon::prelude::*;

use crate::noisy::Triple;

/// Half sides of the squares, and the multiple of its variance above which a square of a difference counts.
const SQUARES: [(usize, f32); 3] = [(1, 4.0), (3, 3.0), (8, 3.0)];
/// The filter of one picture takes the mean of about so many pixels.
const FILTERED: f32 = 30.0;

/// A pixel of both frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pair {
    /// Light there, less light here.
    pub(super) difference: Triple,
    /// Of the difference.
    pub(super) variance: Triple,
    /// Of light here.
    pub(super) own: Triple,
    /// 1, or 0 where there is no pair.
    pub(super) count: f32,
}

const ZERO: Pair = Pair { difference: [0.0; 3], variance: [0.0; 3], own: [0.0; 3], count: 0.0 };

impl Pair {
    fn add(mut self, other: &Self) -> Self {
        for k in 0..3 {
            self.difference[k] += other.difference[k];
            self.variance[k] += other.variance[k];
            self.own[k] += other.own[k];
        }
        self.count += other.count;
        self
    }
}

/// The weight of each pair, in 0..1.
pub(super) fn weights(pairs: &[Pair], width: usize) -> Vec<f32> {
    let mut weights: Vec<f32> = pairs.iter().map(|pair| pair.count).collect();
    for (half, sure) in SQUARES {
        let sums = sums(pairs, width, half);
        weights.par_iter_mut().zip(&sums).for_each(|(weight, sum)| *weight = weight.min(of(sum, sure)));
    }
    weights
}

fn of(sum: &Pair, sure: f32) -> f32 {
    if sum.count < 1.0 {
        return 0.0;
    }
    let n = sum.count;
    let (mut bias, mut left) = (0.0, 1e-12);
    for k in 0..3 {
        let difference = sum.difference[k] / n;
        bias += (difference * difference - sure * sum.variance[k] / (n * n)).max(0.0);
        left += sum.own[k] / (n * FILTERED);
    }
    1.0 / (1.0 + bias / left)
}

/// Sums over squares, clipped at the edges.
fn sums(pairs: &[Pair], width: usize, half: usize) -> Vec<Pair> {
    let height = pairs.len() / width;
    let around = |at: usize, length: usize| at.saturating_sub(half)..(at + half + 1).min(length);
    let across: Vec<Pair> = (0..pairs.len())
        .into_par_iter()
        .map(|p| {
            let row = p / width * width;
            around(p % width, width).fold(ZERO, |sum, x| sum.add(&pairs[row + x]))
        })
        .collect();
    (0..pairs.len())
        .into_par_iter()
        .map(|p| around(p / width, height).fold(ZERO, |sum, y| sum.add(&across[y * width + p % width])))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_kept_and_change_is_not() {
        let width = 40;
        // Differences of random sign and size 1, of variance 1.
        let mut state = 1_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if state >> 31 == 0 { 1.0 } else { -1.0 }
        };
        let pair = |x: f32| Pair { difference: [x; 3], variance: [1.0; 3], own: [0.5; 3], count: 1.0 };
        let mut pairs: Vec<Pair> = (0..width * width).map(|_| pair(noise())).collect();
        let mean = |pairs: &[Pair]| weights(pairs, width).iter().sum::<f32>() / pairs.len() as f32;
        assert!(mean(&pairs) > 0.8, "noise counts as no change: {}", mean(&pairs));
        pairs.iter_mut().for_each(|pair| pair.difference = pair.difference.map(|x| x + 1.0));
        assert!(mean(&pairs) < 0.05, "light that changed everywhere: {}", mean(&pairs));
    }
}
