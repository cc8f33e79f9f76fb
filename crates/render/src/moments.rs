// SPDX-License-Identifier: GPL-3.0-or-later
//! The noise of means, from sums over samples. Tests: crates/render/tests/seen.rs.

/// Variance of the mean of `count` samples, per channel, from their sum and the sum of their squares, as if they were
/// independent: they are spread better than that, so the true one is smaller. 0 if it is not known.
pub(crate) fn variance_of_mean(sum: &[f64; 3], squares: &[f64; 3], count: u32) -> [f32; 3] {
    if count < 2 {
        return [0.0; 3];
    }
    let n = f64::from(count);
    [0, 1, 2].map(|k| {
        let mean = sum[k] / n;
        ((squares[k] / n - mean * mean).max(0.0) / (n - 1.0)) as f32
    })
}
