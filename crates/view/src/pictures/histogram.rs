// SPDX-License-Identifier: GPL-3.0-or-later
//! Histogram of a picture over stops: how many values of red, green and blue are that bright. Tests: `tests`.

/// Stops from the darkest to the brightest column, relative to white.
const STOPS: [f32; 2] = [-12.0, 6.0];
/// Columns.
const BINS: usize = 180;
/// Rows of the drawing.
const ROWS: usize = 64;

/// Counts by colour and brightness.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Histogram([[u32; BINS]; 3]);

/// The column of a value.
fn bin(value: f32) -> usize {
    let place = (value.log2() - STOPS[0]) / (STOPS[1] - STOPS[0]) * BINS as f32;
    // Values that are none, or not above zero, are the darkest.
    (place.max(0.0) as usize).min(BINS - 1)
}

impl Histogram {
    pub(crate) fn of(colors: &[[f32; 4]]) -> Self {
        let mut counts = [[0; BINS]; 3];
        for color in colors {
            for (counts, &value) in counts.iter_mut().zip(color) {
                counts[bin(value)] += 1;
            }
        }
        Self(counts)
    }

    /// Draws it into the lower right corner of a screen of `0x00RRGGBB`; a line is where white is at this exposure.
    pub(crate) fn draw(&self, screen: &mut [u32], [width, height]: [u32; 2], scale: usize, stops: f32) {
        let [width, height] = [width as usize, height as usize];
        let [columns, rows] = [BINS * scale, ROWS * scale];
        if width < columns + 16 || height < rows + 16 || screen.len() < width * height {
            return;
        }
        let (left, top) = (width - columns - 8, height - rows - 8);
        // The darkest column holds all that is black, and would hide the others.
        let most = self.0.iter().flat_map(|counts| &counts[1..]).copied().max().unwrap_or(0).max(1);
        let length = |count: u32| ((count as f32 / most as f32).sqrt().min(1.0) * rows as f32) as usize;
        let white = bin((-stops).exp2());
        for column in 0..columns {
            let counts = [0, 1, 2].map(|k| self.0[k][column / scale]);
            let lengths = counts.map(length);
            for row in 0..rows {
                let pixel = &mut screen[(top + row) * width + left + column];
                let from_below = rows - row;
                let lit = [16, 8, 0].into_iter().zip(lengths).filter(|(_, length)| from_below <= *length);
                let lit = lit.fold(0, |color, (shift, _)| color | 0xd0 << shift);
                let is_line = column / scale == white && (row / (2 * scale)).is_multiple_of(2);
                *pixel = match lit {
                    _ if is_line => 0x00f4_f4f4,
                    0 => *pixel >> 2 & 0x003f_3f3f,
                    lit => lit,
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_counted_by_their_stops() {
        let histogram =
            Histogram::of(&[[1.0, 0.5, 0.0, 1.0], [1.0, f32::NAN, 1e9, 1.0], [1.0, 0.5, -3.0, 0.0]]);
        assert_eq!(histogram.0[0][bin(1.0)], 3);
        assert_eq!(histogram.0[1][bin(0.5)], 2);
        assert_eq!((histogram.0[1][0], histogram.0[2][0], histogram.0[2][BINS - 1]), (1, 2, 1), "the ends");
        assert_eq!(bin(1.0) - bin(0.5), BINS / 18, "a stop apart");
        let mut screen = vec![0x0080_8080; 300 * 100];
        histogram.draw(&mut screen, [300, 100], 1, 0.0);
        let at = |value: f32, up: usize| screen[(92 - up) * 300 + 300 - 8 - BINS + bin(value)];
        assert_eq!(at(0.5, 10) & 0xff00, 0xd000, "green at a stop below white");
        assert_eq!(at(1e-3, 10), 0x0020_2020, "a dark ground where there is nothing");
        let mut small = vec![7; 100];
        histogram.draw(&mut small, [10, 10], 1, 0.0);
        assert_eq!(small, [7; 100], "too small for it");
    }
}
