// SPDX-License-Identifier: GPL-3.0-or-later
//! A ray and a tube: circles around a cubic and across it. A stretch between two parameters is nearly a cone, whose hits
//! are the starts of Newton's method for the distance along the ray and the parameter of the curve together.
//! Source: cones as steps to the curve are [RL18]; the pair of equations is that of sweeps in [Wij84]. Space: object.
//! Invariant: fixed parameters are shared by neighbouring parts, and a root belongs to the part that holds its parameter.
//! Tests: `tests/curves.rs` of `gnurt-accel`.

use super::cubic::Cubic;
use super::ray::{CurveHit, Offer, RayFrame};
use super::{along, dot, minus, place};

/// How far a stretch may be from its chord, by the radius.
const STRAIGHT: f64 = 0.05;

/// Most stretches of one curve.
const MOST_STRETCHES: f64 = 32.0;

/// Offers the hits of the part between two parameters; the last point of the curve belongs to its last part.
pub(super) fn meet(cubic: &Cubic, ray: &RayFrame, [from, to]: [f64; 2], hit: Offer) {
    // From the point of the ray beside the part, so that nothing cancels.
    let middle = place(cubic.at(0.5 * (from + to)));
    let start = dot(minus(middle, ray.org), ray.axes[2]);
    let near = cubic.mapped(|v| ray.by_axes(v), along(ray.org, start, ray.axes[2]));
    let mut a = near.at(from);
    let radius = a[3].max(near.at(to)[3]).max(near.at(0.5 * (from + to))[3]);
    let most = MOST_STRETCHES * (to - from);
    let mut stretches = 1.0;
    let mut off = near.bend_length(from).max(near.bend_length(to)) * (to - from) * (to - from) / 8.0;
    while stretches < most && off > STRAIGHT * radius {
        (stretches, off) = (2.0 * stretches, 0.25 * off);
    }
    let step = (to - from) / stretches;
    for i in 0..stretches as u32 {
        let ends = [from + step * f64::from(i), from + step * f64::from(i + 1)];
        let b = near.at(ends[1]);
        if is_beside(&a, &b, off) {
            a = b;
            continue;
        }
        let is_last = ends[1] >= 1.0;
        let mut before = f64::NAN;
        for (s, t) in starts([a, b], off).into_iter().flatten() {
            let u = ends[0] + t * (ends[1] - ends[0]);
            let Some((s, u, enters)) = newton(&near, s, u, ends) else { continue };
            let is_here = u >= ends[0] && (u < ends[1] || is_last && u <= 1.0);
            // Both starts may lead to one hit.
            let is_other = before.is_nan() || (s - before).abs() > 1e-9 * radius;
            if is_here && is_other {
                before = s;
                if !hit(CurveHit { t: (start + s) / ray.length, u, v: 0.0 }) && enters {
                    break;
                }
            }
        }
        a = b;
    }
}

/// Whether the ray, which is the third axis, surely passes all within the radius and `off` of a chord.
#[inline(always)]
fn is_beside(a: &[f64; 4], b: &[f64; 4], off: f64) -> bool {
    let step = [b[0] - a[0], b[1] - a[1]];
    let widest = a[3].max(b[3]) + 2.0 * off;
    let most = widest * widest * (step[0] * step[0] + step[1] * step[1]);
    let across = a[0] * step[1] - a[1] * step[0];
    let (before, behind) = (a[0] * step[0] + a[1] * step[1], -(b[0] * step[0] + b[1] * step[1]));
    across * across > most || before > 0.0 && before * before > most || behind > 0.0 && behind * behind > most
}

/// Where the third axis meets the cone between two circles, or comes nearest to it: distances along the ray, and
/// parameters on the chord. None where it surely misses all that is within `off` of the cone.
#[inline(always)]
fn starts([a, b]: [[f64; 4]; 2], off: f64) -> Option<[(f64, f64); 2]> {
    let (from, chord) = (place(a), minus(place(b), place(a)));
    let square = dot(chord, chord);
    let e = chord[2];
    let q = -dot(from, chord);
    if square == 0.0 {
        return None;
    }
    // |s dir - from - t chord|^2 = (ra + t (rb - ra))^2, with t = (q + s e) / square.
    let growth = b[3] - a[3];
    let over = 1.0 / square;
    let [slope, at_start] = [growth * e * over, a[3] + growth * q * over];
    let aa = 1.0 - e * e * over - slope * slope;
    let bb = -from[2] - q * e * over - slope * at_start;
    let cc = dot(from, from) - q * q * over - at_start * at_start;
    let param = |s: f64| (q + s * e) * over;
    let widest = a[3].max(b[3]) + 2.0 * off;
    if aa.abs() < 1e-12 {
        // Along it.
        let s = if bb == 0.0 { 0.0 } else { -0.5 * cc / bb };
        return Some([(s, param(s)); 2]);
    }
    let root = bb * bb - aa * cc;
    let over_aa = 1.0 / aa;
    let middle = -bb * over_aa;
    let over_aa = over_aa.abs();
    if root < 0.0 {
        // The distance from the axis there, beyond the widest circle.
        let t = param(middle).clamp(0.0, 1.0);
        let p = along([-from[0], -from[1], middle - from[2]], -t, chord);
        let left = widest * widest - dot(p, p);
        // From both sides, so that either hit is found.
        let half = (left.max(0.0) * over_aa).sqrt();
        let ends = [middle - half, middle + half];
        return (left >= 0.0).then_some(ends.map(|s| (s, param(s))));
    }
    // Where the cone is only just met, the tube may be met farther apart.
    let half = (root * over_aa * over_aa).max(2.0 * widest * off * over_aa).sqrt();
    let (near, far) = (middle - half, middle + half);
    Some([(near, param(near)), (far, param(far))])
}

/// The hit that Newton's method leads to, its parameter, and whether the ray enters the tube there.
#[inline(always)]
fn newton(near: &Cubic, mut s: f64, u: f64, ends: [f64; 2]) -> Option<(f64, f64, bool)> {
    let width = ends[1] - ends[0];
    // Starts outside of the stretch may still lead into it, but none from afar.
    if u < ends[0] - 0.5 * width || u > ends[1] + 0.5 * width {
        return None;
    }
    let mut u = u.clamp(ends[0], ends[1]);
    for _ in 0..12 {
        let (point, slope, bend) = (near.at(u), near.slope(u), place(near.bend(u)));
        let (radius, grows, tangent) = (point[3], slope[3], place(slope));
        let out = [-point[0], -point[1], s - point[2]];
        // Across the curve, and at the radius.
        let (f, g) = (dot(out, tangent), 0.5 * (dot(out, out) - radius * radius));
        let (f_s, f_u) = (tangent[2], dot(out, bend) - dot(tangent, tangent));
        let (g_s, g_u) = (out[2], -f - radius * grows);
        let over = 1.0 / (f_s * g_u - f_u * g_s);
        let (ds, du) = ((f * g_u - g * f_u) * over, (g * f_s - f * g_s) * over);
        // No root is near.
        if du.is_nan() || du.abs() > 4.0 * width {
            return None;
        }
        (s, u) = (s - ds, u - du);
        if u < ends[0] - width || u > ends[1] + width {
            return None;
        }
        // A step squares what is left.
        if ds.abs() <= 1e-6 * radius && du.abs() <= 1e-6 * width {
            return (radius > 0.0).then_some((s, u, g_s < 0.0));
        }
    }
    None
}
