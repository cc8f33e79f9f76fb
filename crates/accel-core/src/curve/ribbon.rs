// SPDX-License-Identifier: GPL-3.0-or-later
//! A ray and a ribbon. Seen along the ray a ribbon is met where a function of one parameter is zero. One that faces
//! the ray is met where the curve is nearest to the ray, another where the ray is on the line across the curve.
//! Source: the reduction to two dimensions is that of [WBW*14] (Embree's hair); roots are bracketed at fixed parameters, which
//! neighbouring parts share, and refined by a safeguarded secant [PTVF07], section 9.2.
//! Space: by the axes of the ray. Invariant: a root between two fixed parameters is found once, in one part.
//! Tests: `tests/curves.rs` of `gnurt-accel`.

use super::cubic::Cubic;
use super::ray::{CurveHit, Offer, RayFrame};
use super::{Vector, cross, dot, minus, place};

/// Most brackets of one curve.
const MOST_BRACKETS: f64 = 32.0;

/// A straight ribbon with round ends.
pub(super) fn meet_line(ends: &[[f64; 4]; 2], ray: &RayFrame, hit: Offer) {
    let [a, b] = ends.map(|end| ray.by_axes(minus(place(end), ray.org)));
    let step = [b[0] - a[0], b[1] - a[1]];
    let square = step[0] * step[0] + step[1] * step[1];
    let u = if square > 0.0 { (-(a[0] * step[0] + a[1] * step[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    let at = |k: usize| a[k] + u * (b[k] - a[k]);
    let radius = ends[0][3] + u * (ends[1][3] - ends[0][3]);
    let (x, y) = (at(0), at(1));
    // Not so of NaN.
    if x * x + y * y <= radius * radius && radius > 0.0 {
        let v = if square > 0.0 { (x * step[1] - y * step[0]) / (square.sqrt() * radius) } else { 0.0 };
        hit(CurveHit { t: at(2) / ray.length, u, v });
    }
}

/// A ribbon that faces the ray and ends across the curve.
#[inline(always)]
pub(super) fn meet_flat(cubic: &Cubic, ray: &RayFrame, part: [f64; 2], hit: Offer) {
    let seen = cubic.mapped(|v| ray.by_axes(v), ray.org);
    let brackets = brackets(&seen, part, 1.0);
    let step = (part[1] - part[0]) / brackets;
    let mut a = Near::at(&seen, part[0]);
    for i in 1..=brackets as u32 {
        let b = Near::at(&seen, part[0] + step * f64::from(i));
        if (a.off >= 0.0) != (b.off >= 0.0)
            && let Some(Near { u, point: [x, y, z, radius], slope, .. }) = nearest(&seen, a, b)
            && x * x + y * y <= radius * radius
            && radius > 0.0
        {
            let speed = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
            let v = if speed > 0.0 { (x * slope[1] - y * slope[0]) / (speed * radius) } else { 0.0 };
            hit(CurveHit { t: z / ray.length, u, v });
        }
        a = b;
    }
}

/// A parameter, what is seen there, and half of the derivative of the squared distance from the ray.
#[derive(Clone, Copy)]
struct Near {
    u: f64,
    point: [f64; 4],
    slope: [f64; 4],
    off: f64,
}

impl Near {
    #[inline(always)]
    fn at(seen: &Cubic, u: f64) -> Self {
        let (point, slope) = (seen.at(u), seen.slope(u));
        Self { u, point, slope, off: point[0] * slope[0] + point[1] * slope[1] }
    }
}

/// Where the curve is nearest to the ray between two places at which it comes nearer and goes away; `None` as soon as the
/// rest of the way cannot lead into the radius. As [`refined`], but only as fine as floats are.
#[inline(always)]
fn nearest(seen: &Cubic, a: Near, b: Near) -> Option<Near> {
    let length = |[x, y, ..]: [f64; 4]| (x * x + y * y).sqrt();
    // The bend is linear, so that it is greatest at an end.
    let bend = length(seen.bend(a.u)).max(length(seen.bend(b.u)));
    let fastest = length(a.slope).max(length(b.slope)) + 0.5 * bend * (b.u - a.u).abs();
    let widest = seen.greatest_radius();
    let (mut a, mut at_a, mut b) = (a.u, a.off, b);
    for _ in 0..60 {
        let c = b.u - b.off * (b.u - a) / (b.off - at_a);
        // The secant of two nearly equal values may lead anywhere.
        let c = if c > a.min(b.u) && c < a.max(b.u) { c } else { 0.5 * (a + b.u) };
        let c = Near::at(seen, c);
        let [x, y, ..] = c.point;
        // The root is on that side.
        let rest = if (c.off >= 0.0) != (b.off >= 0.0) { c.u - b.u } else { c.u - a };
        let reach = widest + fastest * rest.abs();
        if x * x + y * y > reach * reach {
            return None;
        }
        let moved = (c.u - b.u).abs();
        if c.off == 0.0 || moved < 1e-7 || (b.u - a).abs() < 1e-9 {
            return Some(c);
        }
        if (c.off >= 0.0) != (b.off >= 0.0) {
            (a, at_a) = (b.u, b.off);
        } else {
            // An end that stays counts for less: by the ratio of Anderson and Bjorck.
            let ratio = 1.0 - c.off / b.off;
            at_a *= if ratio > 0.0 { ratio } else { 0.5 };
        }
        b = c;
    }
    Some(b)
}

/// A ribbon across normals.
pub(super) fn meet_oriented(
    cubic: &Cubic,
    normals: &[Vector; 4],
    ray: &RayFrame,
    part: [f64; 2],
    hit: Offer,
) {
    let seen = cubic.mapped(|v| ray.by_axes(v), ray.org);
    let normals = normals.map(|normal| ray.by_axes(normal));
    let off = |t: f64| {
        let (point, side) = (seen.at(t), across(&seen, &normals, t));
        point[0] * side[1] - point[1] * side[0]
    };
    // Normals turn, too.
    for_roots(&seen, part, 8.0, off, |u| {
        let ([x, y, z, radius], side) = (seen.at(u), across(&seen, &normals, u));
        let (length, seen_square) = (dot(side, side).sqrt(), side[0] * side[0] + side[1] * side[1]);
        // Not so where it is seen from its edge.
        if seen_square > 1e-20 * length * length {
            let by_side = -(x * side[0] + y * side[1]) / seen_square;
            let v = by_side * length / radius;
            if v.abs() <= 1.0 {
                hit(CurveHit { t: (z + by_side * side[2]) / ray.length, u, v: 0.5 + 0.5 * v });
            }
        }
    });
}

/// How many brackets a part of a curve needs, as it is seen along the ray; a whole curve has `fewest` or more.
#[inline(always)]
fn brackets(seen: &Cubic, [from, to]: [f64; 2], fewest: f64) -> f64 {
    let square = |[x, y, ..]: [f64; 4]| x * x + y * y;
    // More brackets the more the curve turns where it is seen: all of them if it is seen along itself.
    let slope = |u: f64| square(seen.slope(u));
    let slopes = [slope(from), slope(0.5 * (from + to)), slope(to)];
    let least = slopes[0].min(slopes[1]).min(slopes[2]);
    let bend = square(seen.bend(from)).max(square(seen.bend(to))) * (to - from) * (to - from);
    let brackets = MOST_BRACKETS * (to - from);
    let mut fewer = (fewest * (to - from)).max(1.0);
    while fewer < brackets && bend > 0.25 * fewer * fewer * least {
        fewer *= 2.0;
    }
    brackets.min(fewer)
}

/// Calls `root` for each zero of `f` within a part of a curve.
#[inline(always)]
fn for_roots(
    seen: &Cubic,
    [from, to]: [f64; 2],
    fewest: f64,
    f: impl Fn(f64) -> f64,
    mut root: impl FnMut(f64),
) {
    let brackets = brackets(seen, [from, to], fewest);
    let step = (to - from) / brackets;
    let (mut a, mut at_a) = (from, f(from));
    for i in 1..=brackets as u32 {
        let b = from + step * f64::from(i);
        let at_b = f(b);
        if (at_a >= 0.0) != (at_b >= 0.0) {
            root(refined([a, b], [at_a, at_b], &f));
        }
        (a, at_a) = (b, at_b);
    }
}

/// A zero between two parameters at which `f` has different signs.
#[inline(always)]
fn refined([mut a, mut b]: [f64; 2], [mut at_a, mut at_b]: [f64; 2], f: &impl Fn(f64) -> f64) -> f64 {
    for _ in 0..60 {
        let c = b - at_b * (b - a) / (at_b - at_a);
        // The secant of two nearly equal values may lead anywhere.
        let c = if c > a.min(b) && c < a.max(b) { c } else { 0.5 * (a + b) };
        let at_c = f(c);
        if at_c == 0.0 || (b - a).abs() < 1e-13 {
            return c;
        }
        if (at_c >= 0.0) != (at_b >= 0.0) {
            (a, at_a) = (b, at_b);
        } else {
            // An end that stays counts for less: by the ratio of Anderson and Bjorck.
            let ratio = 1.0 - at_c / at_b;
            at_a *= if ratio > 0.0 { ratio } else { 0.5 };
        }
        let moved = (c - b).abs();
        (b, at_b) = (c, at_c);
        if moved < 1e-15 {
            return c;
        }
    }
    b
}

/// The direction across an oriented ribbon, of any length.
#[inline(always)]
pub(super) fn across(cubic: &Cubic, normals: &[Vector; 4], t: f64) -> Vector {
    let s = 1.0 - t;
    let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    let normal = [0, 1, 2].map(|k: usize| {
        weights[0] * normals[0][k]
            + weights[1] * normals[1][k]
            + weights[2] * normals[2][k]
            + weights[3] * normals[3][k]
    });
    cross(normal, place(cubic.slope(t)))
}
