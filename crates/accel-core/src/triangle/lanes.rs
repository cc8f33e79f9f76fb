// SPDX-License-Identifier: GPL-3.0-or-later
//! The watertight test in lanes: many rays against one triangle, or one ray against many triangles.
//! Source: [WBW13]; see `watertight.rs`, which holds the scalar form and says why it holds.
//! Invariant: every lane does the roundings of the scalar form in its order: the same bits at any width and level.
//! Proof: `tests/brute_force.rs` (`ask`).

use gnurt_simd::{Simd, SimdFloat, prelude::*};

use super::meeting::Meeting;
use super::precise::Corners;
use super::watertight::{DOUBTFUL, HUGE, SURELY, TINY, meet_exactly};

/// Floats in lanes.
pub trait Lanes<S: Simd>: SimdFloat<S, Element = f32> {}
impl<S: Simd, V: SimdFloat<S, Element = f32>> Lanes<S> for V {}

/// Where lanes meet triangles.
#[derive(Clone, Copy)]
pub struct LanesMeeting<S: Simd, V: Lanes<S>> {
    pub t: V,
    pub u: V,
    pub v: V,
    /// Lanes that do.
    pub hit: V::Mask,
}

/// Rays prepared for the test: origins along the axes of the sheared space (z is the axis along which the ray moves
/// most, x and y follow it in cyclic order), and the shear.
#[derive(Clone, Copy, Debug)]
pub struct Sheared<V> {
    pub org: [V; 3],
    pub shear: [V; 3],
}

/// One ray of many, for [`meet_alone`]: what lanes know of it, and its direction, which is not rounded; along the axes of the
/// sheared space.
#[derive(Clone, Copy, Debug)]
pub struct LoneRay {
    pub sheared: Sheared<f32>,
    pub dir: [f32; 3],
}

/// Lanes that pass all three edges, and what that took.
#[derive(Clone, Copy)]
pub struct Edges<S: Simd, V: Lanes<S>> {
    depth: [V; 3],
    px: [V; 3],
    py: [V; 3],
    w: [V; 3],
    /// Lanes whose ray passes inside.
    pub inside: V::Mask,
}

/// Lanes that pass inside of triangles some corner of which is in reach.
#[derive(Clone, Copy)]
pub struct Reached<S: Simd, V: Lanes<S>> {
    edges: Edges<S, V>,
    over_dir: V,
    ts: [V; 3],
    first: V,
    last: V,
    t_near: V,
    t_far: V,
    /// These lanes.
    pub lanes: V::Mask,
}

/// Corners relative to the rays' origins, corner by corner.
#[inline(always)]
pub fn relative_to<S: Simd, V: Lanes<S>>([a, b, c]: [[V; 3]; 3], org: &[V; 3]) -> [[V; 3]; 3] {
    [
        [a[0] - org[0], a[1] - org[1], a[2] - org[2]],
        [b[0] - org[0], b[1] - org[1], b[2] - org[2]],
        [c[0] - org[0], c[1] - org[1], c[2] - org[2]],
    ]
}

/// The first half of the test: on which side of the edges rays pass. Most lanes end here, so callers look at `inside`
/// before they go on to `Edges::meet`: a test that returned all at once would be merged from two ways by copies.
///
/// `corners` have their coordinates along the axes of the sheared space, [relative](relative_to) to the origins.
#[inline(always)]
pub fn pass_edges<S: Simd, V: Lanes<S>>(simd: S, [a, b, c]: [[V; 3]; 3], shear: &[V; 3]) -> Edges<S, V> {
    let depth = [a[2], b[2], c[2]];
    let px = [a[0] - shear[0] * depth[0], b[0] - shear[0] * depth[1], c[0] - shear[0] * depth[2]];
    let py = [a[1] - shear[1] * depth[0], b[1] - shear[1] * depth[1], c[1] - shear[1] * depth[2]];
    let w0 = px[2] * py[1] - py[2] * px[1];
    let w1 = px[0] * py[2] - py[0] * px[2];
    let w2 = px[1] * py[0] - py[1] * px[0];
    // Least and greatest of the three: two operations each where signs would take five. A NaN on the way may be lost
    // or kept; lanes with one are not certain below.
    let least = w0.min(w1).min(w2);
    let most = w0.max(w1).max(w2);
    let zero = V::splat(simd, 0.0);
    let inside = !(least.simd_lt(zero) & most.simd_gt(zero));
    Edges { depth, px, py, w: [w0, w1, w2], inside }
}

