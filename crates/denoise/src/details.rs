// SPDX-License-Identifier: GPL-3.0-or-later
//! Restores detail that a filter removed although it was no noise: lines too thin to have similar neighbours.
//! Shrinkage by the ratio of signal to noise, as Wiener's filter. A single outstanding pixel is noise whose
//! variance was underestimated: detail needs neighbours. The same holds for a pixel that is too dark where
//! light is in rare samples: pixels without such a sample underestimate their noise, so the relative noise of
//! their surroundings is used.
//! Tests: `tests`.

use crate::light::mean;
use crate::noisy::Triple;

/// Differences from the noisy picture below this number of standard deviations are noise.
const STANDS_OUT: f32 = 1.5;
/// Light is in rare samples where the variance of pixels exceeds this fraction of their light's square. The
/// second number is the factor of the variance of darker pixels there, per further fraction: large enough
/// that no detail returns where most pixels found nothing.
const RARE: f32 = 0.4;
const HARDLY_KNOWN: f32 = 4.0;
/// Columns and rows of the cells whose noise is compared with their light.
const CELL: usize = 8;

/// Brings details back to `clean` from the noisy `color`, whose variance and smoothed variance these are; not where
/// light is in `rare` samples.
pub(crate) fn bring_back(
    width: usize,
    color: &[Triple],
    variance: &[Triple],
    (smooth, rare): (&[Triple], &[bool]),
    clean: &mut [Triple],
) {
    let height = color.len() / width;
    let around = Around::new(width, variance, clean);
    // How much of the difference is signal; its sign says whether the noisy pixel is brighter.
    let share = |p: usize, clean: &Triple| {
        [0, 1, 2].map(|k| {
            let difference = color[p][k] - clean[k];
            let mut noise = smooth[p][k].max(variance[p][k]);
            if difference < 0.0 {
                let rare = (around.noise(p) - RARE).max(0.0);
                noise = noise.max(HARDLY_KNOWN * rare * clean[k] * clean[k]);
            }
            let noise = STANDS_OUT * STANDS_OUT * noise;
            (1.0 - noise / (difference * difference).max(f32::MIN_POSITIVE)).max(0.0).copysign(difference)
        })
    };
    let shares: Vec<Triple> = clean.iter().enumerate().map(|(p, clean)| share(p, clean)).collect();
    for (p, clean) in clean.iter_mut().enumerate() {
        if shares[p] == [0.0; 3] || rare.get(p) == Some(&true) {
            continue;
        }
        let (x, y) = (p % width, p / width);
        let mut company = [0.0f32; 3];
        for row in y.saturating_sub(1)..(y + 2).min(height) {
            for column in x.saturating_sub(1)..(x + 2).min(width) {
                if [column, row] != [x, y] {
                    let neighbour = &shares[row * width + column];
                    (0..3).for_each(|k| {
                        company[k] = company[k].max(neighbour[k] * shares[p][k].signum());
                    });
                }
            }
        }
        for k in 0..3 {
            clean[k] += (color[p][k] - clean[k]) * shares[p][k].abs().min(company[k]);
        }
    }
}

/// How noisy light is around.
struct Around {
    width: usize,
    columns: usize,
    /// Sums of variances over sums of squares of light, of each cell and its neighbours.
    cells: Vec<f32>,
}

impl Around {
    fn new(width: usize, variance: &[Triple], light: &[Triple]) -> Self {
        let (columns, rows) = (width.div_ceil(CELL), (light.len() / width).div_ceil(CELL));
        let mut sums = vec![[0.0_f32; 2]; columns * rows];
        for (p, (variance, light)) in variance.iter().zip(light).enumerate() {
            let [noise, square] = &mut sums[p / width / CELL * columns + p % width / CELL];
            *noise += mean(variance);
            *square += mean(&light.map(|x| x * x));
        }
        let noise = |at: usize| {
            let (x, y) = (at % columns, at / columns);
            let neighbour = (y.saturating_sub(1)..(y + 2).min(rows)).flat_map(|row| {
                (x.saturating_sub(1)..(x + 2).min(columns)).map(move |column| row * columns + column)
            });
            let [noise, square] = neighbour.fold([0.0; 2], |[a, b], at| [a + sums[at][0], b + sums[at][1]]);
            if square > 0.0 { noise / square } else { 0.0 }
        };
        Self { width, columns, cells: (0..sums.len()).map(noise).collect() }
    }

    /// The variance of light that is 1 there.
    fn noise(&self, p: usize) -> f32 {
        self.cells[p / self.width / CELL * self.columns + p % self.width / CELL]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_back_and_single_pixels_do_not() {
        let (width, height) = (12, 10);
        let mut color = vec![[1.0; 3]; width * height];
        (0..width).for_each(|x| color[3 * width + x] = [3.0; 3]);
        color[7 * width + 5] = [3.0; 3];
        let variance = vec![[0.04; 3]; width * height];
        let mut clean = vec![[1.0; 3]; width * height];
        bring_back(width, &color, &variance, (&variance, &[]), &mut clean);
        assert!((0..width).all(|x| clean[3 * width + x][1] > 2.9), "the line is there again");
        assert_eq!(clean[7 * width + 5], [1.0; 3], "the pixel is not");
        let noise = vec![[2.0; 3]; width * height];
        let mut clean = vec![[1.0; 3]; width * height];
        bring_back(width, &color, &noise, (&noise, &[]), &mut clean);
        assert!(clean.iter().all(|c| *c == [1.0; 3]), "within the noise nothing is");
    }

    /// Two neighbours of many found no light, and no noise: they are as noisy as those all around.
    #[test]
    fn what_found_no_light_is_noise() {
        let (width, height) = (24, 24);
        let dark = [10 * width + 9, 10 * width + 10];
        let clean = |noise: f32| {
            let mut color = vec![[1.0; 3]; width * height];
            let mut variance = vec![[noise; 3]; width * height];
            for p in dark {
                (color[p], variance[p]) = ([0.0; 3], [0.0; 3]);
            }
            let mut clean = vec![[1.0; 3]; width * height];
            let smooth = vec![[0.0; 3]; width * height];
            bring_back(width, &color, &variance, (&smooth, &[]), &mut clean);
            clean
        };
        assert!(dark.iter().all(|&p| clean(1.0)[p][0] > 0.99), "they stay as the filter has them");
        assert!(dark.iter().all(|&p| clean(1e-3)[p][0] < 0.01), "where light has no noise they are dark");
    }
}
