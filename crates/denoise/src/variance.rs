// SPDX-License-Identifier: GPL-3.0-or-later
//! Variances of pixels: smoothed, and estimated from neighbours where samples give none.

use rayon::prelude::*;

use crate::light::mean;
use crate::noisy::Triple;

/// Pixels to each side that variances are averaged over: at first, and where too few have most of it.
const REACHES: [usize; 4] = [2, 4, 8, 16];
/// So many pixels must share the variance.
const ENOUGH: f32 = 3.0;

/// Variances from few samples are noisy themselves: means over squares of pixels, of those with about the same
/// normal, so that bright surfaces lend no variance to dark ones behind them. Squares grow where few pixels have most of
/// the variance, as where light is in rare samples: pixels without one have no variance of their own. Call within a pool of threads.
pub(crate) fn smooth(variance: &[Triple], (normal, rare): (&[Triple], &[bool]), width: usize) -> Vec<Triple> {
    let height = variance.len() / width;
    let over = |p: usize, reach: usize| {
        let around = |at: usize, length: usize| at.saturating_sub(reach)..(at + reach + 1).min(length);
        let (mut sum, mut weights, mut all, mut squares) = ([0.0; 3], 0.0, 0.0, 0.0);
        for y in around(p / width, height) {
            for q in around(p % width, width).map(|x| y * width + x) {
                let normal_difference = [0, 1, 2].map(|k| normal[p][k] - normal[q][k]);
                let normal_difference = normal_difference[0] * normal_difference[0]
                    + normal_difference[1] * normal_difference[1]
                    + normal_difference[2] * normal_difference[2];
                let weight = (1.0 - 2.0 * normal_difference).max(1e-3);
                (0..3).for_each(|k| sum[k] += weight * variance[q][k]);
                weights += weight;
                let part = weight * mean(&variance[q]);
                all += part;
                squares += part * part;
            }
        }
        (sum.map(|x| x / weights), all * all <= ENOUGH * squares && rare.get(p) == Some(&true))
    };
    let at = |p: usize| {
        let mut found = ([0.0; 3], true);
        for reach in REACHES {
            if found.1 {
                found = over(p, reach);
            }
        }
        found.0
    };
    (0..variance.len()).into_par_iter().map(at).collect()
}

/// Half the mean square difference to the neighbours below and to the right, where samples give no variance.
pub(crate) fn spatial(color: &[Triple], width: usize, height: usize) -> Vec<Triple> {
    let at = |i: usize| {
        let (x, y) = (i % width, i / width);
        let right = if x + 1 < width { i + 1 } else { i };
        let below = if y + 1 < height { i + width } else { i };
        [0, 1, 2].map(|k| {
            let (a, b) = (color[i][k] - color[right][k], color[i][k] - color[below][k]);
            0.5 * (a * a).min(b * b)
        })
    };
    (0..color.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variances_are_means_that_do_not_cross_edges_of_normals() {
        let (width, height) = (12, 9);
        let at = |p: usize| if p % width < 6 { ([0.0, 0.0, 1.0], 1.0) } else { ([1.0, 0.0, 0.0], 1000.0) };
        let noise = |p: usize| if p.is_multiple_of(2) { 1.5 } else { 0.5 };
        let normal: Vec<Triple> = (0..width * height).map(|p| at(p).0).collect();
        let variance: Vec<Triple> = (0..width * height).map(|p| [at(p).1 * noise(p); 3]).collect();
        for (p, found) in smooth(&variance, (&normal, &[]), width).iter().enumerate() {
            let share = found[0] / at(p).1;
            assert!(share > 0.6 && share < 2.0, "pixel {p}: {share} of the mean");
        }
        assert_eq!(spatial(&[[1.0; 3], [3.0; 3], [1.0; 3], [3.0; 3]], 2, 2)[0], [0.0; 3], "columns alike");
    }
}
