// SPDX-License-Identifier: GPL-3.0-or-later
//! Choice of lights for the starts of light paths: the number that chooses a light is warped.
//! Source: [WBS03b]; the weights apply to the number, cut into bins, so any kind of light works; each bin
//! keeps a minimum, so the mean does not change. Tests: `tests::weights_undo_the_choice`.

use gnurt_shading::sampling::Distribution;

/// Fraction of paths that is spread over all lights by power.
const EVENLY: f64 = 0.25;

/// The warp of numbers that choose lights.
#[derive(Clone, Debug)]
pub(crate) struct LightChoice {
    bins: Distribution,
}

impl LightChoice {
    /// From the importance of each bin; `None` if none matters.
    pub(super) fn from_sums(sums: &[f64]) -> Option<Self> {
        let total: f64 = sums.iter().sum();
        let share = |sum: &f64| (1.0 - EVENLY) * sum / total + EVENLY / sums.len() as f64;
        (total > 0.0).then(|| Distribution::new(sums.iter().map(share)))?.map(|bins| Self { bins })
    }

    /// The number that chooses a light in place of `u`, and the weight of its path.
    pub(super) fn bend(&self, u: f32) -> (f32, f32) {
        let choice = self.bins.sample(u);
        let count = self.bins.len() as f32;
        ((choice.index as f32 + choice.rest) / count, 1.0 / (count * choice.probability))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_undo_the_choice() {
        let choice = LightChoice::from_sums(&[0.0, 5.0, 1.0, 0.0]).expect("some matter");
        const N: u32 = 4096;
        let (mut sum, mut hit) = ([0.0_f64; 4], 0);
        for i in 0..N {
            let (u, weight) = choice.bend((i as f32 + 0.5) / N as f32);
            assert!((0.0..1.0).contains(&u), "a number: {u}");
            sum[(u * 4.0) as usize] += f64::from(weight) / f64::from(N);
            hit += u32::from((u * 4.0) as usize == 1);
        }
        assert!(sum.iter().all(|sum| (sum - 0.25).abs() < 0.01), "even on average: {sum:?}");
        assert!(hit > N / 2, "the lamp that matters has most paths: {hit}");
    }
}
