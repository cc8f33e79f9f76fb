// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a ray that passes inside of a triangle meets it, from what is not rounded: in double precision, and in exact
//! arithmetic where that is not enough either (slivers a ten-millionth as wide as they are long, seen edge on from close by).
//! Source: [WBW13] without the division: sheared positions times the ray's longest component; [She97] for the plan.
//! Space: along the axes of the sheared space. Invariant: `t` is off by 2^-21 of itself at most. A ray that floats let pass
//! inside, though it passes beside the triangle, meets it at its edge: weights of the wrong sign are none.
//! Tests: `tests`, `tests/parameters.rs` of `gnurt-accel`.

use crate::exact::ExactMeeting;

/// A triangle and a ray before anything is rounded, along the axes of the sheared space.
pub(super) struct Corners {
    pub(super) corners: [[f32; 3]; 3],
    pub(super) org: [f32; 3],
    pub(super) dir: [f32; 3],
}

/// Ray parameter, and weights of the second and the third corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Weighed {
    pub(super) t: f64,
    pub(super) u: f64,
    pub(super) v: f64,
}

/// As `DOUBTFUL` of `watertight.rs`, for doubles and 2^-21, with twice the room.
const DOUBTFUL: f64 = (1u64 << 29) as f64;

/// `None` where the ray is in the triangle's plane.
pub(super) fn meet(triangle: &Corners) -> Option<Weighed> {
    in_doubles(triangle).or_else(|| {
        let Corners { corners, org, dir } = triangle;
        let ExactMeeting { t, u, v } = ExactMeeting::of(corners, org, dir)?;
        Some(Weighed { t, u, v })
    })
}

/// `None` where doubles are not sure.
fn in_doubles(Corners { corners, org, dir }: &Corners) -> Option<Weighed> {
    let [dx, dy, dz] = dir.map(f64::from);
    let from = corners.map(|corner| [0, 1, 2].map(|k| f64::from(corner[k]) - f64::from(org[k])));
    let px = from.map(|p| p[0] * dz - p[2] * dx);
    let py = from.map(|p| p[1] * dz - p[2] * dy);
    let weight = |b: usize, c: usize| px[c] * py[b] - py[c] * px[b];
    let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
    let sum: f64 = weights.iter().sum();
    let side = if sum < 0.0 { -1.0 } else { 1.0 };
    let weights = weights.map(|w| (side * w).max(0.0));
    let whole: f64 = weights.iter().sum();
    let depth = [from[0][2], from[1][2], from[2][2]];
    let t = weights.iter().zip(&depth).map(|(w, z)| w * z).sum::<f64>() / (whole * dz);

    let wide = px.iter().chain(&py).fold(0.0f64, |most, x| most.max(x.abs()));
    let (near, far) = (
        depth.iter().copied().fold(f64::INFINITY, f64::min),
        depth.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    );
    let doubt = (far - near) * wide * (wide + near.abs().max(far.abs()) * dz.abs());
    // Not so of NaN.
    let sure = doubt < DOUBTFUL * (t * dz * sum).abs();
    sure.then(|| Weighed { t, u: weights[1] / whole, v: weights[2] / whole })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_are_exact_or_say_that_they_are_not() {
        let mut random = gnurt_testkit::Random::new(3);
        let (mut sure, mut unsure) = (0, 0);
        for round in 0..20_000 {
            // Slivers from 1 down to 2^-40 as wide as they are long, seen from as near.
            let thin = 0.5f32.powi(round % 41);
            let near = 0.5f32.powi(round / 41 % 21);
            let p = random.point();
            let mut beside = |by: f32| {
                let q = random.point();
                [0, 1, 2].map(|k| p[k] + by * q[k])
            };
            let (a, b) = (beside(1.0), beside(thin));
            let corners = [p, a, b];
            let org = beside(near);
            let inside = [0, 1, 2].map(|k| (p[k] + a[k] + b[k]) / 3.0 - org[k]);
            let dir = inside;
            let z = (0..3).max_by(|&i, &j| dir[i].abs().total_cmp(&dir[j].abs())).expect("three");
            let along = |p: [f32; 3]| [p[(z + 1) % 3], p[(z + 2) % 3], p[z]];
            let triangle = Corners { corners: corners.map(along), org: along(org), dir: along(dir) };
            let exact = ExactMeeting::of(&triangle.corners, &triangle.org, &triangle.dir);
            let (Some(found), Some(exact)) = (in_doubles(&triangle), exact) else {
                unsure += 1;
                continue;
            };
            sure += 1;
            let off = (found.t - exact.t).abs();
            assert!(off <= 5e-7 * exact.t.abs(), "{} is {} in truth", found.t, exact.t);
        }
        assert!(sure > 10_000 && unsure > 100, "{sure} sure and {unsure} unsure cases are enough to tell");
    }
}
