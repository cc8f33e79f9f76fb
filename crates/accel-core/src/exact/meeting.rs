// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a line meets a triangle, its edges and corners included: a decision without rounding, and a
//! parameter that is off by less than 1e-13 of itself.
//! Source: the edges of [`line`](super::line), here without ties broken; doubles first, then numbers of twice their precision, then
//! exact ones. Space: that of the query. A line in the plane of a triangle does not meet it.
//! Tests: `tests/doubles.rs` of `gnurt-accel`.

use std::cmp::Ordering;

use super::dyadic::Dyadic;
use super::line::{Edge, Line, away, certain, cross_of, largest};
use super::number::{Formula, Number, V3, cross, dot, minus, of, sign};
use super::path::{InstancePath, Triangle, UNIT};
use super::plane::{LOST_SLOPE, Meeting, PLAIN};
use super::twice::Twice;

/// The relative error that the parameter may have in doubles.
const FINE: f64 = 9e-14;

/// The error that a weight may have in doubles, of 1.
pub(super) const FINE_WEIGHT: f64 = 1e-10;

/// Parameters that differ by less of themselves are compared by more precise numbers.
const ALIKE: f64 = 4e-13;

/// Numbers of twice the precision are good for sums that lose this much to cancellation.
const LOST: f64 = 1e-14;

pub(super) const EDGES: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// Where a line meets the plane of a triangle, in doubles.
#[derive(Clone, Copy)]
pub struct Along {
    pub t: f64,
    /// A bound of the error of `t`, if the line passes through the triangle; infinite where doubles tell nothing.
    pub off: f64,
}

/// The corners of a triangle in doubles, as decisions by doubles need them.
#[derive(Clone, Copy)]
pub struct Corners<'a> {
    /// In the space of the query.
    near: &'a [[f64; 3]; 3],
    /// How far off any coordinate may be.
    error: f64,
    /// In the space of the mesh, and the way from there.
    plain: &'a [[f64; 3]; 3],
    path: Option<&'a InstancePath<'a>>,
}

impl<'a> Corners<'a> {
    /// Of a triangle in the space of the query.
    #[inline(always)]
    pub fn plain(corners: &'a [[f64; 3]; 3]) -> Self {
        Self { near: corners, error: 0.0, plain: corners, path: None }
    }

    /// Of any triangle.
    #[inline]
    pub fn of(triangle: &'a Triangle<'a>) -> Self {
        Self { near: &triangle.near, error: triangle.error, plain: &triangle.corners, path: triangle.path }
    }

    fn triangle(&self) -> Triangle<'a> {
        Triangle { corners: *self.plain, path: self.path, near: *self.near, error: self.error }
    }
}

impl Line {
    /// The parameter, and the weights of the second and the third corner, where the line meets the triangle between its ends.
    pub fn meets(&self, triangle: &Triangle) -> Option<[f64; 3]> {
        let t = self.meets_before(&Corners::of(triangle), self.far, false)?;
        let [u, v] = self.weights(&Corners::of(triangle));
        Some([t, u, v])
    }

    /// The parameter where the line meets the triangle between its ends; `None` also where that is certainly beyond `far`.
    /// `is_certain`: the line is known to pass inside.
    #[inline(always)]
    pub fn meets_before(&self, corners: &Corners, far: f64, is_certain: bool) -> Option<f64> {
        if !is_certain && !self.touches(corners) {
            return None;
        }
        self.meets_along(corners, &self.along(corners), far)
    }

    /// The same of a triangle that the line touches, whose plane it meets there.
    #[inline(always)]
    pub fn meets_along(&self, corners: &Corners, along: &Along, far: f64) -> Option<f64> {
        if along.is_beyond(self.near, far) {
            return None;
        }
        let t = if along.off <= FINE * along.t.abs() { along.t } else { self.finely(corners)?[0] };
        (t >= self.near && t <= self.far).then_some(t)
    }

    /// Whether the line meets the triangle between its ends. `is_certain`: the line is known to pass inside.
    #[inline(always)]
    pub fn is_blocked(&self, corners: &Corners, is_certain: bool) -> bool {
        if !is_certain && !self.touches(corners) {
            return false;
        }
        self.is_blocked_along(corners, &self.along(corners))
    }

