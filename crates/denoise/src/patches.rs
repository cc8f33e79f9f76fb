// SPDX-License-Identifier: GPL-3.0-or-later
//! Similarity of the surroundings of two pixels, within the limits of their noise.
//! Source: \[RKZ12\], section 4: squared differences of patches minus their variances, relative to those.
//! Planes have a border, so that loops along rows need no special case at edges. All is inlined into the
//! functions that `gnurt_simd::dispatch!` enters: no sum's order depends on lanes, so that all levels give
//! the same bits.
//! Tests: `tests`.

use crate::noisy::Triple;

/// Differences below this share of the colour are none.
const UNSEEN: f32 = 2e-3;
/// No single pixel makes patches more different than this.
const MOST: f32 = 1e3;

/// The set of compared patches.
#[derive(Clone, Copy)]
pub(crate) struct Reach {
    /// Neighbours to each side of a pixel.
    pub(crate) side: usize,
    /// Columns or rows from one to the next.
    pub(crate) step: usize,
    /// Pixels of a patch to each side of its centre.
    pub(crate) patch: usize,
    /// Column and row of the first centre: 0 or 1.
    pub(crate) first: usize,
    /// The largest difference of two colours, in standard deviations.
    pub(crate) sharpness: f32,
}

impl Reach {
    /// Neighbours of a pixel, with itself.
    pub(crate) const fn count(self) -> usize {
        (2 * self.side + 1) * (2 * self.side + 1)
    }

    /// Columns and rows to a neighbour, by its number.
    #[inline(always)]
    pub(crate) fn offset(self, number: usize) -> [isize; 2] {
        let along = 2 * self.side + 1;
        [number % along, number / along].map(|x| (x as isize - self.side as isize) * self.step as isize)
    }

    /// Columns or rows to the farthest neighbour.
    pub(crate) const fn farthest(self) -> usize {
        self.side * self.step
    }
}

/// A picture whose patches are compared: colours and variances, one plane each, continued beyond the picture's edges.
pub(crate) struct Planes {
    reach: Reach,
    width: usize,
    border: usize,
    color: [Vec<f32>; 3],
    variance: [Vec<f32>; 3],
}

impl Planes {
    pub(crate) fn new(reach: Reach, width: usize, color: &[Triple], variance: &[Triple]) -> Self {
        let height = color.len() / width;
        let border = reach.farthest() + reach.patch;
        let inside = |x: usize, length: usize| x.saturating_sub(border).min(length - 1);
        let plane = |of: &[Triple], k: usize| -> Vec<f32> {
            let rows = (0..height + 2 * border).map(|y| inside(y, height) * width);
            rows.flat_map(|row| (0..width + 2 * border).map(move |x| of[row + inside(x, width)][k])).collect()
        };
        Self {
            reach,
            width,
            border,
            color: [0, 1, 2].map(|k| plane(color, k)),
            variance: [0, 1, 2].map(|k| plane(variance, k)),
        }
    }

    /// The weights of the neighbours of each `stride`th pixel of row `y`, from the reach's first on: pixel by pixel, then by the neighbours' number.
    /// Those beyond the picture's edges mean nothing.
    #[inline(always)]
    pub(crate) fn weights(&self, y: usize, stride: usize, memory: &mut Memory, out: &mut [f32]) {
        if out.is_empty() {
            // A single column has no second centre.
            return;
        }
        let (patch, count) = (self.reach.patch, self.reach.count());
        let (length, wide) = (self.width + 2 * patch, self.width + 2 * self.border);
        let scale = 1.0 / (3 * (2 * patch + 1) * (2 * patch + 1)) as f32;
        memory.row.resize(length, 0.0);
        memory.sums.resize(length, 0.0);
        for number in 0..count {
            let [dx, dy] = self.reach.offset(number);
            memory.sums.fill(0.0);
            for row in 0..=2 * patch {
                let at = (y + self.border + row - patch) * wide + self.border - patch;
                let other = at.wrapping_add_signed(dy * wide as isize + dx);
                memory.row.fill(0.0);
                for k in 0..3 {
                    self.add_differences(k, at, other, &mut memory.row);
                }
                for (sum, row) in memory.sums.iter_mut().zip(&memory.row) {
                    *sum += row.min(MOST);
                }
            }
            for (i, out) in out[number..].iter_mut().step_by(count).enumerate() {
                let begin = i * stride + self.reach.first;
                let mut sum = 0.0;
                memory.sums[begin..=begin + 2 * patch].iter().for_each(|x| sum += x);
                *out = falloff(sum * scale);
            }
        }
    }

