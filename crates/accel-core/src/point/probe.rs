// SPDX-License-Identifier: GPL-3.0-or-later
//! The point of a nearest-point query, transformed into the space of an object. Eigenvalues by the method of
//! Jacobi [GL13]. Tests: `tests::eigenvectors_span_the_map`, `tests/closest_point.rs`.

/// A point and the map back to the space in which distances count.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// In the space of the tree that is searched.
    pub point: [f64; 3],
    /// Images of that space's axes where distances count.
    pub axes: [[f64; 3]; 3],
    /// Lengths grow by at least this factor in the map back.
    pub least_growth: f64,
    /// Which masks it sees.
    pub mask: u32,
}

impl Probe {
    /// In the space where distances count.
    pub fn new(point: [f64; 3], mask: u32) -> Self {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self { point, axes, least_growth: 1.0, mask }
    }

    /// The same in a space inside of this one, where it is at `point`; `axes` are the images of the axes in this one.
    pub fn inside(&self, point: [f64; 3], axes: &[[f64; 3]; 3]) -> Self {
        let axes = axes.map(|axis| self.vector(axis));
        let (values, _) = eigen(&square(&axes));
        // Subtracts the possible error of the method, relative to the greatest value.
        let least = values[0] - 1e-14 * values[2];
        Self { point, axes, least_growth: least.max(0.0).sqrt() * (1.0 - 1e-12), mask: self.mask }
    }

    /// A vector of the searched space where distances count.
    pub fn vector(&self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.axes;
        [0, 1, 2].map(|k| x[k] * v[0] + y[k] * v[1] + z[k] * v[2])
    }

    /// The offset from the probe to a point of the searched space, where distances count.
    pub fn offset(&self, to: [f64; 3]) -> [f64; 3] {
        self.vector([0, 1, 2].map(|k| to[k] - self.point[k]))
    }

    /// How far away something may be in the searched space, to be within `distance`.
    pub fn radius_for(&self, distance: f64) -> f64 {
        distance / self.least_growth
    }
}

/// The products of all pairs of axes: lengths, seen from inside, squared.
pub(super) fn square(axes: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    axes.map(|a| axes.map(|b| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]))
}

/// Eigenvalues of a symmetric matrix, ascending, and their unit vectors.
pub(super) fn eigen(matrix: &[[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut m = *matrix;
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Each sweep squares the remaining off-diagonal elements.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q] == 0.0 {
                continue;
            }
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let rotate = |a: [f64; 3], b: [f64; 3]| {
                ([0, 1, 2].map(|k| c * a[k] - s * b[k]), [0, 1, 2].map(|k| s * a[k] + c * b[k]))
            };
            (m[p], m[q]) = rotate(m[p], m[q]);
            for row in &mut m {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            (vectors[p], vectors[q]) = rotate(vectors[p], vectors[q]);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| m[a][a].total_cmp(&m[b][b]));
    (order.map(|i| m[i][i]), order.map(|i| vectors[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_span_the_map() {
        for axes in [
            [[1.0, 2.0, 3.0], [-1.0, 0.5, 0.0], [0.1, 0.0, -7.0]],
            [[0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 2.0]],
            [[1e-3, 0.0, 0.0], [0.0, 5.0, 1e-9], [0.0, 0.0, 5.0]],
        ] {
            let matrix = square(&axes);
            let (values, vectors) = eigen(&matrix);
            assert!(values.is_sorted(), "ascending: {values:?}");
            for (value, v) in values.iter().zip(&vectors) {
                for (row, x) in matrix.iter().zip(v) {
                    let image = row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
                    assert!((image - value * x).abs() < 1e-12 * values[2], "{v:?} is stretched by {value}");
                }
            }
            let probe = Probe::new([0.0; 3], !0).inside([0.0; 3], &axes);
            let least = vectors[0];
            let image = probe.vector(least).iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!(
                image >= probe.least_growth && image < 1.001 * probe.least_growth,
                "{image} is the least"
            );
        }
    }
}
