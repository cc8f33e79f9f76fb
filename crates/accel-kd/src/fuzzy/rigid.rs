// SPDX-License-Identifier: GPL-3.0-or-later
//! Rigid motions, and the one that fits points best.
//! Source: [Hor87], sections 4 and 5: the rotation is the eigenvector of the greatest eigenvalue of a matrix of 4 x 4, found by
//! rotations of Jacobi. Spaces: from rest to a pose. Tests: `tests`.

/// `rotation * rest + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rigid {
    /// Rows.
    rotation: [[f64; 3]; 3],
    shift: [f64; 3],
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

impl Rigid {
    /// The motion that brings points at rest nearest to those of a pose, by the sum of squares. Without points it is none.
    pub(super) fn fit(points: impl Iterator<Item = [[f32; 3]; 2]> + Clone) -> Self {
        let (mut sums, mut count) = ([[0.0; 3]; 2], 0.0);
        for pair in points.clone() {
            count += 1.0;
            for (sum, point) in sums.iter_mut().zip(pair) {
                *sum = [0, 1, 2].map(|k| sum[k] + f64::from(point[k]));
            }
        }
        let [rest, posed] = sums.map(|sum| sum.map(|x| if count > 0.0 { x / count } else { 0.0 }));
        let mut s = [[0.0; 3]; 3];
        for [a, b] in points {
            let (a, b) = (minus(a.map(f64::from), rest), minus(b.map(f64::from), posed));
            for (row, a) in s.iter_mut().zip(a) {
                *row = [0, 1, 2].map(|k| row[k] + a * b[k]);
            }
        }
        let rotation = rotation(greatest_axis(quaternions(&s)));
        let turned = rotation.map(|row| dot(row, rest));
        Self { rotation, shift: minus(posed, turned) }
    }

    /// A point of the pose at rest.
    #[inline]
    pub(super) fn at_rest(&self, point: [f32; 3]) -> [f64; 3] {
        self.turn_back(minus(point.map(f64::from), self.shift))
    }

    /// A direction of the pose at rest.
    #[inline]
    pub(super) fn turn_back(&self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = &self.rotation;
        [0, 1, 2].map(|k| x[k] * v[0] + y[k] * v[1] + z[k] * v[2])
    }
}

/// The matrix whose quadratic form in a quaternion is how well its rotation fits sums of products.
fn quaternions(s: &[[f64; 3]; 3]) -> [[f64; 4]; 4] {
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = *s;
    [
        [xx + yy + zz, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy],
    ]
}

/// The unit eigenvector of the greatest eigenvalue of a symmetric matrix; the first of equals.
fn greatest_axis(mut m: [[f64; 4]; 4]) -> [f64; 4] {
    let mut axes = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    // Quadratic convergence: five or six rounds are enough for doubles.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            if m[p][q] == 0.0 {
                continue;
            }
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let cos = 1.0 / tangent.hypot(1.0);
            let sin = tangent * cos;
            for row in &mut m {
                (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
            }
            let (a, b) = (m[p], m[q]);
            m[p] = [0, 1, 2, 3].map(|k| cos * a[k] - sin * b[k]);
            m[q] = [0, 1, 2, 3].map(|k| sin * a[k] + cos * b[k]);
            let (a, b) = (axes[p], axes[q]);
            axes[p] = [0, 1, 2, 3].map(|k| cos * a[k] - sin * b[k]);
            axes[q] = [0, 1, 2, 3].map(|k| sin * a[k] + cos * b[k]);
        }
    }
    let best = (1..4).fold(0, |best, i| if m[i][i] > m[best][best] { i } else { best });
    axes[best]
}

fn rotation([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    let size = w * w + x * x + y * y + z * z;
    [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (y * x + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (z * x - w * y), 2.0 * (z * y + w * x), w * w - x * x - y * y + z * z],
    ]
    .map(|row| row.map(|x| x / size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    #[test]
    fn motions_are_found_again() {
        let mut random = Random::new(6);
        for i in 0..200 {
            let mut number = || 2.0 * f64::from(random.unit()) - 1.0;
            let turn = rotation([number(), number(), number(), number()]);
            let shift = [number() * 10.0, number(), number()];
            // Also flat and straight ones, whose rotation is not unique.
            let flat = if i % 3 == 0 { 0.0 } else { 1.0 };
            let straight = if i % 6 == 0 { 0.0 } else { 1.0 };
            let points: Vec<[[f32; 3]; 2]> = (0..8)
                .map(|_| {
                    let rest = [number(), straight * number(), flat * number()].map(|x| x as f32);
                    let to = [0, 1, 2].map(|k| dot(turn[k], rest.map(f64::from)) + shift[k]);
                    [rest, to.map(|x| x as f32)]
                })
                .collect();
            let found = Rigid::fit(points.iter().copied());
            for [rest, posed] in points {
                let back = found.at_rest(posed);
                for k in 0..3 {
                    assert!((back[k] - f64::from(rest[k])).abs() < 1e-5, "{i}: {back:?} is not {rest:?}");
                }
            }
            let [x, y, z] = found.rotation;
            let volume =
                dot(x, [y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0]]);
            assert!((volume - 1.0).abs() < 1e-12, "no reflection: {volume}");
        }
        let still = Rigid::fit(std::iter::empty());
        assert_eq!(still.at_rest([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0], "nothing does not move");
    }
}
