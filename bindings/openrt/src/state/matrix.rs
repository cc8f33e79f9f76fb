// SPDX-License-Identifier: GPL-3.0-or-later
//! 4 x 4 matrices in double precision, column-major as in OpenGL.
//! Rotation, frustum and parallel projection in the closed forms that OpenGL defines.
//! Space: the program's own. Tests: `tests`; tests/c/scene.c.

use gnurt::scene::Affine;

/// A matrix; element (row r, column c) is number `4 c + r`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Matrix(pub [f64; 16]);

impl Matrix {
    /// Changes nothing.
    pub(crate) const IDENTITY: Self =
        Self([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);

    /// Scales each axis.
    #[must_use]
    pub(crate) fn scale(s: [f64; 3]) -> Self {
        Affine::scale(s).into()
    }

    /// Moves by `t`.
    #[must_use]
    pub(crate) fn translation(t: [f64; 3]) -> Self {
        Affine::translation(t).into()
    }

    /// Rotates by an angle around an axis of any length; a zero axis gives the identity.
    #[must_use]
    pub(crate) fn rotation(degrees: f64, axis: [f64; 3]) -> Self {
        Affine::rotation(axis, degrees.to_radians()).into()
    }

    /// OpenGL's perspective through a rectangle on the near plane. `None` where it is an error in OpenGL.
    #[must_use]
    pub(crate) fn frustum(x: [f64; 2], y: [f64; 2], [near, far]: [f64; 2]) -> Option<Self> {
        let [width, height, depth] = extents(x, y, [near, far])?;
        let usable = near > 0.0 && far > 0.0;
        let mut m = [0.0; 16];
        m[0] = 2.0 * near / width;
        m[5] = 2.0 * near / height;
        m[8] = (x[1] + x[0]) / width;
        m[9] = (y[1] + y[0]) / height;
        m[10] = -(far + near) / depth;
        m[11] = -1.0;
        m[14] = -2.0 * far * near / depth;
        usable.then_some(Self(m))
    }

    /// OpenGL's parallel projection of a box. `None` where it is an error in OpenGL.
    #[must_use]
    pub(crate) fn ortho(x: [f64; 2], y: [f64; 2], [near, far]: [f64; 2]) -> Option<Self> {
        let [width, height, depth] = extents(x, y, [near, far])?;
        let mut m = Self::IDENTITY.0;
        m[0] = 2.0 / width;
        m[5] = 2.0 / height;
        m[10] = -2.0 / depth;
        m[12] = -(x[1] + x[0]) / width;
        m[13] = -(y[1] + y[0]) / height;
        m[14] = -(far + near) / depth;
        Some(Self(m))
    }

    /// A perspective of `fov_y` degrees, as wide as high. Planes that make no sense are replaced by 0.1 and 1000: no
    /// ray is clipped at them, but programs may read the matrix. `None` unless `0 < fov_y < 180`.
    #[must_use]
    pub(crate) fn perspective(fov_y: f64, planes: [f64; 2]) -> Option<Self> {
        let sensible = planes[0] > 0.0 && planes[1] > planes[0] && planes[1].is_finite();
        let [near, far] = if sensible { planes } else { [0.1, 1000.0] };
        let reach = near * (fov_y.to_radians() / 2.0).tan();
        let usable = fov_y > 0.0 && fov_y < 180.0 && reach > 0.0;
        if usable { Self::frustum([-reach, reach], [-reach, reach], [near, far]) } else { None }
    }

    /// Rows become columns.
    #[must_use]
    pub(crate) fn transposed(self) -> Self {
        Self(std::array::from_fn(|i| self.0[4 * (i % 4) + i / 4]))
    }

    /// `self * v`.
    #[must_use]
    #[inline]
    pub(crate) fn apply(&self, v: [f64; 4]) -> [f64; 4] {
        let m = &self.0;
        [0, 1, 2, 3].map(|r| m[r] * v[0] + m[4 + r] * v[1] + m[8 + r] * v[2] + m[12 + r] * v[3])
    }

    /// The matrix that normals are multiplied with, by columns: the inverse transpose of the linear part up to a
    /// positive factor, so that it exists for flat matrices too.
    #[must_use]
    pub(crate) fn normal_matrix(&self) -> [[f64; 3]; 3] {
        let [a, b, c] = [0, 4, 8].map(|i| [self.0[i], self.0[i + 1], self.0[i + 2]]);
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
        let determinant: f64 = (0..3).map(|k| a[k] * cofactors[0][k]).sum();
        let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
        cofactors.map(|column| column.map(|x| sign * x))
    }

    /// The affine part; the last row is taken to be 0 0 0 1 after division by its last element.
    #[must_use]
    pub(crate) fn to_affine(self) -> Affine {
        let w = self.0[15];
        let divisor = if w == 0.0 { 1.0 } else { w };
        Affine::from_column_major(&self.0.map(|x| x / divisor))
    }

    /// Rounded to single precision.
    #[must_use]
    pub(crate) fn to_f32(self) -> [f32; 16] {
        self.0.map(|x| x as f32)
    }
}

/// Width, height and depth of a view volume; `None` if one is 0 or not finite.
fn extents(x: [f64; 2], y: [f64; 2], z: [f64; 2]) -> Option<[f64; 3]> {
    let extents = [x, y, z].map(|[low, high]| high - low);
    extents.iter().all(|e| *e != 0.0 && e.is_finite()).then_some(extents)
}

impl From<Affine> for Matrix {
    fn from(affine: Affine) -> Self {
        Self(affine.to_column_major())
    }
}

impl std::ops::Mul for Matrix {
    type Output = Self;

