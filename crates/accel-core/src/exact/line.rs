// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether a line crosses a triangle, decided without rounding, and without ties.
//! Source: the signs of the three edges as in Plücker's coordinates; ties are broken by moving the line as
//! [EM90] move points: by an infinitesimal along one axis, and by a smaller one along the next.
//! Space: that of the query; directions of any length but zero.
//!
//! A line moved equally for all triangles is a line. It passes through no vertex and no edge and lies in no
//! plane of a triangle. So of triangles that meet in a vertex or an edge it crosses the same number as a
//! parallel line: an even number of any closed surface. That holds wherever the line goes through it, for any
//! triangulation, whether triangles share corners or only positions. The ends of the ray are compared with
//! the intersection of the unmoved line and the plane.
//!
//! The sign of an edge from `p` to `q`, on which side the line passes, is that of `dir . ((p - org) x (q - p))`. Doubles decide
//! it where the value is above the bound of its error; exact numbers do elsewhere.
//! Tests: `tests/surfaces/crossings.rs`.

use super::number::{Formula, Number, V3, cross, dot, minor, minus, of, sign};
use super::path::{Triangle, UNIT};

/// `org + t * dir` for `t` in `[near, far]`.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    pub org: [f64; 3],
    pub dir: [f64; 3],
    pub near: f64,
    pub far: f64,
    /// The axis of the longest component of the direction comes last; the line is moved along the others.
    axes: [usize; 3],
    /// Sum of the components of the direction, without their signs.
    pub(super) size: f64,
}

#[inline(always)]
pub(super) fn largest(v: [f64; 3]) -> f64 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

