// SPDX-License-Identifier: GPL-3.0-or-later
//! Weights of light that two ways of sampling find. Source: [VG95] (power heuristic, exponent 2).
//! Invariant: `power_heuristic(a, b) + power_heuristic(b, a)` is 1 where either density is above zero and both finite.
//! Proof: `tests::weights_add_up`.

/// Weight of what was sampled with density `own` and might have been with `other`.
pub(crate) fn power_heuristic(own: f32, other: f32) -> f32 {
    if own.is_infinite() {
        return 1.0;
    }
    // The ratio is squared, not the densities: these may be huge or tiny.
    let ratio = other / own;
    if own > 0.0 { 1.0 / (1.0 + ratio * ratio) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_add_up() {
        for (a, b) in [(1.0, 1.0), (1e-30, 1e30), (3.0, 0.5), (1e38, 1e-3), (0.2, 0.0)] {
            let sum = power_heuristic(a, b) + power_heuristic(b, a);
            assert!((sum - 1.0).abs() < 1e-6, "{a} and {b}: {sum}");
        }
        assert_eq!(power_heuristic(3.0, 1.0), 0.9, "by the squares");
        assert_eq!(power_heuristic(0.0, 0.0), 0.0, "what is not sampled has no weight");
    }
}