    /// The same by a triangle that the line touches, whose plane it meets there.
    #[inline(always)]
    pub fn is_blocked_along(&self, corners: &Corners, along: &Along) -> bool {
        if along.is_beyond(self.near, self.far) {
            return false;
        }
        let is_between = along.t - along.off >= self.near && along.t + along.off <= self.far;
        is_between || self.finely(corners).is_some_and(|[t, ..]| t >= self.near && t <= self.far)
    }

    /// The weights of the second and the third corner where the line meets a triangle.
    pub fn weights(&self, corners: &Corners) -> [f64; 2] {
        let [a, b, c] = self.edge_values(corners);
        let side = if a.0 + b.0 + c.0 < 0.0 { -1.0 } else { 1.0 };
        // Written out, here and below: `map` would be calls.
        let weights = [(side * a.0).max(0.0), (side * b.0).max(0.0), (side * c.0).max(0.0)];
        let whole = weights[0] + weights[1] + weights[2];
        if a.1 + b.1 + c.1 <= FINE_WEIGHT * whole {
            return [weights[1] / whole, weights[2] / whole];
        }
        self.finely(corners).map_or([0.0; 2], |[_, u, v]| [u, v])
    }

    /// The order of two triangles along the line, which meets them at these parameters; equal where it meets both at one place.
    #[inline(always)]
    pub fn order(&self, (a, of_a): (f64, &Corners), (b, of_b): (f64, &Corners)) -> Ordering {
        if (a - b).abs() > ALIKE * a.abs().max(b.abs()) {
            return a.total_cmp(&b);
        }
        let finely = |t: f64, corners| self.finely(corners).map_or(t, |[t, ..]| t);
        finely(a, of_a).total_cmp(&finely(b, of_b))
    }

    #[inline(always)]
    fn edge_values(&self, corners: &Corners) -> [(f64, f64); 3] {
        let edge = |(i, j): (usize, usize)| self.edge_value(corners.near, corners.error, i, j);
        [edge(EDGES[0]), edge(EDGES[1]), edge(EDGES[2])]
    }

    /// Whether the line passes the edges on one side or through them.
    #[inline(always)]
    pub fn touches(&self, corners: &Corners) -> bool {
        let values @ [a, b, c] = self.edge_values(corners);
        let some_left = (a.0 > a.1) | (b.0 > b.1) | (c.0 > c.1);
        let some_right = (a.0 < -a.1) | (b.0 < -b.1) | (c.0 < -c.1);
        let is_inside = (a.0.abs() > a.1) & (b.0.abs() > b.1) & (c.0.abs() > c.1);
        !(some_left & some_right) && (is_inside || self.touches_closely(corners, &values))
    }

    /// The same where doubles leave a sign open.
    #[cold]
    fn touches_closely(&self, corners: &Corners, values: &[(f64, f64); 3]) -> bool {
        let triangle = &corners.triangle();
        let mut signs = values.map(|(value, error)| certain(value, error));
        for (side, (i, j)) in signs.iter_mut().zip(EDGES) {
            if *side == 0 {
                *side = sign(&Edge { line: self, triangle, i, j });
            }
        }
        signs.contains(&1) != signs.contains(&-1)
    }

    /// Where the line meets the triangle's plane.
    #[inline(always)]
    fn along(&self, corners: &Corners) -> Along {
        let (near, error) = (corners.near, corners.error);
        let met = Meeting::new(*near, self.org, self.dir, |x| x);
        let off = if error == 0.0 {
            met.off(|x| x)
        } else {
            met.off_by(of_normal(near, error), error * met.normal + met.of_depth, |x| x)
        };
        let is_plain =
            PLAIN.contains(&met.size) && PLAIN.contains(&met.area) && met.of_slope <= LOST_SLOPE * met.size;
        Along { t: met.t, off: if is_plain && off.is_finite() { off } else { f64::INFINITY } }
    }

