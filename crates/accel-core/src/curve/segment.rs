// SPDX-License-Identifier: GPL-3.0-or-later
//! One curve made ready for tests: the form of its test, bounds of its parts, and its normals.
//! Space: object. Invariant: a hit lies within the radius of the curve's point at its parameter, so that bounds of a part
//! hold all of its hits. Tests: `tests/curves.rs` of `gnurt-accel`.

use super::cubic::Cubic;
use super::ray::{Offer, RayFrame};
use super::ribbon::across;
use super::{Vector, along, cone, cross, dot, minus, pieces, place, ribbon, scaled, tube};
use crate::aabb::Aabb;

/// A curve in one of the forms that have tests of their own.
#[derive(Clone, Copy, Debug)]
pub enum Segment {
    /// A straight ribbon that faces the ray.
    FlatLine([[f64; 4]; 2]),
    /// A cone with spheres at its ends, and the ends of cones that it is joined to.
    Cone {
        ends: [[f64; 4]; 2],
        before: Option<[f64; 4]>,
        after: Option<[f64; 4]>,
        is_seen_from_outside: bool,
    },
    /// A ribbon that faces the ray.
    Flat(Cubic),
    /// The same in so many straight pieces.
    Pieces(Cubic, u8),
    /// A tube, and whether it is hit from outside only.
    Round(Cubic, bool),
    /// A ribbon across normals, which are Bezier's control points.
    Oriented(Cubic, [Vector; 4]),
}

/// One of several equal parts of a curve: all of its hits are in the box, and within the radius of the chord.
#[derive(Clone, Copy, Debug)]
pub struct CurvePiece {
    pub bounds: Aabb,
    pub ends: [[f32; 3]; 2],
    pub radius: f32,
    /// Its place among how many.
    pub index: u8,
    pub count: u8,
}

impl CurvePiece {
    /// Within the hull of points, and within `off` of the chord.
    #[inline(always)]
    fn around(hull: &[[f64; 4]], ends: [[f64; 4]; 2], off: f64, [index, count]: [u32; 2]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut radius = 0.0;
        for point in hull {
            for k in 0..3 {
                (low[k], high[k]) = (least(low[k], point[k]), most(high[k], point[k]));
            }
            radius = most(radius, point[3]);
        }
        let bounds = Aabb {
            min: low.map(|x| ((x - radius) as f32).next_down()),
            max: high.map(|x| ((x + radius) as f32).next_up()),
        };
        // The ends move where they become floats.
        let rounding =
            low.iter().chain(&high).fold(0.0, |all, x| most(all, x.abs())) * f64::from(f32::EPSILON);
        let radius = ((radius + off + rounding) as f32).next_up();
        let ends = ends.map(|end| place(end).map(|x| x as f32));
        Self { bounds, ends, radius, index: index as u8, count: count as u8 }
    }
}

