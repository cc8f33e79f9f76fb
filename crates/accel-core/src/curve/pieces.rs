// SPDX-License-Identifier: GPL-3.0-or-later
//! A ray and a ribbon that faces it, in straight pieces: Embree's, whose pictures this is for. Seen along the ray, a piece
//! is a quad between two points of the curve, as broad as twice the radius and across the curve at each.
//! Source: [WBW*14], for the test of quads [MT97] in two dimensions. Space: by the axes of the ray.
//! Invariant: a piece belongs to the part that holds its first parameter. Tests: `tests/curves.rs` of `gnurt-accel`.

use super::cubic::Cubic;
use super::ray::{CurveHit, Offer, RayFrame};

type Point = [f64; 3];

/// So many radii a ray goes before it meets a ribbon, as by Embree: one that starts on a ribbon, which turns to face it, would meet
/// that again.
const SKIPPED: f64 = 2.0;

/// Offers the hits of the pieces of a part, whose ends are ends of pieces.
#[inline(always)]
pub(super) fn meet(cubic: &Cubic, count: u8, ray: &RayFrame, [from, to]: [f64; 2], hit: Offer) {
    let seen = cubic.mapped(|v| ray.by_axes(v), ray.org);
    let count = f64::from(count);
    let [first, last] = [(from * count).round() as u32, (to * count).round() as u32];
    let mut a = seen.at(f64::from(first) / count);
    for i in first..last {
        let [start, end] = [f64::from(i) / count, f64::from(i + 1) / count];
        let b = seen.at(end);
        if is_near(&a, &b) {
            let sides = [across(&seen, start, &a, &b), across(&seen, end, &a, &b)];
            let edge = |sign: f64| [beside(&a, sides[0], sign), beside(&b, sides[1], sign)];
            let [right, left] = [edge(1.0), edge(-1.0)];
            let found = through([right[0], right[1], left[1], left[0]]);
            let is_ahead = |&(z, u, _): &(f64, f64, f64)| z > SKIPPED * (a[3] + u * (b[3] - a[3]));
            if let Some((z, u, v)) = found.filter(is_ahead) {
                hit(CurveHit { t: z / ray.length, u: (f64::from(i) + u) / count, v: 2.0 * v - 1.0 });
            }
        }
        a = b;
    }
}

/// Whether the ray comes as near to a piece's chord as it is broad, and not by more: a quad may reach farther.
#[inline(always)]
fn is_near(a: &[f64; 4], b: &[f64; 4]) -> bool {
    let step = [b[0] - a[0], b[1] - a[1]];
    let square = step[0] * step[0] + step[1] * step[1];
    let off = a[0] * step[1] - a[1] * step[0];
    let radius = a[3].max(b[3]);
    off * off <= radius * radius * square
}

/// The unit vector across the curve at a parameter, as it is seen.
#[inline(always)]
fn across(seen: &Cubic, u: f64, a: &[f64; 4], b: &[f64; 4]) -> [f64; 2] {
    let slope = seen.slope(u);
    // Where the curve stands still it goes to the next point.
    let is_still = slope[..3].iter().all(|x| x.abs() < 1e-9 * (1.0 + b[0].abs() + b[1].abs() + b[2].abs()));
    let [x, y] = if is_still { [b[0] - a[0], b[1] - a[1]] } else { [slope[0], slope[1]] };
    let length = (x * x + y * y).sqrt();
    [y / length, -x / length]
}

#[inline(always)]
fn beside([x, y, z, radius]: &[f64; 4], [dx, dy]: [f64; 2], sign: f64) -> Point {
    [x + sign * radius * dx, y + sign * radius * dy, *z]
}

/// Where the axis through the origin goes through a quad from its front: the depth, and both parameters.
#[inline(always)]
fn through([a, b, c, d]: [Point; 4]) -> Option<(f64, f64, f64)> {
    let cross = |p: Point, q: Point| p[0] * q[1] - p[1] * q[0];
    // The half on this side of the diagonal.
    let is_first = cross(d, b) <= 0.0;
    let [p, q, r] = if is_first { [a, b, d] } else { [c, d, b] };
    // Twice the areas of the triangles of the origin and each side.
    let [of_q, of_r] = [cross(r, p), cross(p, q)];
    let area = cross([q[0] - p[0], q[1] - p[1], 0.0], [r[0] - p[0], r[1] - p[1], 0.0]);
    if !(of_q >= 0.0 && of_r >= 0.0 && area > 0.0) {
        return None;
    }
    let (u, v) = (of_q / area, of_r / area);
    let z = p[2] + u * (q[2] - p[2]) + v * (r[2] - p[2]);
    Some(if is_first { (z, u, v) } else { (z, 1.0 - u, 1.0 - v) })
}
