// SPDX-License-Identifier: GPL-3.0-or-later
//! Weighted least squares: colours as a linear function of what was met, around one pixel.
//! Source: \[MCY14\] (local linear regression on features), \[BRM*16\] (which features, weights from colours); the ridge that
//! keeps what the features cannot tell at a constant is ours. Sums are single, the solution is double precision.
//! Proof: `tests`.

use crate::noisy::Triple;

/// A constant, and three each of normal, albedo and position.
pub(crate) const TERMS: usize = 10;
/// Terms, three colours, and padding so that rows fill lanes.
const ROW: usize = 16;

/// What a pixel is described by: the constant first, then features, relative to the centre.
pub(crate) type Features = [f32; TERMS];

/// Normal equations in the making.
pub(crate) struct Regression {
    rows: [[f32; ROW]; TERMS],
}

/// Colours as a linear function of features.
pub(crate) struct Fit {
    coefficients: [Triple; TERMS],
}

impl Regression {
    pub(crate) fn new() -> Self {
        Self { rows: [[0.0; ROW]; TERMS] }
    }

    /// Adds a neighbour.
    #[inline]
    pub(crate) fn add(&mut self, weight: f32, features: &Features, color: &Triple) {
        let mut all = [0.0; ROW];
        all[..TERMS].copy_from_slice(features);
        all[TERMS..TERMS + 3].copy_from_slice(color);
        for (row, &feature) in self.rows.iter_mut().zip(features) {
            let scale = weight * feature;
            for (sum, &value) in row.iter_mut().zip(&all) {
                *sum += scale * value;
            }
        }
    }

    /// The best fit; deviations of normals and albedo below `unsure` (in their units) tell nothing, and none of positions
    /// below a hundredth of their spread. `None` without neighbours.
    pub(crate) fn solve(&self, unsure: f32) -> Option<Fit> {
        let weight = f64::from(self.rows[0][0]);
        if !weight.is_finite() || weight <= 0.0 {
            return None;
        }
        let mut matrix = [[0.0; TERMS]; TERMS];
        let mut right = [[0.0; 3]; TERMS];
        for (i, row) in self.rows.iter().enumerate() {
            for j in 0..TERMS {
                matrix[i][j] = f64::from(row[j]);
            }
            for k in 0..3 {
                right[i][k] = f64::from(row[TERMS + k]);
            }
        }
        let ridge = f64::from(unsure * unsure) * weight;
        (1..7).for_each(|i| matrix[i][i] += ridge + 1e-4 * matrix[i][i]);
        let spread: f64 = (7..TERMS).map(|i| matrix[i][i]).sum();
        (7..TERMS).for_each(|i| matrix[i][i] += 1e-4 * spread + 1e-30);
        solve(&mut matrix, &mut right)?;
        Some(Fit { coefficients: right.map(|row| row.map(|x| x as f32)) })
    }
}

impl Fit {
    /// What it says for these features.
    #[inline]
    pub(crate) fn at(&self, features: &Features) -> Triple {
        let mut color = [0.0; 3];
        for (feature, coefficients) in features.iter().zip(&self.coefficients) {
            for k in 0..3 {
                color[k] += feature * coefficients[k];
            }
        }
        color
    }
}

/// Cholesky's way; `right` becomes the solution. `None` if the matrix is not positive definite.
fn solve(matrix: &mut [[f64; TERMS]; TERMS], right: &mut [[f64; 3]; TERMS]) -> Option<()> {
    for i in 0..TERMS {
        for j in 0..=i {
            let mut sum = matrix[i][j];
            (0..j).for_each(|k| sum -= matrix[i][k] * matrix[j][k]);
            if i == j {
                if sum.is_nan() || sum <= 0.0 {
                    return None;
                }
                matrix[i][i] = sum.sqrt();
            } else {
                matrix[i][j] = sum / matrix[j][j];
            }
        }
    }
    let mut settle = |i: usize, known: std::ops::Range<usize>, factor: &dyn Fn(usize) -> f64| {
        let mut row = right[i];
        for k in known {
            (0..3).for_each(|c| row[c] -= factor(k) * right[k][c]);
        }
        right[i] = row.map(|x| x / matrix[i][i]);
    };
    (0..TERMS).for_each(|i| settle(i, 0..i, &|k| matrix[i][k]));
    (0..TERMS).rev().for_each(|i| settle(i, i + 1..TERMS, &|k| matrix[k][i]));
    right.as_flattened().iter().all(|x| x.is_finite()).then_some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    #[test]
    fn linear_functions_are_found() {
        let mut random = Random::new(3);
        let truth: [Triple; TERMS] = std::array::from_fn(|_| [0; 3].map(|_| random.between(-1.0, 1.0)));
        let wanted = |features: &Features| {
            [0, 1, 2].map(|k| features.iter().zip(&truth).map(|(f, t)| f * t[k]).sum::<f32>())
        };
        let mut features =
            || -> Features { std::array::from_fn(|i| if i == 0 { 1.0 } else { random.between(-1.0, 1.0) }) };
        let mut regression = Regression::new();
        for i in 0..400 {
            let at = features();
            regression.add(0.1 + (i % 7) as f32, &at, &wanted(&at));
        }
        let fit = regression.solve(1e-3).expect("there are neighbours");
        for _ in 0..50 {
            let at = features();
            let (found, wanted) = (fit.at(&at), wanted(&at));
            for k in 0..3 {
                assert!((found[k] - wanted[k]).abs() < 2e-3, "{found:?}, not {wanted:?}");
            }
        }
    }

    #[test]
    fn features_that_do_not_differ_leave_a_mean() {
        let mut regression = Regression::new();
        let mut at = [0.0; TERMS];
        at[0] = 1.0;
        for (weight, value) in [(1.0, 2.0), (3.0, 6.0)] {
            regression.add(weight, &at, &[value, 0.0, -value]);
        }
        let found = regression.solve(0.02).expect("there are neighbours").at(&at);
        assert!((found[0] - 5.0).abs() < 1e-5 && found[1] == 0.0, "the weighted mean is 5: {found:?}");
        assert!(Regression::new().solve(0.02).is_none(), "nothing comes of nothing");
    }
}
