// SPDX-License-Identifier: GPL-3.0-or-later
//! Weighted least squares: colours as a linear function of the features of hits, around one pixel.
//! Source: \[MCY14\] (local linear regression on features), \[BRM*16\] (choice of features, weights from
//! colours). Differs: positions in the picture instead of the world, of which a pixel on an edge has two; the
//! ridge, which keeps undetermined directions constant, is ours. Sums are single, the solution is double
//! precision. Tests: `tests`.

use crate::noisy::Triple;

/// A constant, three each of normal and albedo, column and row.
pub(crate) const TERMS: usize = 9;
/// Inverse squares of slopes of relative light that are expected of normals and albedo, and of positions.
const SLOPES: [f64; 2] = [0.1, 60.0];
/// Terms, then three colours.
pub(crate) const ROW: usize = TERMS + 3;

/// The features of a pixel, the constant first, and its colours.
pub(crate) type Row = [f32; ROW];

/// Normal equations in the making.
pub(crate) struct Regression {
    centre: Row,
    rows: [Row; TERMS],
    /// Least and largest colours.
    range: [Triple; 2],
}

/// Colours as a linear function of features.
pub(crate) struct Fit {
    centre: Row,
    coefficients: [Triple; TERMS],
    range: [Triple; 2],
}

impl Regression {
    /// Features are counted from those of this pixel on.
    #[inline(always)]
    pub(crate) fn around(centre: &Row) -> Self {
        let mut centre = *centre;
        centre[0] = 0.0;
        centre[TERMS..].fill(0.0);
        Self { centre, rows: [[0.0; ROW]; TERMS], range: [[f32::MAX; 3], [f32::MIN; 3]] }
    }

    /// Adds a neighbour.
    #[inline(always)]
    pub(crate) fn add(&mut self, weight: f32, neighbour: &Row) {
        let mut all = *neighbour;
        for (value, centre) in all.iter_mut().zip(&self.centre) {
            *value -= centre;
        }
        for (i, row) in self.rows.iter_mut().enumerate() {
            let scale = weight * all[i];
            for (sum, &value) in row.iter_mut().zip(&all) {
                *sum += scale * value;
            }
        }
        for k in 0..3 {
            self.range[0][k] = self.range[0][k].min(all[TERMS + k]);
            self.range[1][k] = self.range[1][k].max(all[TERMS + k]);
        }
    }

    /// The sum of the weights.
    #[inline(always)]
    pub(crate) fn weight(&self) -> f32 {
        self.rows[0][0]
    }

    /// The best fit; deviations of normals and albedo below `unsure` (in their units) have no effect, and
    /// none of positions below a hundredth of their spread. `None` without neighbours.
    #[inline(always)]
    pub(crate) fn solve(&self, unsure: f32, variance: f32) -> Option<Fit> {
        let weight = f64::from(self.weight());
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
        // Light hardly differs by more than itself over the range of a feature: slopes that noise explains are none.
        let light = (0..3).map(|k| right[0][k]).sum::<f64>() / (3.0 * weight);
        let noise = (f64::from(variance) / (light * light).max(1e-30) - 1.0).clamp(0.0, 1e4);
        (1..7).for_each(|i| matrix[i][i] += SLOPES[0] * noise);
        (7..TERMS).for_each(|i| matrix[i][i] += SLOPES[1] * noise);
        solve(&mut matrix, &mut right)?;
        let coefficients = right.map(|row| row.map(|x| x as f32));
        Some(Fit { centre: self.centre, coefficients, range: self.range })
    }
}

impl Fit {
    /// The prediction for the features of this pixel. A slope from noise overshoots next to bright edges: the
    /// result is limited to the range of the fitted pixels.
    #[inline(always)]
    pub(crate) fn at(&self, pixel: &Row) -> Triple {
        let mut color = self.coefficients[0];
        for (i, coefficients) in self.coefficients.iter().enumerate().skip(1) {
            let feature = pixel[i] - self.centre[i];
            for k in 0..3 {
                color[k] += feature * coefficients[k];
            }
        }
        [0, 1, 2].map(|k| color[k].max(self.range[0][k]).min(self.range[1][k]))
    }
}

/// Cholesky's method; `right` becomes the solution. `None` if the matrix is not positive definite.
#[inline(always)]
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
    for i in 0..TERMS {
        for k in 0..i {
            (0..3).for_each(|c| right[i][c] -= matrix[i][k] * right[k][c]);
        }
        (0..3).for_each(|c| right[i][c] /= matrix[i][i]);
    }
    for i in (0..TERMS).rev() {
        for k in i + 1..TERMS {
            (0..3).for_each(|c| right[i][c] -= matrix[k][i] * right[k][c]);
        }
        (0..3).for_each(|c| right[i][c] /= matrix[i][i]);
    }
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
        let mut pixel = |most: f32| {
            let mut row: Row =
                std::array::from_fn(|i| if i == 0 { 1.0 } else { random.between(-most, most) });
            for k in 0..3 {
                row[TERMS + k] = (0..TERMS).map(|i| row[i] * truth[i][k]).sum();
            }
            row
        };
        let mut regression = Regression::around(&pixel(1.0));
        (0..400).for_each(|i| regression.add(0.1 + (i % 7) as f32, &pixel(1.0)));
        let fit = regression.solve(1e-3, 0.0).expect("there are neighbours");
        for _ in 0..50 {
            // Far from the ends of the range, which no fit leaves.
            let at = pixel(0.2);
            let found = fit.at(&at);
            for k in 0..3 {
                assert!((found[k] - at[TERMS + k]).abs() < 4e-3, "{found:?}, not {at:?}");
            }
        }
    }

    #[test]
    fn features_that_do_not_differ_leave_a_mean() {
        let mut at: Row = [0.5; ROW];
        at[0] = 1.0;
        let mut regression = Regression::around(&at);
        for (weight, value) in [(1.0, 2.0), (3.0, 6.0)] {
            at[TERMS..].copy_from_slice(&[value, 0.0, -value]);
            regression.add(weight, &at);
        }
        let found = regression.solve(0.02, 0.0).expect("there are neighbours").at(&at);
        assert!((found[0] - 5.0).abs() < 1e-5 && found[1] == 0.0, "the weighted mean is 5: {found:?}");
        assert!(Regression::around(&at).solve(0.02, 0.0).is_none(), "nothing comes of nothing");
    }

    #[test]
    fn no_fit_leaves_the_range_of_its_neighbours() {
        let mut at: Row = [0.0; ROW];
        at[0] = 1.0;
        let mut regression = Regression::around(&at);
        for column in 0..5 {
            at[7] = column as f32;
            at[TERMS] = column as f32;
            regression.add(1.0, &at);
        }
        at[7] = 9.0;
        let found = regression.solve(0.02, 0.0).expect("there are neighbours").at(&at);
        assert_eq!(found[0], 4.0, "the slope goes on, the light does not");
    }
}
