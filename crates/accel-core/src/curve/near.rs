// SPDX-License-Identifier: GPL-3.0-or-later
//! The nearest point of a curve. Of round ones on the surface of all spheres around the curve, of others on the curve
//! itself: where a ribbon that faces rays is depends on the ray.
//! Source: golden section [PTVF07], section 10.2, in the brackets of a coarse search. Space: the searched one; lengths count
//! where the probe's axes lead. Where these stretch space unevenly, a surface's point is that of the nearest point of the
//! curve, although another may be nearer.
//! Tests: `tests/curves.rs` of `gnurt-accel`.

use super::segment::Segment;
use super::{Vector, along, dot, minus, place, scaled};
use crate::point::Probe;

/// Steps of the coarse search over a whole curve.
const STEPS: f64 = 64.0;

impl Segment {
    /// The offset from the probe to the nearest point of the part between two parameters, and its parameter.
    #[must_use]
    pub fn nearest(&self, probe: &Probe, [from, to]: [f64; 2]) -> (Vector, f64) {
        let is_round = matches!(self, Self::Round(..) | Self::Cone { .. });
        let distance = |t: f64| {
            let offset = probe.offset(place(self.at(t)));
            let axis = dot(offset, offset).sqrt();
            if is_round { axis - self.at(t)[3] * probe.least_growth } else { axis }
        };
        let steps = (STEPS * (to - from)).max(4.0);
        let step = (to - from) / steps;
        let mut best = (f64::INFINITY, from);
        for i in 0..=steps as u32 {
            let t = from + step * f64::from(i);
            let d = distance(t);
            if d < best.0 {
                best = (d, t);
            }
        }
        let (mut a, mut b) = ((best.1 - step).max(from), (best.1 + step).min(to));
        let golden = 0.5 * (5.0f64.sqrt() - 1.0);
        let inner = |a: f64, b: f64| (b - golden * (b - a), a + golden * (b - a));
        let (mut c, mut d) = inner(a, b);
        let (mut at_c, mut at_d) = (distance(c), distance(d));
        while b - a > 1e-12 {
            if at_c < at_d {
                (b, d, at_d) = (d, c, at_c);
                c = inner(a, b).0;
                at_c = distance(c);
            } else {
                (a, c, at_c) = (c, d, at_d);
                d = inner(a, b).1;
                at_d = distance(d);
            }
        }
        let t = if distance(0.5 * (a + b)) < best.0 { 0.5 * (a + b) } else { best.1 };
        let point = self.at(t);
        if !is_round {
            return (probe.offset(place(point)), t);
        }
        let out = minus(probe.point, place(point));
        let length = dot(out, out).sqrt();
        let out = if length > 0.0 { scaled(out, 1.0 / length) } else { [1.0, 0.0, 0.0] };
        (probe.offset(along(place(point), point[3], out)), t)
    }
}