    /// Adds how far one colour of pixels from `at` on is from that of those from `other` on; about 0 if noise explains all.
    #[inline(always)]
    fn add_differences(&self, k: usize, at: usize, other: usize, sums: &mut [f32]) {
        let length = sums.len();
        let (p, var_p) = (&self.color[k][at..at + length], &self.variance[k][at..at + length]);
        let (q, var_q) = (&self.color[k][other..other + length], &self.variance[k][other..other + length]);
        let sharp = self.reach.sharpness * self.reach.sharpness;
        for i in 0..length {
            let difference = p[i] - q[i];
            let unseen = UNSEEN * (p[i].abs() + q[i].abs());
            let explained = var_p[i] + if var_q[i] < var_p[i] { var_q[i] } else { var_p[i] };
            let all = unseen * unseen + 1e-30 + sharp * (var_p[i] + var_q[i]);
            sums[i] += (difference * difference - explained) / all;
        }
    }
}

/// For sums along a row.
#[derive(Default)]
pub(crate) struct Memory {
    row: Vec<f32>,
    sums: Vec<f32>,
}

/// exp(-x) without the tail: 0 from 8 on, 1 below 0.
#[inline(always)]
fn falloff(x: f32) -> f32 {
    let base = (1.0 - x.max(0.0) * 0.125).max(0.0);
    let square = base * base;
    let fourth = square * square;
    fourth * fourth
}

#[cfg(test)]
mod tests {
    use super::*;

    const REACH: Reach = Reach { side: 4, step: 2, patch: 3, first: 0, sharpness: 0.6 };

    /// Weights by the definition, one pixel pair at a time.
    fn slow(
        color: &[Triple],
        variance: &[Triple],
        size: [isize; 2],
        p: [isize; 2],
        difference: [isize; 2],
    ) -> f32 {
        let index =
            |x: isize, y: isize| (y.clamp(0, size[1] - 1) * size[0] + x.clamp(0, size[0] - 1)) as usize;
        let mut sum = 0.0;
        let patch = REACH.patch as isize;
        for y in -patch..=patch {
            for x in -patch..=patch {
                let i = index(p[0] + x, p[1] + y);
                let j = index(p[0] + x + difference[0], p[1] + y + difference[1]);
                let mut of_pixel = 0.0;
                for k in 0..3 {
                    let (p, q, var_p, var_q) = (color[i][k], color[j][k], variance[i][k], variance[j][k]);
                    let unseen = UNSEEN * (p + q);
                    of_pixel += ((p - q).powi(2) - var_p - var_p.min(var_q))
                        / (unseen * unseen + 0.36 * (var_p + var_q));
                }
                sum += f64::from(of_pixel / 3.0);
            }
        }
        (-(sum / 49.0).max(0.0)).exp() as f32
    }

    #[test]
    fn weights_are_those_of_the_definition() {
        let mut random = gnurt_testkit::Random::new(7);
        let (width, height) = (23usize, 17usize);
        let color: Vec<Triple> =
            (0..width * height).map(|_| [0; 3].map(|_| 1.0 + 0.3 * random.unit())).collect();
        let variance: Vec<Triple> =
            (0..width * height).map(|_| [0; 3].map(|_| 0.002 + 0.004 * random.unit())).collect();
        let planes = Planes::new(REACH, width, &color, &variance);
        let mut weights = vec![0.0; width.div_ceil(2) * REACH.count()];
        let (mut memory, mut positive) = (Memory::default(), 0);
        for y in 0..height {
            planes.weights(y, 2, &mut memory, &mut weights);
            for (i, found) in weights.iter().enumerate() {
                let (x, difference) = (i / REACH.count() * 2, REACH.offset(i % REACH.count()));
                let p = [x as isize, y as isize];
                let expected = slow(&color, &variance, [width as isize, height as isize], p, difference);
                positive += usize::from(*found > 0.1 && *found < 0.9);
                assert!((found - expected).abs() < 0.04, "{p:?} {difference:?}: {found}, not {expected}");
            }
        }
        assert!(positive > 1000, "the test sees weights that are neither 0 nor 1: {positive}");
    }
}