fn least(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

fn most(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

impl Segment {
    /// Between this one and another of the same form, by the weights of the two: its vertices are between theirs.
    #[must_use]
    pub fn mixed(&self, to: &Self, weights: [f64; 2]) -> Self {
        let [a, b] = weights;
        let point = |p: &[f64; 4], q: &[f64; 4]| [0, 1, 2, 3].map(|k| a * p[k] + b * q[k]);
        let vector = |p: &Vector, q: &Vector| [0, 1, 2].map(|k| a * p[k] + b * q[k]);
        let joint =
            |p: &Option<[f64; 4]>, q: &Option<[f64; 4]>| p.as_ref().zip(q.as_ref()).map(|(p, q)| point(p, q));
        match (self, to) {
            (Self::FlatLine(p), Self::FlatLine(q)) => Self::FlatLine([0, 1].map(|i| point(&p[i], &q[i]))),
            (
                Self::Cone { ends: p, before, after, is_seen_from_outside },
                Self::Cone { ends: q, before: before_to, after: after_to, .. },
            ) => Self::Cone {
                ends: [0, 1].map(|i| point(&p[i], &q[i])),
                before: joint(before, before_to),
                after: joint(after, after_to),
                is_seen_from_outside: *is_seen_from_outside,
            },
            (Self::Flat(p), Self::Flat(q)) => Self::Flat(p.mixed(q, weights)),
            (Self::Pieces(p, pieces), Self::Pieces(q, _)) => Self::Pieces(p.mixed(q, weights), *pieces),
            (Self::Round(p, from_outside), Self::Round(q, _)) => {
                Self::Round(p.mixed(q, weights), *from_outside)
            }
            (Self::Oriented(p, m), Self::Oriented(q, n)) => {
                Self::Oriented(p.mixed(q, weights), [0, 1, 2, 3].map(|i| vector(&m[i], &n[i])))
            }
            _ => *self,
        }
    }

    /// The cubic, where it is one.
    fn cubic(&self) -> Option<&Cubic> {
        match self {
            Self::FlatLine(_) | Self::Cone { .. } => None,
            Self::Flat(cubic) | Self::Pieces(cubic, _) | Self::Round(cubic, _) | Self::Oriented(cubic, _) => {
                Some(cubic)
            }
        }
    }

    /// The point of the curve at a parameter, and its radius.
    #[inline]
    pub(super) fn at(&self, t: f64) -> [f64; 4] {
        match self {
            Self::FlatLine([a, b]) | Self::Cone { ends: [a, b], .. } => {
                [0, 1, 2, 3].map(|k| a[k] + t * (b[k] - a[k]))
            }
            Self::Flat(cubic) | Self::Pieces(cubic, _) | Self::Round(cubic, _) | Self::Oriented(cubic, _) => {
                cubic.at(t)
            }
        }
    }

    /// The number of equal parts, a power of two up to 8, that have boxes of their own: so many that one is nearly
    /// straight, and no part of a long curve spans a large box.
    #[must_use]
    pub fn parts(&self) -> u32 {
        let Some(cubic) = self.cubic() else { return 1 };
        let chord = minus(place(cubic.at(1.0)), place(cubic.at(0.0)));
        let length = dot(chord, chord).sqrt();
        let bend = cubic.bend_length(0.0).max(cubic.bend_length(1.0));
        // The deviation from the chord falls with the square of the number.
        let widest = (0..=4).map(|i| cubic.at(f64::from(i) / 4.0)[3]).fold(0.0, f64::max);
        let allowed = (0.014 * length).max(0.5 * widest);
        let most = match self {
            // No straight piece is in two parts.
            Self::Pieces(_, pieces) => 8.min(1 << pieces.trailing_zeros()),
            _ => 8,
        };
        let mut parts = 1;
        while parts < most && bend / f64::from(8 * parts * parts) > allowed {
            parts *= 2;
        }
        parts
    }

    /// What is known of equal parts between two parameters before they are met by rays.
    #[inline]
    pub fn pieces(&self, [from, to]: [f64; 2], count: u32, mut each: impl FnMut(CurvePiece)) {
        let at = |index: u32| from + (to - from) * f64::from(index) / f64::from(count);
        let Some(cubic) = self.cubic() else {
            return (0..count).for_each(|index| {
                let ends = [self.at(at(index)), self.at(at(index + 1))];
                each(CurvePiece::around(&ends, ends, 0.0, [index, count]));
            });
        };
        let h = (to - from) / f64::from(count);
        let mut start = (cubic.at(from), cubic.slope(from), cubic.bend_length(from));
        for index in 0..count {
            let to = at(index + 1);
            let end = (cubic.at(to), cubic.slope(to), cubic.bend_length(to));
            let third = h / 3.0;
            let inner = |p: &[f64; 4], s: &[f64; 4], step: f64| [0, 1, 2, 3].map(|k| p[k] + step * s[k]);
            let hull = [start.0, inner(&start.0, &start.1, third), inner(&end.0, &end.1, -third), end.0];
            let off = start.2.max(end.2) * h * h / 8.0;
            each(CurvePiece::around(&hull, [start.0, end.0], off, [index, count]));
            start = end;
        }
    }

    /// A box around all hits.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        self.pieces([0.0, 1.0], 1, |piece| bounds = piece.bounds);
        bounds
    }

    /// Calls `hit` with the hits of a ray's line, in any order, on the part of the curve between two parameters. It answers
    /// whether hits behind this one on the same curve count, too; some may come even so.
    #[inline]
    pub fn meet(&self, ray: &RayFrame, part: [f64; 2], hit: Offer) {
        match self {
            Self::FlatLine(ends) => ribbon::meet_line(ends, ray, hit),
            Self::Cone { ends, before, after, is_seen_from_outside } => {
                cone::meet(ends, [before, after], *is_seen_from_outside, ray, hit);
            }
            Self::Flat(cubic) => ribbon::meet_flat(cubic, ray, part, hit),
            Self::Oriented(cubic, normals) => ribbon::meet_oriented(cubic, normals, ray, part, hit),
            Self::Pieces(cubic, pieces) => pieces::meet(cubic, *pieces, ray, part, hit),
            Self::Round(cubic, false) => tube::meet(cubic, ray, part, hit),
            Self::Round(cubic, true) => tube::meet(cubic, ray, part, &mut |found| {
                let point = along(ray.org, found.t, ray.dir);
                let normal = self.normal(found.u, found.v, Some(point));
                normal.is_none_or(|normal| dot(normal, ray.dir) >= 0.0) || hit(found)
            }),
        }
    }

    /// The normal of a hit at `point`, of any length: outwards, or on the side of the normals that the curve came with. `None`
    /// for ribbons that face each ray.
    #[must_use]
    pub fn normal(&self, u: f64, v: f64, point: Option<Vector>) -> Option<Vector> {
        match self {
            Self::FlatLine(_) | Self::Flat(_) | Self::Pieces(..) => None,
            Self::Cone { .. } => Some(minus(point?, place(self.at(u)))),
            Self::Round(cubic, _) => {
                let out = minus(point?, place(cubic.at(u)));
                let (slope, bend) = (cubic.slope(u), place(cubic.bend(u)));
                let (speed, radius) = (dot(place(slope), place(slope)).sqrt(), cubic.at(u)[3]);
                // Across the derivative by u: the circle moves with the curve, turns with it and grows.
                let grows = (speed - dot(out, bend) / speed) / radius;
                Some(along(scaled(out, grows), -slope[3] / speed, place(slope)))
            }
            Self::Oriented(cubic, normals) => {
                let edge = |t: f64| {
                    let point = cubic.at(t);
                    let side = across(cubic, normals, t);
                    along(place(point), (2.0 * v - 1.0) * point[3] / dot(side, side).sqrt(), side)
                };
                let (from, to) = ((u - 1e-4).max(0.0), (u + 1e-4).min(1.0));
                Some(cross(minus(edge(to), edge(from)), across(cubic, normals, u)))
            }
        }
    }
}