    /// By more precise numbers.
    #[cold]
    fn finely(&self, corners: &Corners) -> Option<[f64; 3]> {
        let triangle = &corners.triangle();
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

impl Along {
    /// Whether it is certainly not in an interval.
    #[inline(always)]
    fn is_beyond(&self, near: f64, far: f64) -> bool {
        self.t + self.off < near || self.t - self.off > far
    }
}

/// The error of the normal of a triangle whose corners may be off by `error`, times a vector of the triangle.
#[inline(always)]
fn of_normal(&[a, b, c]: &[[f64; 3]; 3], error: f64) -> f64 {
    let (u, v, off) = (largest(away(b, a)), largest(away(c, a)), 2.0 * error);
    let (off_u, off_v) = (off + UNIT * u, off + UNIT * v);
    let off_n = 2.0 * (u * off_v + v * off_u + off_u * off_v) + 4.0 * UNIT * u * v;
    3.0 * off_n * (u.max(v) + off)
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

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    /// By exact numbers alone.
    fn exactly(line: &Line, triangle: &Triangle) -> Option<f64> {
        let [depth, slope, ..] = Parts { line, triangle }.values::<Dyadic>()?;
        (slope.sign() != 0).then(|| depth.over(&slope))
    }

    #[test]
    fn bounds_hold() {
        let mut random = Random::new(21);
        let (mut met, mut fine) = (0, 0);
        for i in 0..40_000 {
            let mut number = || 2.0 * f64::from(random.unit()) - 1.0;
            let mut point = || [number() + 1e-9 * number(), number() + 1e-9 * number(), number()];
            let offset = [0.0, 1e4, 1e6, 1e8][i % 4];
            let thin = [1.0, 1e-3, 1e-7][i / 4 % 3];
            let near = [1.0, 1e-2, 1e-6][i / 12 % 3];
            let (a, to_b, side, at) = (point(), point(), point(), point());
            // A sliver of any thinness, and a line that comes from far or near to a point of it.
            let to_c = [0, 1, 2].map(|k| 0.7 * to_b[k] + thin * side[k]);
            let corners = [[0.0; 3], to_b, to_c].map(|to| [0, 1, 2].map(|k| offset + a[k] + to[k]));
            let middle = [0, 1, 2].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
            let dir = at;
            let org = [0, 1, 2].map(|k| middle[k] - near * 8.0 * dir[k]);
            let line = Line::new(org, dir, 0.0, f64::INFINITY);
            // Its corners as they are, or carried to there.
            let turn = [[0.0, 1.25, 0.0], [-0.75, 0.0, 1.0], [0.1, 0.0, 1.0], [offset, 1.0, -offset]];
            let path = InstancePath { columns: &turn, outer: None };
            let carried = Triangle::of_doubles(corners, Some(&path));
            let to = [0, 1, 2].map(|k| (carried.near[0][k] + carried.near[1][k] + carried.near[2][k]) / 3.0);
            let there = Line::new([0, 1, 2].map(|k| to[k] - near * 8.0 * dir[k]), dir, 0.0, f64::INFINITY);
            for (line, triangle) in [(line, Triangle::of_doubles(corners, None)), (there, carried)] {
                let corners = Corners::of(&triangle);
                if !line.touches(&corners) {
                    continue;
                }
                let (along, exact) = (line.along(&corners), exactly(&line, &triangle).expect("it is met"));
                met += 1;
                fine += u32::from(along.off <= FINE * along.t.abs());
                let off = (along.t - exact).abs();
                // Of the bound, and of rounding the exact one.
                let bound = along.off + UNIT * exact.abs();
                assert!(off <= bound, "{i}: {} is not {exact} within {}", along.t, along.off);
                let found = line.meets(&triangle).map(|[t, ..]| t);
                let is_right = found.is_some_and(|t| (t - exact).abs() <= 1e-13 * exact.abs());
                assert!(is_right || exact < 0.0, "{i}: {found:?} is not {exact}");
            }
        }
        assert!(met > 20_000, "lines meet triangles: {met}");
        assert!(fine > met / 8, "doubles are often enough: {fine} of {met}");
    }
}
