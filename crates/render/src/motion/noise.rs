// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise of fresh samples: mean squares of their errors relative to the light that is shown, of the whole picture and by
//! place. By place it is kept in squares of pixels, with a memory of some frames, and interpolated between their middles.
//! Source: ours. Tests: `tests`, crates/render/tests/motion.rs.

/// Fraction of the mean light below which the error of samples counts as constant, for the whole picture and by place.
const DIM: f32 = 0.25;
const DIM_THERE: f32 = 0.05;
/// Weight of a new picture in the noise of the whole.
const NEW: f32 = 0.2;
/// What a frame leaves of a square's samples.
const KEPT: f32 = 0.9;
/// Samples for which the whole picture counts in a square.
const OF_WHOLE: f32 = 16.0;
/// Squares of which a twentieth is noisy not by chance alone.
const ENOUGH: usize = 100;
/// Side of a square in pixels.
const SIDE: usize = 16;

/// A fresh sample.
pub(super) struct Sample {
    /// Its pixel.
    pub(super) at: [usize; 2],
    pub(super) is_shiny: bool,
    /// Luminance of its light, and of the light that is shown there.
    pub(super) brightness: f32,
    pub(super) known: f32,
}

/// Errors of samples.
#[derive(Default)]
pub(super) struct Noise {
    /// Of the whole picture, on rough surfaces and on shiny ones; unknown at first.
    whole: Option<[f32; 2]>,
    /// Squares in a row.
    columns: usize,
    /// Sums over the samples of rough surfaces in each square, and their number.
    squares: Vec<[f32; 2]>,
}

impl Noise {
    /// That of the whole picture, on rough surfaces and on shiny ones; 0 = unknown.
    pub(super) fn of_whole(&self) -> [f32; 2] {
        self.whole.unwrap_or_default()
    }

    /// Adds the samples of a picture of this size; returns whether they are the first ones. `mean` is the light of the
    /// mean pixel.
    pub(super) fn add(
        &mut self,
        [width, height]: [usize; 2],
        samples: impl Iterator<Item = Sample>,
        mean: f32,
    ) -> bool {
        let (columns, rows) = (width.div_ceil(SIDE), height.div_ceil(SIDE));
        if self.columns != columns || self.squares.len() != columns * rows {
            (self.columns, self.squares) = (columns, vec![[0.0; 2]; columns * rows]);
        }
        self.squares.iter_mut().flatten().for_each(|number| *number *= KEPT);
        let mut sums = [[0.0_f64; 2]; 2];
        for Sample { at: [x, y], is_shiny, brightness, known } in samples {
            let error = |dim: f32| ((brightness - known) / known.max(dim * mean)).powi(2);
            let (of_whole, there) = (f64::from(error(DIM)), error(DIM_THERE));
            if !(of_whole.is_finite() && there.is_finite()) {
                continue;
            }
            let [sum, count] = &mut sums[usize::from(is_shiny)];
            (*sum, *count) = (*sum + of_whole, *count + 1.0);
            if !is_shiny {
                let [sum, count] = &mut self.squares[y / SIDE * columns + x / SIDE];
                (*sum, *count) = (*sum + there, *count + 1.0);
            }
        }
        let (is_first, before) = (self.whole.is_none(), self.of_whole());
        self.whole = Some([0, 1].map(|k| match sums[k] {
            [_, 0.0] => before[k],
            [sum, count] if is_first => (sum / count) as f32,
            [sum, count] => before[k] + ((sum / count) as f32 - before[k]) * NEW,
        }));
        is_first
    }

    /// Noise on rough surfaces that only a twentieth of the squares exceeds; that of the whole in small pictures.
    pub(super) fn most(&self) -> f32 {
        let mut squares: Vec<f32> = self.squares.iter().map(|square| self.in_square(square)).collect();
        if squares.len() < ENOUGH {
            return self.of_whole()[0];
        }
        let nth = squares.len() * 19 / 20;
        *squares.select_nth_unstable_by(nth, f32::total_cmp).1
    }

