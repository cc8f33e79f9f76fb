// SPDX-License-Identifier: GPL-3.0-or-later
//! Transforms that statements multiply to the current one.
//! Source: the section Transformations of the file-format page. Space: pbrt's left-handed one; angles in degrees.
//! Tests: `tests`.

use gnurt_scene::Affine;

/// The transform of `LookAt`, from the world to what looks at a point; `None` where eye and point are one or `up` says nothing.
pub(crate) fn look_at(eye: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Option<Affine> {
    let forward = unit([0, 1, 2].map(|k| target[k] - eye[k]))?;
    let right = unit(cross(unit(up)?, forward))?;
    let upright = cross(forward, right);
    Affine { columns: [right, upright, forward, eye] }.inverse()
}

/// Sixteen numbers, columns first; `None` if the last row is not 0 0 0 1, nor a multiple of it.
pub(crate) fn matrix(numbers: [f64; 16]) -> Option<Affine> {
    let [x, y, z, w] = [3, 7, 11, 15].map(|i| numbers[i]);
    if [x, y, z] != [0.0; 3] || w == 0.0 {
        return None;
    }
    let column = |i: usize| [0, 1, 2].map(|k| numbers[4 * i + k] / w);
    let matrix = Affine { columns: [column(0), column(1), column(2), column(3)] };
    matrix.is_finite().then_some(matrix)
}

/// The vector product.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The scalar product.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The direction of a vector, if it has one.
pub(crate) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|x| x / length))
}

/// In double precision.
pub(crate) fn double(v: [f32; 3]) -> [f64; 3] {
    v.map(f64::from)
}

/// In single precision.
pub(crate) fn single(v: [f64; 3]) -> [f32; 3] {
    v.map(|x| x as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_looks_sees_the_target_ahead() {
        let view = look_at([0.0, 0.0, -5.0], [0.0; 3], [0.0, 1.0, 0.0]).expect("a view");
        let ahead = view.point([0.0; 3]);
        assert!((ahead[2] - 5.0).abs() < 1e-12, "{ahead:?}");
        assert_eq!(view.point([1.0, 0.0, -5.0]), [1.0, 0.0, 0.0], "x is on the right, and z goes ahead");
        assert_eq!(look_at([0.0; 3], [0.0; 3], [0.0, 1.0, 0.0]), None);
    }

    #[test]
    fn matrices_have_columns_first() {
        let mut numbers = [0.0; 16];
        [0, 5, 10, 15].into_iter().for_each(|i| numbers[i] = 1.0);
        numbers[12] = 7.0;
        assert_eq!(matrix(numbers).map(|m| m.point([0.0; 3])), Some([7.0, 0.0, 0.0]));
        numbers[3] = 0.5;
        assert_eq!(matrix(numbers), None, "projective");
    }
}
