// SPDX-License-Identifier: GPL-3.0-or-later
//! How alike the surroundings of two pixels are, as far as their noise lets one tell.
//! Source: \[RKZ12\], section 4: squared differences of patches less what their variances explain, relative to those.
//! Proof: `tests`.

use crate::noisy::Triple;

/// Pixels of a patch to each side of its centre.
pub(crate) const PATCH: usize = 3;
/// Pixels of the neighbourhood to each side of its centre.
pub(crate) const REACH: usize = 9;
/// Offsets in a neighbourhood.
pub(crate) const OFFSETS: usize = (2 * REACH + 1) * (2 * REACH + 1);

/// How many standard deviations apart two colours may be.
const SHARPNESS: f32 = 0.6;
/// Differences below this share of the colour are none.
const UNSEEN: f32 = 2e-3;
/// No single pixel makes patches more different than this.
const MOST: f32 = 1e3;

/// A picture whose patches are compared.
pub(crate) struct Signal<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) color: &'a [Triple],
    pub(crate) variance: &'a [Triple],
}

/// Weights of the neighbours of all pixels of a tile.
pub(crate) struct Weights {
    /// Per offset (row by row), then per pixel of the tile (row by row); 0 outside of the picture.
    pub(crate) of: Vec<f32>,
    distance: Vec<f32>,
    sums: Vec<f32>,
}

impl Weights {
    pub(crate) fn new() -> Self {
        Self { of: Vec::new(), distance: Vec::new(), sums: Vec::new() }
    }

    /// Computes them for the tile `[x0, y0, x1, y1]`.
    pub(crate) fn compute(&mut self, signal: &Signal, [x0, y0, x1, y1]: [usize; 4]) {
        let (columns, rows) = (x1 - x0, y1 - y0);
        let (wide, high) = (columns + 2 * PATCH, rows + 2 * PATCH);
        self.of.clear();
        self.of.resize(OFFSETS * columns * rows, 0.0);
        self.distance.resize(wide * high, 0.0);
        self.sums.resize(columns * high, 0.0);
        let inside = |x: isize, most: usize| x.clamp(0, most as isize - 1) as usize;
        let offsets = (0..OFFSETS).map(|o| [o % (2 * REACH + 1), o / (2 * REACH + 1)]);
        for ([dx, dy], out) in offsets.zip(self.of.chunks_exact_mut(columns * rows)) {
            let (dx, dy) = (dx as isize - REACH as isize, dy as isize - REACH as isize);
            for y in 0..high {
                let py = inside((y0 + y) as isize - PATCH as isize, signal.height);
                let qy = inside(py as isize + dy, signal.height);
                for x in 0..wide {
                    let px = inside((x0 + x) as isize - PATCH as isize, signal.width);
                    let qx = inside(px as isize + dx, signal.width);
                    let (p, q) = (py * signal.width + px, qy * signal.width + qx);
                    self.distance[y * wide + x] = difference(
                        (&signal.color[p], &signal.variance[p]),
                        (&signal.color[q], &signal.variance[q]),
                    );
                }
            }
            // The mean over each patch, first along rows, then along columns.
            for (row, sums) in self.distance.chunks_exact(wide).zip(self.sums.chunks_exact_mut(columns)) {
                for (x, sum) in sums.iter_mut().enumerate() {
                    *sum = row[x..=x + 2 * PATCH].iter().sum();
                }
            }
            let scale = 1.0 / ((2 * PATCH + 1) * (2 * PATCH + 1)) as f32;
            for (y, out) in out.chunks_exact_mut(columns).enumerate() {
                let qy = (y0 + y) as isize + dy;
                if qy < 0 || qy >= signal.height as isize {
                    continue;
                }
                for (x, out) in out.iter_mut().enumerate() {
                    let qx = (x0 + x) as isize + dx;
                    if qx >= 0 && qx < signal.width as isize {
                        let sum: f32 = (y..=y + 2 * PATCH).map(|row| self.sums[row * columns + x]).sum();
                        *out = falloff(sum * scale);
                    }
                }
            }
        }
    }
}

