// SPDX-License-Identifier: GPL-3.0-or-later
//! One over the chance that a walk arrives where one did: the number of fresh walks until one does again.
//! Source: [ZGJ20] section 4.3, [Boo07]. The number is a sum over k of whether the first k walks all failed. From walk [`SURE`] on
//! each further term is added only by chance, and counts more; so the mean stays, and no search goes on for long.
//! Tests: `tests::counts_are_one_over_the_chance`.

/// Walks that are made in any case.
const SURE: u32 = 128;
/// The chance of each further one.
const GOES_ON: f32 = 511.0 / 512.0;

/// The count so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trials {
    failed: u32,
    weight: f32,
    pub(super) count: f32,
}

impl Trials {
    pub(super) fn new() -> Self {
        Self { failed: 0, weight: 1.0, count: 1.0 }
    }

    /// A walk failed; returns whether to make another one. `random` in [0, 1).
    pub(super) fn fails(&mut self, mut random: impl FnMut() -> f32) -> bool {
        self.failed += 1;
        if self.failed > SURE {
            if random() >= GOES_ON {
                return false;
            }
            self.weight /= GOES_ON;
        }
        self.count += self.weight;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_shading::sampling::hash_combine;

    #[test]
    fn counts_are_one_over_the_chance() {
        for chance in [0.5_f32, 0.02, 0.005] {
            let (mut n, mut sum) = (0_u32, 0.0_f64);
            let mut random = || {
                n += 1;
                (hash_combine(7, n) >> 8) as f32 / 16_777_216.0
            };
            const COUNT: u32 = 20_000;
            for _ in 0..COUNT {
                let mut trials = Trials::new();
                while random() >= chance && trials.fails(&mut random) {}
                sum += f64::from(trials.count);
            }
            let mean = sum / f64::from(COUNT);
            assert!((mean * f64::from(chance) - 1.0).abs() < 0.05, "{chance}: {mean}");
        }
    }
}