    /// `a * b` does `b` first.
    fn mul(self, rhs: Self) -> Self {
        let mut product = [0.0; 16];
        for (c, column) in product.chunks_exact_mut(4).enumerate() {
            let of = &rhs.0[4 * c..4 * c + 4];
            column.copy_from_slice(&self.apply([of[0], of[1], of[2], of[3]]));
        }
        Self(product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_apply_the_right_factor_first() {
        let m = Matrix::translation([1.0, 2.0, 3.0]) * Matrix::scale([2.0, 2.0, 2.0]);
        assert_eq!(m.apply([1.0, 0.0, 0.0, 1.0]), [3.0, 2.0, 3.0, 1.0], "scaled, then moved");
        assert_eq!(m.transposed().transposed(), m, "twice is not at all");
        assert_eq!(m.transposed().0[3], 1.0, "the translation is in the last row now");
    }

    #[test]
    fn normals_stay_perpendicular() {
        let m = Matrix::rotation(30.0, [1.0, 2.0, 3.0]) * Matrix::scale([1.0, -4.0, 0.5]);
        let (tangent, normal) = ([1.0, 1.0, 0.0, 0.0], [1.0, -1.0, 0.0]);
        let [c0, c1, c2] = m.normal_matrix();
        let moved = [0, 1, 2].map(|k| c0[k] * normal[0] + c1[k] * normal[1] + c2[k] * normal[2]);
        let along = m.apply(tangent);
        let dot: f64 = (0..3).map(|k| moved[k] * along[k]).sum();
        assert!(dot.abs() < 1e-12, "perpendicular before and after: {dot}");
        let recorded = m.apply([normal[0], normal[1], normal[2], 0.0]);
        assert!(
            (0..3).map(|k| moved[k] * recorded[k]).sum::<f64>() > 0.0,
            "on the same side, mirrored or not"
        );
    }

    #[test]
    fn projections_send_corners_to_corners() {
        let m = Matrix::frustum([-1.0, 3.0], [-2.0, 2.0], [1.0, 5.0]).expect("a volume");
        let near = m.apply([3.0, -2.0, -1.0, 1.0]);
        assert_eq!(near.map(|x| x / near[3]), [1.0, -1.0, -1.0, 1.0], "lower right of the near plane");
        let m = Matrix::ortho([-1.0, 3.0], [-2.0, 2.0], [1.0, 5.0]).expect("a volume");
        assert_eq!(m.apply([3.0, 2.0, -5.0, 1.0]), [1.0, 1.0, 1.0, 1.0], "upper right of the far plane");
        assert_eq!(Matrix::frustum([-1.0, 1.0], [-1.0, 1.0], [0.0, 1.0]), None, "near must be positive");
        assert_eq!(Matrix::ortho([1.0, 1.0], [-1.0, 1.0], [0.0, 1.0]), None, "no width");
        assert_eq!(Matrix::perspective(180.0, [1.0, 2.0]), None, "too wide");
        assert!(Matrix::perspective(60.0, [0.0, 0.0]).is_some(), "near and far do not matter");
    }
}
