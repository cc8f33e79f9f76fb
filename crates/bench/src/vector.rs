// SPDX-License-Identifier: GPL-3.0-or-later
//! The few operations on three numbers that rays are made with. The basis is that of \[DBC*17\].

pub(crate) type V3 = [f32; 3];

pub(crate) fn minus(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + s * b`.
pub(crate) fn along(a: V3, s: f32, b: V3) -> V3 {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

pub(crate) fn dot(a: V3, b: V3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: V3) -> f32 {
    a.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>().sqrt() as f32
}

/// Of unit length; zero stays zero.
pub(crate) fn unit(a: V3) -> V3 {
    let length = a.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>().sqrt();
    if length > 0.0 { a.map(|x| (f64::from(x) / length) as f32) } else { a }
}

/// Two unit vectors that are perpendicular to the unit vector `n` and to each other.
pub(crate) fn basis(n: V3) -> [V3; 2] {
    let sign = 1f32.copysign(n[2]);
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    [[1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]], [b, sign + n[1] * n[1] * a, -n[1]]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_perpendicular() {
        for n in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, -0.0], unit([1.0, -2.0, 0.5])] {
            let [a, b] = basis(n);
            for (x, y) in [(a, b), (a, n), (b, n)] {
                assert!(dot(x, y).abs() < 1e-6, "{x:?} and {y:?} of {n:?} are perpendicular");
            }
            assert!((length(a) - 1.0).abs() < 1e-6 && (length(b) - 1.0).abs() < 1e-6, "of unit length");
        }
    }
}
