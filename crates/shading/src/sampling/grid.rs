// SPDX-License-Identifier: GPL-3.0-or-later
//! Choosing a point of the unit square with a density that is constant in each cell of a grid.
//! Source: [PJH23] section A.5: a row by its sum, then a column within it.
//! Tests: `tests::density_matches_samples`.

use crate::sampling::distribution::Distribution;

/// Weights on the cells of a grid over the unit square.
#[derive(Clone, Debug)]
pub struct GridDistribution {
    width: usize,
    height: usize,
    rows: Distribution,
    /// Within each row; `None` where a row has no weight, which is never chosen.
    columns: Vec<Option<Distribution>>,
}

/// A point that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPoint {
    /// Column of its cell.
    pub column: usize,
    /// Row of its cell.
    pub row: usize,
    /// Position within its cell, both in [0, 1).
    pub within: [f32; 2],
    /// Probability with which its cell is chosen.
    pub probability: f32,
}

impl GridDistribution {
    /// `weights` row by row, `width` to a row; `None` if none is above zero. Panics if `weights` is no multiple of
    /// `width` long or `width` is 0.
    #[must_use]
    pub fn new(width: usize, weights: &[f64]) -> Option<Self> {
        assert!(width > 0 && weights.len().is_multiple_of(width), "whole rows");
        let columns: Vec<_> =
            weights.chunks(width).map(|row| Distribution::new(row.iter().copied())).collect();
        let rows =
            Distribution::new(columns.iter().map(|row| row.as_ref().map_or(0.0, Distribution::total)))?;
        Some(Self { width, height: columns.len(), rows, columns })
    }

    /// Cells per row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Chooses by two numbers in [0, 1).
    #[must_use]
    pub fn sample(&self, u: [f32; 2]) -> GridPoint {
        let row = self.rows.sample(u[1]);
        let columns = self.columns[row.index].as_ref().expect("rows without weight are not chosen");
        let column = columns.sample(u[0]);
        GridPoint {
            column: column.index,
            row: row.index,
            within: [column.rest, row.rest],
            probability: row.probability * column.probability,
        }
    }

    /// Probability with which a cell is chosen.
    #[must_use]
    pub fn probability(&self, column: usize, row: usize) -> f32 {
        let within = self.columns[row].as_ref().map_or(0.0, |columns| columns.probability(column));
        self.rows.probability(row) * within
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::sample_pair;

    #[test]
    fn density_matches_samples() {
        let weights = [1.0, 0.0, 3.0, 0.0, 0.0, 0.0, 2.0, 5.0, 5.0];
        let grid = GridDistribution::new(3, &weights).expect("positive");
        const N: u32 = 1 << 15;
        let mut counts = [0.0_f64; 9];
        for sample in 0..N {
            let u = sample_pair(0, SampleKey { pixel: 0, sample, branch: 0 }, 0, 0);
            let point = grid.sample(u);
            let cell = 3 * point.row + point.column;
            assert_eq!(point.probability, grid.probability(point.column, point.row), "cell {cell}");
            assert!(point.within.iter().all(|w| (0.0..1.0).contains(w)), "within its cell");
            counts[cell] += 1.0;
        }
        for (count, weight) in counts.iter().zip(weights) {
            let expected = f64::from(N) * weight / 16.0;
            assert!((count - expected).abs() <= 3.0 + 0.01 * expected, "{count} instead of {expected}");
        }
        assert!(GridDistribution::new(2, &[0.0; 4]).is_none(), "nothing to choose");
    }
}
