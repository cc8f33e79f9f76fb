// SPDX-License-Identifier: GPL-3.0-or-later
//! The watertight test in lanes: many rays against one triangle, or one ray against many triangles.
//! Source: [WBW13]; see `watertight.rs`, which holds the scalar form and says why it holds.
//! Invariant: every lane does the roundings of the scalar form in its order: the same bits at any width and level.
//! Tests: `tests/brute_force.rs` (`ask`).

use gnurt_simd::{Simd, SimdFloat, f32x16, prelude::*};

use super::precise::in_double_lanes;
use super::triangle_hit::TriangleHit;
use super::watertight::{DOUBTFUL, HUGE, SURELY, SingleRay, TINY};

/// Floats in lanes.
pub trait Lanes<S: Simd>: SimdFloat<S, Element = f32> {}
impl<S: Simd, V: SimdFloat<S, Element = f32>> Lanes<S> for V {}

/// Where lanes meet triangles.
#[derive(Clone, Copy)]
pub struct TriangleHits<S: Simd, V: Lanes<S>> {
    pub t: V,
    pub u: V,
    pub v: V,
    /// Lanes that do.
    pub hit: V::Mask,
}

/// Lanes that pass all three edges, and their edge values.
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

/// The first half of the test: on which side of the edges rays pass. Most lanes end here, so callers test
/// `inside` before they continue with `Edges::reach`: a test that returned all at once would merge two paths
/// by copies.
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
    // Least and greatest of the three: two operations each where signs would take five. A NaN may be lost or
    // kept; lanes with one are not certain below.
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
    /// The last part, in floats: the lanes' hits; and the lanes that floats cannot decide, which are for
    /// [`meet_single`]. Callers that need the exact position continue with [`Reached::doubtful`].
    #[inline(always)]
    pub fn meet(&self, simd: S) -> (TriangleHits<S, V>, V::Mask) {
        let Self { edges: Edges { w: [w0, w1, w2], .. }, ts, first, last, t_near, t_far, lanes, .. } = *self;
        let sum = w0 + w1 + w2;
        let least = w0.abs().min(w1.abs()).min(w2.abs());
        let certain = least.simd_ge(V::splat(simd, TINY)) & sum.abs().simd_le(V::splat(simd, HUGE));

        let over = V::splat(simd, 1.0) / sum;
        let (u, v) = (w1 * over, w2 * over);
        let t = (w0 * over) * ts[0] + u * ts[1] + v * ts[2];
        let t = t.max(first).min(last) + V::splat(simd, 0.0);
        let hit = lanes & certain & t.simd_ge(t_near) & t.simd_le(t_far);
        (TriangleHits { t, u, v, hit }, lanes & !certain)
    }

    /// Lanes inside whose `t`, which is given, may be off too far: they are for [`meet_inside`].
    #[inline(always)]
    pub fn doubtful(&self, simd: S, t: V) -> V::Mask {
        let Self { edges, over_dir, first, last, t_near, t_far, lanes, .. } = *self;
        let Edges { px, py, w: [w0, w1, w2], .. } = edges;
        let (away, scale, size) = (t.abs(), over_dir.abs(), (w0 + w1 + w2).abs());
        let long = last - first;
        let wide_x = px[0].abs().max(px[1].abs()).max(px[2].abs());
        let wide_y = py[0].abs().max(py[1].abs()).max(py[2].abs());
        let wide = wide_x.max(wide_y);
        let doubt = long * (wide * (wide * scale + (away + long)));
        let per_t = size * scale;
        let lanes = lanes & !doubt.simd_lt(V::splat(simd, DOUBTFUL) * (away * per_t));
        if !lanes.any_true() {
            return lanes;
        }
        let off = V::splat(simd, SURELY) * doubt;
        lanes & !(((t_near - t) * per_t).simd_gt(off) | ((t - t_far) * per_t).simd_gt(off))
    }
}

/// One lane from the start, in the scalar form: `corners` of one triangle along the sheared space's axes.
#[cold]
#[inline(never)]
pub fn meet_single(
    corners: &[[f32; 3]; 3],
    ray: &SingleRay,
    needs_position: bool,
    t_near: f32,
    t_far: f32,
) -> Option<TriangleHit> {
    ray.meet(corners, needs_position, t_near, t_far)
}

/// One lane of the doubtful ones (`Reached::doubtful`): it passes inside.
#[cold]
#[inline(never)]
pub fn meet_inside(corners: &[[f32; 3]; 3], ray: &SingleRay, t_near: f32, t_far: f32) -> Option<TriangleHit> {
    ray.meet_inside(corners, t_near, t_far)
}

/// The same for sixteen rays and one triangle, in double precision; and by bits the lanes for which that is enough.
#[inline(always)]
pub fn meet_inside_in_lanes<S: Simd>(
    simd: S,
    corners: &[[f32; 3]; 3],
    org: &[f32x16<S>; 3],
    dir: &[f32x16<S>; 3],
    over_dir: f32x16<S>,
) -> ([f32x16<S>; 3], u64) {
    let ([t, u, v], sure) = in_double_lanes(simd, corners, org, dir);
    let [a, b, c] = corners;
    let ts = [
        over_dir * (f32x16::splat(simd, a[2]) - org[2]),
        over_dir * (f32x16::splat(simd, b[2]) - org[2]),
        over_dir * (f32x16::splat(simd, c[2]) - org[2]),
    ];
    let (first, last) = (ts[0].min(ts[1]).min(ts[2]), ts[0].max(ts[1]).max(ts[2]));
    ([t.max(first).min(last) + f32x16::splat(simd, 0.0), u, v], sure)
}