    fn in_square(&self, &[sum, count]: &[f32; 2]) -> f32 {
        (sum + OF_WHOLE * self.of_whole()[0]) / (count + OF_WHOLE)
    }

    /// Noise on the rough surfaces of row `y`, pixel by pixel.
    pub(super) fn on_row(&self, y: usize, out: &mut [f32]) {
        if self.squares.is_empty() {
            out.fill(self.of_whole()[0]);
            return;
        }
        let ([above, below], down) = between(y, self.squares.len() / self.columns);
        let at = |column: usize| {
            let of = |row: usize| self.in_square(&self.squares[row * self.columns + column]);
            of(above) + (of(below) - of(above)) * down
        };
        for (x, out) in out.iter_mut().enumerate() {
            let ([left, right], over) = between(x, self.columns);
            let (left, right) = (at(left), at(right));
            *out = left + (right - left) * over;
        }
    }
}

/// The squares around a pixel in one direction, of `count`, and where it is between their middles.
fn between(pixel: usize, count: usize) -> ([usize; 2], f32) {
    let place = ((pixel as f32 + 0.5) / SIDE as f32 - 0.5).max(0.0);
    let first = (place as usize).min(count - 1);
    ([first, (first + 1).min(count - 1)], place - first as f32)
}

#[cfg(test)]
impl Noise {
    /// One that is the same everywhere.
    pub(super) fn of(noise: f32) -> Self {
        Self { whole: Some([noise; 2]), ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of light 2 in 64 by 32 pixels: exact on the left, and 0 or 6 on the right.
    fn some() -> Noise {
        let mut noise = Noise::default();
        let at = |i: usize| [i % 64, i / 64];
        let sample = |i: usize| {
            let brightness = if i % 64 < 32 {
                2.0
            } else if i.is_multiple_of(3) {
                6.0
            } else {
                0.0
            };
            Sample { at: at(i), is_shiny: false, brightness, known: 2.0 }
        };
        assert!(noise.add([64, 32], (0..64 * 32).map(sample), 2.0), "the first ones");
        for _ in 0..9 {
            assert!(!noise.add([64, 32], (0..64 * 32).map(sample), 2.0));
        }
        noise
    }

    #[test]
    fn noise_is_known_by_place() {
        let noise = some();
        // Squares of 0 - 2 over 2, twice, and of 6 - 2 over 2: 2 in the mean.
        assert!((noise.of_whole()[0] - 1.0).abs() < 0.01, "{:?}", noise.of_whole());
        let mut row = [0.0; 64];
        noise.on_row(13, &mut row);
        assert!(row[0] < 0.05 && row[63] > 1.95, "{row:?}");
        assert!(row.windows(2).all(|pair| pair[1] - pair[0] < 0.15), "no edge shows: {row:?}");
        assert_eq!(noise.most(), noise.of_whole()[0], "few squares");
        let mut large = Noise::default();
        let sample = |i: usize| Sample {
            at: [i % 320, i / 320],
            is_shiny: false,
            brightness: if i % 320 < 32 { 6.0 } else { 2.0 },
            known: 2.0,
        };
        for _ in 0..10 {
            large.add([320, 160], (0..320 * 160).map(sample), 2.0);
        }
        assert!((large.most() - 4.0).abs() < 0.1, "a tenth is noisy: {}", large.most());
    }

    #[test]
    fn another_size_forgets_places() {
        let mut noise = some();
        noise.add([32, 32], std::iter::empty(), 2.0);
        let mut row = [0.0; 32];
        noise.on_row(0, &mut row);
        assert!(row.iter().all(|there| *there == noise.of_whole()[0]), "only the whole is known: {row:?}");
    }

    #[test]
    fn nothing_is_known_at_first() {
        let noise = Noise::default();
        assert_eq!((noise.of_whole(), noise.most()), ([0.0; 2], 0.0));
        let mut row = [1.0; 4];
        noise.on_row(0, &mut row);
        assert_eq!(row, [0.0; 4]);
    }
}
