// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a line meets a triangle, its edges and corners included: a decision without rounding, and a
//! parameter that is off by less than 1e-13 of itself.
//! Source: the edges of [`line`](super::line), here without ties broken; doubles first, then numbers of twice their precision, then
//! exact ones. Space: that of the query. A line in the plane of a triangle does not meet it.
//! Tests: `tests/doubles.rs` of `gnurt-accel`.

use super::dyadic::Dyadic;
use super::line::{Edge, Line, away, certain, cross_of, largest};
use super::number::{Formula, Number, V3, cross, dot, minus, of, sign};
use super::path::{Triangle, UNIT};
use super::twice::Twice;

/// The relative error that doubles may have in each of two numbers of which a quotient is taken.
const FINE: f64 = 4e-14;

/// Numbers of twice the precision are good for sums that lose this much to cancellation.
const LOST: f64 = 1e-14;

const EDGES: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

impl Line {
    /// The parameter, and the weights of the second and the third corner, where the line meets the triangle between its ends.
    /// `is_certain`: the line is known to pass inside.
    pub fn meets(&self, triangle: &Triangle, is_certain: bool) -> Option<[f64; 3]> {
        // Written out, here and below: `map` would be calls.
        let edge = |(i, j): (usize, usize)| self.edge_value(triangle, i, j);
        let values = [edge(EDGES[0]), edge(EDGES[1]), edge(EDGES[2])];
        if !is_certain && !self.touches(triangle, &values) {
            return None;
        }
        let met = self.roughly(triangle, &values).or_else(|| self.finely(triangle))?;
        (met[0] >= self.near && met[0] <= self.far).then_some(met)
    }

    /// Whether the line passes the edges on one side or through them.
    fn touches(&self, triangle: &Triangle, values: &[(f64, f64); 3]) -> bool {
        let of = |(value, error): (f64, f64)| certain(value, error);
        let mut signs = [of(values[0]), of(values[1]), of(values[2])];
        if signs.contains(&1) && signs.contains(&-1) {
            return false;
        }
        for (side, (i, j)) in signs.iter_mut().zip(EDGES) {
            if *side == 0 {
                *side = sign(&Edge { line: self, triangle, i, j });
            }
        }
        signs.contains(&1) != signs.contains(&-1)
    }

    /// In doubles, if they are good enough.
    fn roughly(&self, triangle: &Triangle, values: &[(f64, f64); 3]) -> Option<[f64; 3]> {
        let [a, b, c] = triangle.near;
        let (to_b, to_c, to_a) = (away(b, a), away(c, a), away(a, self.org));
        let n = cross_of(to_b, to_c);
        let depth = n[0] * to_a[0] + n[1] * to_a[1] + n[2] * to_a[2];
        let slope = n[0] * self.dir[0] + n[1] * self.dir[1] + n[2] * self.dir[2];
        let (u, v, r) = (largest(to_b), largest(to_c), largest(to_a));
        let off = 2.0 * triangle.error;
        let (off_u, off_v) = (off + UNIT * u, off + UNIT * v);
        let off_n = 2.0 * (u * off_v + v * off_u + off_u * off_v) + 4.0 * UNIT * u * v;
        let off_slope = self.size * (off_n + 4.0 * UNIT * u * v);
        let off_depth =
            3.0 * (off_n * r + 2.0 * u * v * (triangle.error + UNIT * r)) + 12.0 * UNIT * u * v * r;
        if !(off_slope <= FINE * slope.abs() && off_depth <= FINE * depth.abs()) {
            return None;
        }
        let weight = |(value, _): (f64, f64)| if value * slope > 0.0 { value.abs() } else { 0.0 };
        let weights = [weight(values[0]), weight(values[1]), weight(values[2])];
        let whole = weights[0] + weights[1] + weights[2];
        (whole > 0.0).then(|| [depth / slope, weights[1] / whole, weights[2] / whole])
    }

    /// By more precise numbers.
    #[cold]
    fn finely(&self, triangle: &Triangle) -> Option<[f64; 3]> {
        let [a, b, c] = triangle.near;
        let parts = Parts { line: self, triangle };
        let within = |[depth, slope, ..]: &[Twice; 5]| {
            let area = largest(away(b, a)) * largest(away(c, a));
            let is_fine = |value: &Twice, all: f64| value.rounded().abs() > LOST * all;
            is_fine(depth, area * largest(away(a, self.org))) && is_fine(slope, area * self.size)
        };
        // Corners that are carried may cancel before: their bound tells.
        if let Some(all) = parts.values::<Twice>().filter(within)
            && triangle.error <= 1e-6 * largest(away(b, a)).min(largest(away(c, a)))
        {
            let [depth, slope, weights @ ..] = all;
            let [_, u, v] = weights.map(|w| w.over(slope).clamp(0.0, 1.0));
            let t = depth.over(slope);
            if t.is_finite() {
                return Some([t, u, v.min(1.0 - u)]);
            }
        }
        let [depth, slope, weights @ ..] = parts.values::<Dyadic>()?;
        if slope.sign() == 0 {
            return None;
        }
        let [_, u, v] = weights.map(|w| w.over(&slope).clamp(0.0, 1.0));
        Some([depth.over(&slope), u, v.min(1.0 - u)])
    }
}

/// The numbers whose quotients are the answer.
struct Parts<'a> {
    line: &'a Line,
    triangle: &'a Triangle<'a>,
}

impl Parts<'_> {
    /// The height of the origin below the plane, that of the direction, and the edges; all times twice the area.
    fn values<N: Number>(&self) -> Option<[N; 5]> {
        let corner = |i: usize| self.triangle.corner::<N>(i);
        let (a, b, c): (V3<N>, V3<N>, V3<N>) = (corner(0)?, corner(1)?, corner(2)?);
        let n = cross(&minus(&b, &a)?, &minus(&c, &a)?)?;
        let depth = dot(&n, &minus(&a, &of(self.line.org))?)?;
        let slope = dot(&n, &of(self.line.dir))?;
        let edge =
            |(i, j): (usize, usize)| Edge { line: self.line, triangle: self.triangle, i, j }.value::<N>();
        Some([depth, slope, edge(EDGES[0])?, edge(EDGES[1])?, edge(EDGES[2])?])
    }
}

impl Triangle<'_> {
    /// Whether its corners lie on one line, or are not finite.
    pub fn is_flat(&self) -> bool {
        let [a, b, c] = self.near;
        let (u, v) = (away(b, a), away(c, a));
        let bound = 16.0 * (UNIT * largest(u) * largest(v) + f64::MIN_POSITIVE);
        if largest(cross_of(u, v)) > bound && self.error == 0.0 {
            return false;
        }
        if self.near.iter().flatten().any(|x| !x.is_finite()) {
            return true;
        }
        (0..3).all(|k| sign(&Normal { triangle: self, k }) == 0)
    }
}

/// A component of the normal.
struct Normal<'a> {
    triangle: &'a Triangle<'a>,
    k: usize,
}

impl Formula for Normal<'_> {
    fn value<N: Number>(&self) -> Option<N> {
        let corner = |i: usize| self.triangle.corner::<N>(i);
        let (a, b, c): (V3<N>, V3<N>, V3<N>) = (corner(0)?, corner(1)?, corner(2)?);
        let n = cross(&minus(&b, &a)?, &minus(&c, &a)?)?;
        n.into_iter().nth(self.k)
    }
}
