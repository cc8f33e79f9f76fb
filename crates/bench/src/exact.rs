// SPDX-License-Identifier: GPL-3.0-or-later
//! The exact intersection of a ray and a triangle, to thirty digits, to judge results of single precision.
//! Source: sums and products of two doubles after \[Dek71\], with the fused operation in place of its splitting; positions
//! sheared as in \[WBW13\], without division. It shares no code with the judged engines. Space: world;
//! directions of any length.
//! Tests: `tests::truth_has_thirty_digits`.

use gnurt::accel::{Ray, Triangles};

/// A number as the sum of two doubles, the second of which the first has rounded off: 106 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Twice(f64, f64);

impl Twice {
    const ZERO: Self = Self(0.0, 0.0);

    fn of_sum(a: f64, b: f64) -> Self {
        let sum = a + b;
        let part = sum - a;
        Self(sum, (a - (sum - part)) + (b - part))
    }

    fn plus(self, other: Self) -> Self {
        let Self(high, low) = Self::of_sum(self.0, other.0);
        let Self(second, last) = Self::of_sum(self.1, other.1);
        let Self(high, low) = Self::of_sum(high, low + second);
        Self::of_sum(high, low + last)
    }

    fn negative(self) -> Self {
        Self(-self.0, -self.1)
    }

    fn minus(self, other: Self) -> Self {
        self.plus(other.negative())
    }

    fn times(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let rest = self.0.mul_add(other.0, -product) + (self.0 * other.1 + self.1 * other.0);
        Self::of_sum(product, rest)
    }

    fn over(self, other: Self) -> f64 {
        self.0 / other.0
    }
}

/// The exact data of a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Truth {
    /// The point where the ray hits the triangle; if it misses, the edge that it passes: negative weights are
    /// none.
    pub(crate) t: f64,
    /// The least weight of a corner: below 0 the ray misses the triangle, by this share of its height.
    pub(crate) inside: f64,
}

/// `None` where the ray is in the triangle's plane, and of a number that there is no triangle of.
pub(crate) fn truth(triangles: &Triangles, ray: &Ray, prim_id: u32) -> Option<Truth> {
    let corners = triangles.indices.get(prim_id as usize)?.map(|i| triangles.positions.get(i as usize));
    let [Some(a), Some(b), Some(c)] = corners else { return None };
    let z = (0..3).max_by(|&i, &j| ray.dir[i].abs().total_cmp(&ray.dir[j].abs()))?;
    let axes = [(z + 1) % 3, (z + 2) % 3, z];
    let [dx, dy, dz] = axes.map(|k| Twice(f64::from(ray.dir[k]), 0.0));
    let from = [a, b, c].map(|p| axes.map(|k| Twice::of_sum(f64::from(p[k]), -f64::from(ray.org[k]))));
    let minor = |a: Twice, b: Twice, c: Twice, d: Twice| a.times(d).minus(b.times(c));
    let along = from.map(|[x, y, z]| [minor(x, dx, z, dz), minor(y, dy, z, dz)]);
    let weight = |b: usize, c: usize| minor(along[c][0], along[c][1], along[b][0], along[b][1]);
    let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
    let sum = |weights: &[Twice; 3]| weights.iter().fold(Twice::ZERO, |sum, &w| sum.plus(w));
    let signed = sum(&weights);
    let weights = if signed.0 < 0.0 { weights.map(Twice::negative) } else { weights };
    let least = weights.iter().map(|w| w.0).fold(f64::INFINITY, f64::min);
    let weights = weights.map(|w| if w.0 < 0.0 { Twice::ZERO } else { w });
    let whole = sum(&weights);
    let depth = weights.iter().zip(&from).fold(Twice::ZERO, |sum, (w, p)| sum.plus(w.times(p[2])));
    let t = depth.over(whole.times(dz));
    // Not so of NaN.
    (signed.0 != 0.0 && t.is_finite()).then(|| Truth { t, inside: least / signed.0.abs() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_has_thirty_digits() {
        let third = Twice(1.0, 0.0).over(Twice(3.0, 0.0));
        let square = Twice(third, 0.0).times(Twice(third, 0.0));
        assert_eq!(
            square.minus(Twice(third * third, 0.0)).0,
            third.mul_add(third, -third * third),
            "the rest"
        );
        let sum = Twice(1.0, 0.0).plus(Twice(1e-25, 0.0)).minus(Twice(1.0, 0.0));
        assert!((sum.0 - 1e-25).abs() < 1e-32, "{sum:?}");

        // A sliver of a millionth of its length, met a thousandth of a millionth before a ray's start, edge on.
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 1e-6], [0.5, 1e-6, 0.0]];
        let triangles = Triangles { positions: &positions, indices: &[[0, 1, 2]] };
        let ray = Ray::new([0.5, 5e-7, 1.0], [0.0, 0.0, -1.0]);
        let Truth { t, inside } = truth(&triangles, &ray, 0).expect("it is met");
        // Weights are a quarter, a quarter and a half, up to the rounding of 1e-6 to a float and half of it.
        let height = 0.25 * f64::from(1e-6f32);
        assert!((t - (1.0 - height)).abs() < 1e-12 && (inside - 0.25).abs() < 1e-6, "{t} {inside}");
        let beside = Ray::new([0.5, -1e-6, 1.0], [0.0, 0.0, -1.0]);
        assert!(truth(&triangles, &beside, 0).is_some_and(|truth| truth.inside < -0.5), "beside it");
        assert_eq!(truth(&triangles, &ray, 1), None, "no such triangle");
        let edge_on = Ray::new([2.0, 0.0, 2e-6], [-1.0, 0.0, -1e-6]);
        assert!(truth(&triangles, &edge_on, 0).is_none_or(|truth| truth.t.is_finite()), "edge on");
    }
}
