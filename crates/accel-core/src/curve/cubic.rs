// SPDX-License-Identifier: GPL-3.0-or-later
//! A cubic in the basis of powers: points and radii, their slopes, and bounds of a part.
//! Invariant: a parameter gives the same bits in all parts of a curve, so that parts meet without a gap.
//! Tests: `tests::parts_are_bounded`.

/// Four numbers. Written out: `map` may be a call where the caller is compiled for other instructions.
#[inline(always)]
fn four(of: impl Fn(usize) -> f64) -> [f64; 4] {
    [of(0), of(1), of(2), of(3)]
}

/// Points and radii along a parameter from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Cubic {
    /// Factors of the powers from 0 to 3.
    powers: [[f64; 4]; 4],
}

impl Cubic {
    /// That of Bezier's control points.
    pub(super) fn new(control: [[f64; 4]; 4]) -> Self {
        let mut powers = [[0.0; 4]; 4];
        for k in 0..4 {
            let [a, b, c, d] = control.map(|point| point[k]);
            let of_axis = [a, 3.0 * (b - a), 3.0 * (a - 2.0 * b + c), d - a - 3.0 * (c - b)];
            for (power, x) in powers.iter_mut().zip(of_axis) {
                power[k] = x;
            }
        }
        Self { powers }
    }

    /// That of four vertices, by the weight of each in each power.
    #[inline(always)]
    pub(super) fn weighted(vertices: &[[f32; 4]; 4], weights: &[[f64; 4]; 4]) -> Self {
        let vertex = |i: usize| four(|k| f64::from(vertices[i][k]));
        let vertices = [vertex(0), vertex(1), vertex(2), vertex(3)];
        // From 0 on, so that no sum is -0.
        let of = |weights: &[f64; 4]| {
            four(|k| {
                0.0 + weights[0] * vertices[0][k]
                    + weights[1] * vertices[1][k]
                    + weights[2] * vertices[2][k]
                    + weights[3] * vertices[3][k]
            })
        };
        let [a, b, c, d] = weights;
        Self { powers: [of(a), of(b), of(c), of(d)] }
    }

    /// Between this one and another, by the weights of the two.
    pub(super) fn mixed(&self, to: &Self, [a, b]: [f64; 2]) -> Self {
        let mix = |i: usize| [0, 1, 2, 3].map(|k| a * self.powers[i][k] + b * to.powers[i][k]);
        Self { powers: [mix(0), mix(1), mix(2), mix(3)] }
    }

    #[inline(always)]
    pub(super) fn at(&self, t: f64) -> [f64; 4] {
        let [a, b, c, d] = &self.powers;
        four(|k| a[k] + t * (b[k] + t * (c[k] + t * d[k])))
    }

    /// The first derivative.
    #[inline(always)]
    pub(super) fn slope(&self, t: f64) -> [f64; 4] {
        let [_, b, c, d] = &self.powers;
        four(|k| b[k] + t * (2.0 * c[k] + t * (3.0 * d[k])))
    }

    /// The second derivative.
    #[inline(always)]
    pub(super) fn bend(&self, t: f64) -> [f64; 4] {
        let [_, _, c, d] = &self.powers;
        four(|k| 2.0 * c[k] + 6.0 * t * d[k])
    }

    /// A radius that no point has more than: the greatest of Bezier's control points.
    #[inline(always)]
    pub(super) fn greatest_radius(&self) -> f64 {
        let [a, b, c, d] = four(|i| self.powers[i][3]);
        a.max(a + b / 3.0).max(a + (2.0 * b + c) / 3.0).max(a + b + c + d)
    }

    /// Relative to `origin`, with its vectors mapped.
    #[inline(always)]
    pub(super) fn mapped(&self, vector: impl Fn([f64; 3]) -> [f64; 3], origin: [f64; 3]) -> Self {
        let map = |[x, y, z, r]: [f64; 4]| {
            let [x, y, z] = vector([x, y, z]);
            [x, y, z, r]
        };
        let [a, b, c, d] = self.powers;
        let a = [a[0] - origin[0], a[1] - origin[1], a[2] - origin[2], a[3]];
        Self { powers: [map(a), map(b), map(c), map(d)] }
    }

    /// Control points of the part between two parameters.
    #[cfg(test)]
    fn part(&self, from: f64, to: f64) -> [[f64; 4]; 4] {
        let (p, q, step) = (self.at(from), self.at(to), (to - from) / 3.0);
        let (s, e) = (self.slope(from), self.slope(to));
        let inner = |p: [f64; 4], s: [f64; 4], step: f64| [0, 1, 2, 3].map(|k| p[k] + step * s[k]);
        [p, inner(p, s, step), inner(q, e, -step), q]
    }

    /// The length of the second derivative of the points. It is linear: greatest at an end of any part.
    #[inline(always)]
    pub(super) fn bend_length(&self, t: f64) -> f64 {
        let [x, y, z, _] = self.bend(t);
        (x * x + y * y + z * z).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_bounded() {
        let control =
            [[0.0, 1.0, 2.0, 0.5], [3.0, -1.0, 2.5, 0.25], [-2.0, 4.0, 0.0, 1.0], [1.0, 1.0, 1.0, 0.0]];
        let cubic = Cubic::new(control);
        let near = |a: [f64; 4], b: [f64; 4]| (0..4).all(|k| (a[k] - b[k]).abs() < 1e-12);
        assert!(near(cubic.at(0.0), control[0]) && near(cubic.at(1.0), control[3]), "it joins its ends");
        assert!((cubic.greatest_radius() - 1.0).abs() < 1e-12, "that of the third control point");
        let part = Cubic::new(cubic.part(0.25, 0.75));
        for i in 0..=8 {
            let t = f64::from(i) / 8.0;
            assert!(near(part.at(t), cubic.at(0.25 + 0.5 * t)), "a part is the same curve");
            let h = 1e-6;
            let slope = [0, 1, 2, 3].map(|k| (cubic.at(t + h)[k] - cubic.at(t - h)[k]) / (2.0 * h));
            let bend = [0, 1, 2, 3].map(|k| (cubic.slope(t + h)[k] - cubic.slope(t - h)[k]) / (2.0 * h));
            let same = |a: [f64; 4], b: [f64; 4]| (0..4).all(|k| (a[k] - b[k]).abs() < 1e-6);
            assert!(same(slope, cubic.slope(t)) && same(bend, cubic.bend(t)), "derivatives at {t}");
        }
    }
}