#[inline(always)]
pub(super) fn away(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(super) fn cross_of(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The sign of a number that may be off by `error`; 0 where that leaves it open. Not finite is open, too.
pub(super) fn certain(value: f64, error: f64) -> i8 {
    i8::from(value > error) - i8::from(value < -error)
}

impl Line {
    /// Finite numbers, a direction that is not zero; ends may be infinite.
    #[inline(always)]
    pub fn new(org: [f64; 3], dir: [f64; 3], near: f64, far: f64) -> Self {
        let [x, y, z] = dir.map(f64::abs);
        let last = if x >= y && x >= z { 0 } else { 2 - usize::from(y >= z) };
        Self { org, dir, near, far, axes: [(last + 1) % 3, (last + 2) % 3, last], size: x + y + z }
    }

    /// Whether the line, moved as described in the head, crosses the triangle between its ends; and if so,
    /// whether it goes along the normal `(b - a) x (c - a)`.
    pub fn crosses(&self, triangle: &Triangle) -> Option<bool> {
        let edges = [(1, 2), (2, 0), (0, 1)];
        let mut signs = edges.map(|(i, j)| self.edge(triangle, i, j));
        if signs.contains(&1) && signs.contains(&-1) {
            return None;
        }
        for (sign, (i, j)) in signs.iter_mut().zip(edges) {
            if *sign == 0 {
                *sign = self.edge_exactly(triangle, i, j);
            }
        }
        let [a, b, c] = signs;
        if a == 0 || a != b || a != c {
            return None;
        }
        // Points before the plane along the line are in front of it.
        let is_before = |t: f64| t == f64::NEG_INFINITY || t.is_finite() && a * self.plane(triangle, t) >= 0;
        let is_behind = |t: f64| t == f64::INFINITY || t.is_finite() && a * self.plane(triangle, t) <= 0;
        (is_before(self.near) && is_behind(self.far)).then_some(a > 0)
    }

    /// How far along the line a triangle is that it [crosses](Self::crosses), between its ends, and the weights of the second
    /// and third corner there; in doubles.
    pub fn intersection(&self, triangle: &Triangle) -> [f64; 3] {
        let [a, b, c] = triangle.near;
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (to_b, to_c) = (away(b, a), away(c, a));
        let normal = cross_of(to_b, to_c);
        let t = dot(normal, away(a, self.org)) / dot(normal, self.dir);
        let from = away([0, 1, 2].map(|k| self.org[k] + t * self.dir[k]), a);
        let weight = |w: [f64; 3]| (dot(w, normal) / dot(normal, normal)).clamp(0.0, 1.0);
        let u = weight(cross_of(from, to_c));
        [t.clamp(self.near, self.far), u, weight(cross_of(to_b, from)).min(1.0 - u)]
    }

    /// The sign of an edge, if doubles decide it.
    fn edge(&self, triangle: &Triangle, i: usize, j: usize) -> i8 {
        let (value, error) = self.edge_value(&triangle.near, triangle.error, i, j);
        certain(value, error)
    }

    /// The value of an edge of a triangle with these corners, which are off by at most `error`, in doubles, and a bound of its error.
    #[inline(always)]
    pub(super) fn edge_value(&self, near: &[[f64; 3]; 3], error: f64, i: usize, j: usize) -> (f64, f64) {
        let (p, q) = (near[i], near[j]);
        let (r, w) = (away(p, self.org), away(q, p));
        let c = cross_of(r, w);
        let value = self.dir[0] * c[0] + self.dir[1] * c[1] + self.dir[2] * c[2];
        let (r, w) = (largest(r), largest(w));
        let (off_r, off_w) = (error + UNIT * r, 2.0 * error + UNIT * w);
        let off = 2.0 * (r * off_w + w * off_r + off_r * off_w) + 8.0 * UNIT * r * w;
        (value, self.size * off * 1.01 + f64::MIN_POSITIVE)
    }

    /// The same by exact numbers, never 0 except for an edge along the line.
    #[cold]
    fn edge_exactly(&self, triangle: &Triangle, i: usize, j: usize) -> i8 {
        let moved = |along: usize| sign(&Tilt { line: self, triangle, i, j, along });
        match sign(&Edge { line: self, triangle, i, j }) {
            0 => match moved(0) {
                0 => moved(1),
                sign => sign,
            },
            sign => sign,
        }
    }

    /// The side of the triangle's plane on which the line is at `t`: 1 where the normal points away from there.
    fn plane(&self, triangle: &Triangle, t: f64) -> i8 {
        let [a, b, c] = triangle.near;
        let at = [0, 1, 2].map(|k| self.org[k] + t * self.dir[k]);
        let off_at = UNIT * (largest(self.org) + 2.0 * largest(self.dir) * t.abs());
        let (value, error) = height(triangle, [a, b, c], at, off_at);
        match certain(value, error) {
            0 => sign(&Height { triangle, org: self.org, dir: self.dir, t }),
            sign => sign,
        }
    }

    /// Whether the origin lies on the triangle, its edges and corners included.
    pub fn starts_on(&self, triangle: &Triangle) -> bool {
        let ([a, b, c], org) = (triangle.near, self.org);
        let misses_box = |k: usize| {
            let slack = triangle.error + 4.0 * UNIT * (a[k].abs() + org[k].abs());
            org[k] < a[k].min(b[k]).min(c[k]) - slack || org[k] > a[k].max(b[k]).max(c[k]) + slack
        };
        if (0..3).any(misses_box) {
            return false;
        }
        let (value, error) = height(triangle, [a, b, c], org, 0.0);
        let is_off = || sign(&Height { triangle, org, dir: self.dir, t: 0.0 }) != 0;
        if certain(value, error) != 0 || is_off() {
            return false;
        }
        // In the plane: seen along an axis that the normal is not across.
        let n = cross_of(away(b, a), away(c, a)).map(f64::abs);
        let mut axes = [0, 1, 2];
        axes.sort_by(|&i, &j| n[j].total_cmp(&n[i]));
        let orientations =
            axes.into_iter().map(|k| (k, sign(&Orientation { triangle, k, i: 0, j: 1, to: None })));
        let Some((k, facing)) = orientations.into_iter().find(|&(_, facing)| facing != 0) else {
            return false;
        };
        let inside =
            |i: usize, j: usize| facing * sign(&Orientation { triangle, k, i, j, to: Some(org) }) >= 0;
        inside(0, 1) && inside(1, 2) && inside(2, 0)
    }
}

/// How far a point is below a triangle's plane, times twice its area, and a bound of the error.
pub(super) fn height(triangle: &Triangle, [a, b, c]: [[f64; 3]; 3], at: [f64; 3], off_at: f64) -> (f64, f64) {
    let (u, v, r) = (away(b, a), away(c, a), away(a, at));
    let n = cross_of(u, v);
    let value = n[0] * r[0] + n[1] * r[1] + n[2] * r[2];
    let (u, v, r) = (largest(u), largest(v), largest(r));
    let (off_u, off_v) = (2.0 * triangle.error + UNIT * u, 2.0 * triangle.error + UNIT * v);
    let off_r = triangle.error + off_at + UNIT * r;
    let off_n = 2.0 * (u * off_v + v * off_u + off_u * off_v) + 4.0 * UNIT * u * v;
    let off = 3.0 * (off_n * (r + off_r) + 2.0 * u * v * off_r) + 24.0 * UNIT * u * v * r;
    (value, off * 1.01 + f64::MIN_POSITIVE)
}

/// See the head of the file.
pub(super) struct Edge<'a> {
    pub(super) line: &'a Line,
    pub(super) triangle: &'a Triangle<'a>,
    pub(super) i: usize,
    pub(super) j: usize,
}

impl Formula for Edge<'_> {
    fn value<N: Number>(&self) -> Option<N> {
        let (p, q): (V3<N>, V3<N>) = (self.triangle.corner(self.i)?, self.triangle.corner(self.j)?);
        let (r, w) = (minus(&p, &of(self.line.org))?, minus(&q, &p)?);
        dot(&of(self.line.dir), &cross(&r, &w)?)
    }
}