/// Of two pixels, each a colour with its variance: mean over channels; about 0 if noise explains all.
fn difference((p, var_p): (&Triple, &Triple), (q, var_q): (&Triple, &Triple)) -> f32 {
    let mut sum = 0.0;
    for k in 0..3 {
        let apart = p[k] - q[k];
        let unseen = UNSEEN * (p[k].abs() + q[k].abs());
        let explained = var_p[k] + var_q[k].min(var_p[k]);
        let all = unseen * unseen + 1e-20 + SHARPNESS * SHARPNESS * (var_p[k] + var_q[k]);
        sum += (apart * apart - explained) / all;
    }
    (sum * (1.0 / 3.0)).min(MOST)
}

/// exp(-x) without the tail: 0 from 8 on, 1 below 0.
fn falloff(x: f32) -> f32 {
    let base = (1.0 - x.max(0.0) * 0.125).max(0.0);
    let square = base * base;
    let fourth = square * square;
    fourth * fourth
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights by the definition, one pixel pair at a time.
    fn slow(signal: &Signal, p: [isize; 2], q: [isize; 2]) -> f32 {
        let index = |[x, y]: [isize; 2]| {
            let (x, y) = (x.clamp(0, signal.width as isize - 1), y.clamp(0, signal.height as isize - 1));
            (y * signal.width as isize + x) as usize
        };
        let mut sum = 0.0;
        let patch = PATCH as isize;
        for y in -patch..=patch {
            for x in -patch..=patch {
                // The patch of p ends at the picture's edge; that of q follows it.
                let at = [p[0] + x, p[1] + y];
                let at =
                    [at[0].clamp(0, signal.width as isize - 1), at[1].clamp(0, signal.height as isize - 1)];
                let other = [at[0] + q[0] - p[0], at[1] + q[1] - p[1]];
                let (i, j) = (index(at), index(other));
                sum += difference(
                    (&signal.color[i], &signal.variance[i]),
                    (&signal.color[j], &signal.variance[j]),
                );
            }
        }
        (-(f64::from(sum) / 49.0).max(0.0)).exp() as f32
    }

    #[test]
    fn weights_are_those_of_the_definition() {
        let mut random = gnurt_testkit::Random::new(7);
        let (width, height) = (23, 17);
        let color: Vec<Triple> =
            (0..width * height).map(|_| [0; 3].map(|_| 1.0 + 0.3 * random.unit())).collect();
        let variance: Vec<Triple> =
            (0..width * height).map(|_| [0; 3].map(|_| 0.02 * random.unit())).collect();
        let signal = Signal { width, height, color: &color, variance: &variance };
        let mut weights = Weights::new();
        let tile = [4, 3, 20, 17];
        weights.compute(&signal, tile);
        let (columns, rows) = (tile[2] - tile[0], tile[3] - tile[1]);
        let mut positive = 0;
        for o in 0..OFFSETS {
            let (dx, dy) = ((o % 19) as isize - 9, (o / 19) as isize - 9);
            for y in 0..rows {
                for x in 0..columns {
                    let p = [(tile[0] + x) as isize, (tile[1] + y) as isize];
                    let q = [p[0] + dx, p[1] + dy];
                    let found = weights.of[(o * rows + y) * columns + x];
                    let inside = q[0] >= 0 && q[1] >= 0 && q[0] < width as isize && q[1] < height as isize;
                    let wanted = if inside { slow(&signal, p, q) } else { 0.0 };
                    positive += usize::from(found > 0.1 && found < 0.9);
                    assert!((found - wanted).abs() < 0.04, "{p:?} {q:?}: {found}, not {wanted}");
                }
            }
        }
        assert!(positive > 1000, "the test sees weights that are neither 0 nor 1: {positive}");
    }
}