impl<S: Simd, V: Lanes<S>> Edges<S, V> {
    /// Which of the lanes inside may meet their triangle in `[t_near, t_far]`: a hit is between its corners' own `t`.
    #[inline(always)]
    pub fn reach(self, over_dir: V, t_near: V, t_far: V) -> Reached<S, V> {
        let [a, b, c] = self.depth;
        let ts = [over_dir * a, over_dir * b, over_dir * c];
        let (first, last) = (ts[0].min(ts[1]).min(ts[2]), ts[0].max(ts[1]).max(ts[2]));
        let lanes = self.inside & last.simd_ge(t_near) & first.simd_le(t_far);
        Reached { edges: self, over_dir, ts, first, last, t_near, t_far, lanes }
    }
}

impl<S: Simd, V: Lanes<S>> Reached<S, V> {
    /// The last part: where the lanes meet the triangles; and the lanes that floats cannot decide, or not well enough, which
    /// are for [`meet_alone`].
    #[inline(always)]
    pub fn meet(&self, simd: S) -> (LanesMeeting<S, V>, V::Mask) {
        let Self { edges, over_dir, ts, first, last, t_near, t_far, lanes } = *self;
        let Edges { px, py, w: [w0, w1, w2], .. } = edges;
        let sum = w0 + w1 + w2;
        let size = sum.abs();
        let least = w0.abs().min(w1.abs()).min(w2.abs());
        let certain = least.simd_ge(V::splat(simd, TINY)) & size.simd_le(V::splat(simd, HUGE));

        let over = V::splat(simd, 1.0) / sum;
        let (u, v) = (w1 * over, w2 * over);
        let t = (w0 * over) * ts[0] + u * ts[1] + v * ts[2];
        let t = t.max(first).min(last) + V::splat(simd, 0.0);

        let (away, scale, long) = (t.abs(), over_dir.abs(), last - first);
        let wide_x = px[0].abs().max(px[1].abs()).max(px[2].abs());
        let wide_y = py[0].abs().max(py[1].abs()).max(py[2].abs());
        let wide = wide_x.max(wide_y);
        let doubt = long * (wide * (wide * scale + (away + long)));
        let per_t = size * scale;
        let good = certain & doubt.simd_lt(V::splat(simd, DOUBTFUL) * (away * per_t));
        let hit = lanes & good & t.simd_ge(t_near) & t.simd_le(t_far);
        let mut alone = lanes & !good;
        if alone.any_true() {
            let off = V::splat(simd, SURELY) * doubt;
            let out = ((t_near - t) * per_t).simd_gt(off) | ((t - t_far) * per_t).simd_gt(off);
            alone &= !(out & certain);
        }
        (LanesMeeting { t, u, v, hit }, alone)
    }
}

/// One lane in double precision, from the start: `corners` of one triangle along the sheared space's axes.
#[cold]
#[inline(never)]
pub fn meet_alone(corners: &[[f32; 3]; 3], ray: &LoneRay, t_near: f32, t_far: f32) -> Option<Meeting> {
    let ([a, b, c], LoneRay { sheared: Sheared { org, shear }, dir }) = (corners, ray);
    let depth = [a[2] - org[2], b[2] - org[2], c[2] - org[2]];
    let along = |k: usize| {
        [
            a[k] - org[k] - shear[k] * depth[0],
            b[k] - org[k] - shear[k] * depth[1],
            c[k] - org[k] - shear[k] * depth[2],
        ]
    };
    let ts = [shear[2] * depth[0], shear[2] * depth[1], shear[2] * depth[2]];
    let unrounded = Corners { corners: *corners, org: *org, dir: *dir };
    meet_exactly(along(0), along(1), ts, &unrounded, t_near, t_far)
}