/// How the value of an edge changes as the line is moved along an axis across it.
struct Tilt<'a> {
    line: &'a Line,
    triangle: &'a Triangle<'a>,
    i: usize,
    j: usize,
    along: usize,
}

impl Formula for Tilt<'_> {
    fn value<N: Number>(&self) -> Option<N> {
        let (p, q): (V3<N>, V3<N>) = (self.triangle.corner(self.i)?, self.triangle.corner(self.j)?);
        let w = minus(&q, &p)?;
        let d: V3<N> = of(self.line.dir);
        let [x, y, z] = self.line.axes;
        match self.along {
            0 => minor(&d[y], &d[z], &w[y], &w[z]),
            _ => minor(&d[z], &d[x], &w[z], &w[x]),
        }
    }
}

/// How far the point of a line at `t` is below a triangle's plane, times twice its area.
struct Height<'a> {
    triangle: &'a Triangle<'a>,
    org: [f64; 3],
    dir: [f64; 3],
    t: f64,
}

impl Formula for Height<'_> {
    fn value<N: Number>(&self) -> Option<N> {
        let corner = |i: usize| self.triangle.corner::<N>(i);
        let (a, b, c) = (corner(0)?, corner(1)?, corner(2)?);
        let t = N::new(self.t);
        let at = |k: usize| N::new(self.org[k]).plus(&t.times(&N::new(self.dir[k]))?);
        let n = cross(&minus(&b, &a)?, &minus(&c, &a)?)?;
        dot(&n, &minus(&a, &[at(0)?, at(1)?, at(2)?])?)
    }
}

/// The orientation of edge `i`-`j` and a point, or the third corner, seen along axis `k`.
struct Orientation<'a> {
    triangle: &'a Triangle<'a>,
    k: usize,
    i: usize,
    j: usize,
    to: Option<[f64; 3]>,
}

impl Formula for Orientation<'_> {
    fn value<N: Number>(&self) -> Option<N> {
        let (p, q): (V3<N>, V3<N>) = (self.triangle.corner(self.i)?, self.triangle.corner(self.j)?);
        let to = match self.to {
            Some(point) => of(point),
            None => self.triangle.corner(3 - self.i - self.j)?,
        };
        let (x, y) = ((self.k + 1) % 3, (self.k + 2) % 3);
        let (u, v) = (minus(&q, &p)?, minus(&to, &p)?);
        minor(&u[x], &u[y], &v[x], &v[y])
    }
}
