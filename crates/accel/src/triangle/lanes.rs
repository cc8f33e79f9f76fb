// SPDX-License-Identifier: GPL-3.0-or-later
//! The watertight test in lanes: many rays against one triangle, or one ray against many triangles.
//! Source: [WBW13]; see `watertight.rs`, which holds the scalar form and says why it holds.
//! Invariant: every lane does the roundings of the scalar form in its order: the same bits at any width and level.
//! Proof: `tests/brute_force.rs` (`ask`).

use gnurt_simd::{Simd, SimdFloat, prelude::*};

use super::Meeting;
use super::watertight::{HUGE, TINY, meet_exactly};

/// Floats in lanes.
pub(crate) trait Lanes<S: Simd>: SimdFloat<S, Element = f32> {}
impl<S: Simd, V: SimdFloat<S, Element = f32>> Lanes<S> for V {}

/// Where lanes meet triangles.
#[derive(Clone, Copy)]
pub(crate) struct LanesMeeting<S: Simd, V: Lanes<S>> {
    pub(crate) t: V,
    pub(crate) u: V,
    pub(crate) v: V,
    /// Lanes that do.
    pub(crate) hit: V::Mask,
}

/// Rays prepared for the test: origins along the axes of the sheared space (z is the axis along which the ray moves
/// most, x and y follow it in cyclic order), and the shear.
#[derive(Clone, Copy)]
pub(crate) struct Sheared<V> {
    pub(crate) org: [V; 3],
    pub(crate) shear: [V; 3],
}

/// `corners` have their coordinates along the axes of the sheared space, corner by corner.
#[inline(always)]
pub(crate) fn meet_lanes<S: Simd, V: Lanes<S>>(
    simd: S,
    [a, b, c]: [[V; 3]; 3],
    Sheared { org, shear }: &Sheared<V>,
    active: V::Mask,
    t_near: V,
    t_far: V,
) -> LanesMeeting<S, V> {
    let at = |value: f32| V::splat(simd, value);
    let depth = [a[2] - org[2], b[2] - org[2], c[2] - org[2]];
    let px = [
        a[0] - org[0] - shear[0] * depth[0],
        b[0] - org[0] - shear[0] * depth[1],
        c[0] - org[0] - shear[0] * depth[2],
    ];
    let py = [
        a[1] - org[1] - shear[1] * depth[0],
        b[1] - org[1] - shear[1] * depth[1],
        c[1] - org[1] - shear[1] * depth[2],
    ];

    let w0 = px[2] * py[1] - py[2] * px[1];
    let w1 = px[0] * py[2] - py[0] * px[2];
    let w2 = px[1] * py[0] - py[1] * px[0];
    let zero = at(0.0);
    // Least and greatest of the three: two operations each where signs would take five. A NaN on the way may be lost
    // or kept; lanes with one are not certain below.
    let least = w0.min(w1).min(w2);
    let most = w0.max(w1).max(w2);
    let inside = active & !(least.simd_lt(zero) & most.simd_gt(zero));
    let mut meeting = LanesMeeting { t: zero, u: zero, v: zero, hit: inside };
    if !inside.any_true() {
        return meeting;
    }

    let ts = [shear[2] * depth[0], shear[2] * depth[1], shear[2] * depth[2]];
    let sum = w0 + w1 + w2;
    let tiny = at(TINY);
    let certain = w0.abs().simd_ge(tiny)
        & w1.abs().simd_ge(tiny)
        & w2.abs().simd_ge(tiny)
        & sum.abs().simd_le(at(HUGE));

    let over = at(1.0) / sum;
    meeting.u = w1 * over;
    meeting.v = w2 * over;
    let t = (w0 * over) * ts[0] + meeting.u * ts[1] + meeting.v * ts[2];
    let (first, last) = (ts[0].min(ts[1]).min(ts[2]), ts[0].max(ts[1]).max(ts[2]));
    meeting.t = t.max(first).min(last) + zero;
    meeting.hit = inside & certain & meeting.t.simd_ge(t_near) & meeting.t.simd_le(t_far);

    let mut uncertain = (inside & !certain).to_bitmask();
    while uncertain != 0 {
        let i = uncertain.trailing_zeros() as usize;
        uncertain &= uncertain - 1;
        let found = meet_exactly(
            [px[0][i], px[1][i], px[2][i]],
            [py[0][i], py[1][i], py[2][i]],
            [ts[0][i], ts[1][i], ts[2][i]],
            t_near[i],
            t_far[i],
        );
        let Meeting { t, u, v } = found.unwrap_or(Meeting { t: 0.0, u: 0.0, v: 0.0 });
        meeting.t[i] = t;
        meeting.u[i] = u;
        meeting.v[i] = v;
        meeting.hit.set(i, found.is_some());
    }
    meeting
}
