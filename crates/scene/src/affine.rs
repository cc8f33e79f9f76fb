// SPDX-License-Identifier: GPL-3.0-or-later
//! Affine transforms in double precision: `world_from_object` and the like.
//! Double precision, so that objects far from the origin keep their position. Names read
//! `destination_from_source`, so products read left to right.
//! Tests: `tests::{inverse_undoes, rotation_is_right_handed}`.

use serde::{Deserialize, Serialize};

/// `p' = m * p + t`; `m` is stored by columns, column 3 is `t`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Affine {
    /// Images of the x, y and z axes, then of the origin.
    pub columns: [[f64; 3]; 4],
}

impl Default for Affine {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Affine {
    /// Leaves every point where it is.
    pub const IDENTITY: Self =
        Self { columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]] };

    /// Moves by `t`.
    #[must_use]
    pub fn translation(t: [f64; 3]) -> Self {
        let [x, y, z, _] = Self::IDENTITY.columns;
        Self { columns: [x, y, z, t] }
    }

    /// Scales each axis.
    #[must_use]
    pub fn scale(s: [f64; 3]) -> Self {
        Self { columns: [[s[0], 0.0, 0.0], [0.0, s[1], 0.0], [0.0, 0.0, s[2]], [0.0; 3]] }
    }

    /// A rotation by `radians` around `axis` (any length but zero), counter-clockwise seen from the axis'
    /// tip.
    #[must_use]
    pub fn rotation(axis: [f64; 3], radians: f64) -> Self {
        let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        if length == 0.0 {
            return Self::IDENTITY;
        }
        let [x, y, z] = axis.map(|a| a / length);
        let (s, c) = radians.sin_cos();
        let d = 1.0 - c;
        Self {
            columns: [
                [x * x * d + c, y * x * d + z * s, z * x * d - y * s],
                [x * y * d - z * s, y * y * d + c, z * y * d + x * s],
                [x * z * d + y * s, y * z * d - x * s, z * z * d + c],
                [0.0; 3],
            ],
        }
    }

    /// The upper three rows of a column-major 4 x 4 matrix, as OpenGL, OpenRT and glTF store it; the last row is
    /// taken to be 0 0 0 1.
    #[must_use]
    pub fn from_column_major(m: &[f64; 16]) -> Self {
        Self { columns: [0, 1, 2, 3].map(|c| [m[4 * c], m[4 * c + 1], m[4 * c + 2]]) }
    }

    /// The same transform as a column-major 4 x 4 matrix.
    #[must_use]
    pub fn to_column_major(&self) -> [f64; 16] {
        std::array::from_fn(|i| match (i / 4, i % 4) {
            (3, 3) => 1.0,
            (_, 3) => 0.0,
            (column, row) => self.columns[column][row],
        })
    }

    /// Transforms a point.
    #[must_use]
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let v = self.vector(p);
        [0, 1, 2].map(|k| v[k] + self.columns[3][k])
    }

    /// Transforms a direction: no translation.
    #[must_use]
    pub fn vector(&self, v: [f64; 3]) -> [f64; 3] {
        let [a, b, c, _] = self.columns;
        [0, 1, 2].map(|k| a[k] * v[0] + b[k] * v[1] + c[k] * v[2])
    }

    /// Determinant of the linear part; negative where the transform mirrors, 0 where it flattens.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        let [a, b, c, _] = self.columns;
        a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
            + c[0] * (a[1] * b[2] - a[2] * b[1])
    }

    /// Whether it keeps the form of everything, and turns spheres into spheres: it scales all directions alike.
    #[must_use]
    pub fn is_similarity(&self) -> bool {
        let [a, b, c, _] = self.columns;
        let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
        let square = dot(a, a);
        let near = |x: f64, y: f64| (x - y).abs() <= 1e-6 * square;
        near(dot(b, b), square)
            && near(dot(c, c), square)
            && [dot(a, b), dot(b, c), dot(c, a)].into_iter().all(|x| near(x, 0.0))
    }

    /// The transform that undoes this one, or `None` where it flattens space or has a value that is not finite.
    #[must_use]
    pub fn inverse(&self) -> Option<Self> {
        let det = self.determinant();
        if det == 0.0 || !det.is_finite() || !(1.0 / det).is_finite() {
            return None;
        }
        let [a, b, c, t] = self.columns;
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        // Rows of the inverse are the cross products of the columns over the determinant.
        let rows = [cross(b, c), cross(c, a), cross(a, b)].map(|row| row.map(|x| x / det));
        let column = |k: usize| [rows[0][k], rows[1][k], rows[2][k]];
        let origin = rows.map(|r| -(r[0] * t[0] + r[1] * t[1] + r[2] * t[2]));
        let inverse = Self { columns: [column(0), column(1), column(2), origin] };
        inverse.is_finite().then_some(inverse)
    }

    /// Whether every entry is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.columns.iter().flatten().all(|x| x.is_finite())
    }

    /// Rounded to single precision: four columns.
    #[must_use]
    pub fn to_f32(&self) -> [[f32; 3]; 4] {
        self.columns.map(|column| column.map(|x| x as f32))
    }
}

impl std::ops::Mul for Affine {
    type Output = Self;

    /// `a_from_b * b_from_c` is `a_from_c`.
    fn mul(self, rhs: Self) -> Self {
        let [x, y, z, t] = rhs.columns;
        Self { columns: [self.vector(x), self.vector(y), self.vector(z), self.point(t)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f64; 3], b: [f64; 3]) -> bool {
        (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12)
    }

    #[test]
    fn inverse_undoes() {
        let m = Affine::translation([1.0, -2.0, 3.0])
            * Affine::rotation([1.0, 1.0, 0.3], 0.7)
            * Affine::scale([2.0, 0.5, -3.0]);
        let p = [0.3, 0.4, 0.5];
        let back = m.inverse().expect("it does not flatten");
        assert!(close(back.point(m.point(p)), p), "there and back");
        assert!(m.determinant() < 0.0, "one axis is mirrored");
        assert_eq!(Affine::scale([1.0, 0.0, 1.0]).inverse(), None, "flat");
        assert_eq!(Affine::from_column_major(&m.to_column_major()), m, "the matrix form loses nothing");
    }

    #[test]
    fn rotation_is_right_handed() {
        let quarter = Affine::rotation([0.0, 0.0, 2.0], std::f64::consts::FRAC_PI_2);
        assert!(close(quarter.point([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]), "x goes to y around z");
    }
}
