// SPDX-License-Identifier: GPL-3.0-or-later
//! The watertight ray-triangle test: no ray passes between triangles that share an edge or a corner.
//! Source: [WBW13]: translate to the ray's origin, shear so that the ray is the z axis, decide by the signs of three
//! 2D edge functions. Differs: the fallback to double precision is taken for any edge function that is too
//! small or too large for a float, instead of only for zeros, and ends in double precision. `t` is clamped to
//! the corners' own. If `t` in floats may have a relative error above 1e-5, as in slivers, at grazing rays
//! and close to large triangles, it is computed again from unrounded input (`precise.rs`).
//!
//! Correctness: a corner's sheared position depends only on ray and corner, so both triangles at an edge have
//! the same two points. Rounding is monotonic, so `fl(a*b) - fl(c*d)` never has the wrong sign, it can only
//! be zero; then products in double precision are exact and their difference has the right sign. NaN (from
//! infinities that cancel) is on neither side and goes to double precision too.
//!
//! Error of `t`: a corner's sheared position has the rounding error of itself (at most `wide`) and of its
//! depth (at most `away + long`, times the direction). An edge function has that times `wide`; a weight that
//! over their sum; and `t` that times the range of the corners' own `t` (`long`). Together: `k * 2^-24 * long
//! * wide * (wide + (|t| + long) * |dir|) / |sum|`, `k` being 2.7 in the worst of 4 million hits of all
//! kinds. [`DOUBTFUL`] accepts an error below 1e-5 of `t` for a `k` of 3.5. Hits out of reach by [`SURELY`],
//! a `k` of 16, are not computed again; the triangle at a ray's origin is an example. Any-hit queries return
//! no `t`, and use the decision of floats. The decision of floats depends only on ray and triangle, so the
//! nearer of two hits never depends on the order of visits.
//! Tests: `tests::agrees_with_double_precision`, `tests/watertight.rs`, `tests/parameters.rs` of `gnurt-accel`.

use super::precise::{self, Corners, Weighed};
use super::triangle_hit::TriangleHit;
use crate::float::{Number, least, most};
use crate::ray::Ray;

/// Edge functions of a smaller magnitude are computed again in double precision.
pub(super) const TINY: f32 = 1e-30;
/// The same for sums of edge functions of a greater magnitude.
pub(super) const HUGE: f32 = 1e30;

/// `t` in floats is accepted if the error measure (see the head) is less than this many times `t`.
pub(super) const DOUBTFUL: f32 = 48.0;
/// And the error of `t` is never more than this many times the error measure.
pub(super) const SURELY: f32 = 16.0 * f32::EPSILON / 2.0;

/// Rays prepared for the test: origins along the axes of the sheared space (z is the axis along which the ray moves
/// most, x and y follow it in cyclic order), and the shear.
#[derive(Clone, Copy, Debug)]
pub struct Sheared<V> {
    pub org: [V; 3],
    pub shear: [V; 3],
}

/// One ray along the axes of the sheared space: prepared, and its direction, which is not rounded.
#[derive(Clone, Copy, Debug)]
pub struct SingleRay {
    pub sheared: Sheared<f32>,
    pub dir: [f32; 3],
}

/// A ray with the axes of its sheared space.
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay {
    axes: [usize; 3],
    single: SingleRay,
}

/// The shear that maps a ray's direction, along the axes of the sheared space, to its z axis.
#[inline(always)]
pub fn shear<V: Number>([x, y, z]: [V; 3], one: V) -> [V; 3] {
    [x / z, y / z, one / z]
}

/// x, y and z of the sheared space, given its z.
#[inline(always)]
pub fn axes_from(z: usize) -> [usize; 3] {
    [(z + 1) % 3, (z + 2) % 3, z]
}

impl ShearedRay {
    /// `ray` must be valid and of regular length.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let axes = axes_from(ray.longest_axis());
        let [x, y, z] = axes;
        let dir = [ray.dir[x], ray.dir[y], ray.dir[z]];
        let sheared = Sheared { org: [ray.org[x], ray.org[y], ray.org[z]], shear: shear(dir, 1.0) };
        Self { axes, single: SingleRay { sheared, dir } }
    }

    /// Where the ray meets a triangle in `[t_near, t_far]`; or, unless one `needs_position`, whether it does by floats.
    #[inline(always)]
    pub fn meet(
        &self,
        [a, b, c]: &[[f32; 3]; 3],
        needs_position: bool,
        t_near: f32,
        t_far: f32,
    ) -> Option<TriangleHit> {
        let [x, y, z] = self.axes;
        let corners = [[a[x], a[y], a[z]], [b[x], b[y], b[z]], [c[x], c[y], c[z]]];
        self.single.meet(&corners, needs_position, t_near, t_far)
    }
}

impl SingleRay {
    /// As [`ShearedRay::meet`], of corners along the axes of the sheared space.
    #[inline(always)]
    pub(super) fn meet(
        &self,
        corners: &[[f32; 3]; 3],
        needs_position: bool,
        t_near: f32,
        t_far: f32,
    ) -> Option<TriangleHit> {
        let (Self { sheared: Sheared { org, shear }, dir }, [a, b, c]) = (*self, corners);
        let depth = [a[2] - org[2], b[2] - org[2], c[2] - org[2]];
        let px = sheared([a[0], b[0], c[0]], org[0], shear[0], depth);
        let py = sheared([a[1], b[1], c[1]], org[1], shear[1], depth);
        let w0 = px[2] * py[1] - py[2] * px[1];
        let w1 = px[0] * py[2] - py[0] * px[2];
        let w2 = px[1] * py[0] - py[1] * px[0];
        let (lowest, highest) = (least(least(w0, w1), w2), most(most(w0, w1), w2));
        if lowest < 0.0 && highest > 0.0 {
            return None;
        }
        let ts = [shear[2] * depth[0], shear[2] * depth[1], shear[2] * depth[2]];
        let (first, last) = (least(least(ts[0], ts[1]), ts[2]), most(most(ts[0], ts[1]), ts[2]));
        if last < t_near || first > t_far {
            return None;
        }
        let sum = w0 + w1 + w2;
        let size = sum.abs();
        let certain = least(least(w0.abs(), w1.abs()), w2.abs()) >= TINY && size <= HUGE;
        let exactly = || {
            let unrounded = Corners { corners: *corners, org, dir };
            meet_exactly(px, py, ts, &unrounded, t_near, t_far)
        };
        if !certain {
            return exactly();
        }

        let over = 1.0 / sum;
        let (u, v) = (w1 * over, w2 * over);
        let t = (w0 * over) * ts[0] + u * ts[1] + v * ts[2];
        let t = least(most(t, first), last) + 0.0;

        if needs_position {
            let (away, scale, long) = (t.abs(), shear[2].abs(), last - first);
            let widest = |p: [f32; 3]| most(most(p[0].abs(), p[1].abs()), p[2].abs());
            let wide = most(widest(px), widest(py));
            let doubt = long * (wide * (wide * scale + (away + long)));
            let per_t = size * scale;
            // Not so of NaN.
            let good = doubt < DOUBTFUL * (away * per_t);
            if !good {
                let off = SURELY * doubt;
                if (t_near - t) * per_t > off || (t - t_far) * per_t > off {
                    return None;
                }
                return exactly();
            }
        }
        (t >= t_near && t <= t_far).then_some(TriangleHit { t, u, v })
    }
}

impl SingleRay {
    /// As [`meet`](Self::meet) of a ray of which floats have decided that it passes inside.
    #[inline(always)]
    pub(super) fn meet_inside(
        &self,
        corners: &[[f32; 3]; 3],
        t_near: f32,
        t_far: f32,
    ) -> Option<TriangleHit> {
        let (Self { sheared: Sheared { org, shear }, dir }, [a, b, c]) = (*self, corners);
        let Some(met) = precise::meet(&Corners { corners: *corners, org, dir }) else {
            return self.meet(corners, true, t_near, t_far);
        };
        let ts = [shear[2] * (a[2] - org[2]), shear[2] * (b[2] - org[2]), shear[2] * (c[2] - org[2])];
        met.within(ts, t_near, t_far)
    }
}

impl Weighed {
    /// In floats, between the corners' own parameters; if that is within reach.
    #[inline(always)]
    fn within(self, ts: [f32; 3], t_near: f32, t_far: f32) -> Option<TriangleHit> {
        let (first, last) = (least(least(ts[0], ts[1]), ts[2]), most(most(ts[0], ts[1]), ts[2]));
        // The addition of zero converts -0.0 to 0.0.
        let t = least(most(self.t as f32, first), last) + 0.0;
        let (u, v) = ((self.u + 0.0) as f32, (self.v + 0.0) as f32);
        (t >= t_near && t <= t_far).then_some(TriangleHit { t, u, v })
    }
}

#[inline(always)]
fn sheared(corners: [f32; 3], org: f32, shear: f32, depth: [f32; 3]) -> [f32; 3] {
    let [a, b, c] = corners;
    [a - org - shear * depth[0], b - org - shear * depth[1], c - org - shear * depth[2]]
}

/// The same decision in double precision, from the sheared corners and their ray parameters; the hit is
/// computed from unrounded input. NaN misses.
#[cold]
#[inline(never)]
pub(super) fn meet_exactly(
    px: [f32; 3],
    py: [f32; 3],
    ts: [f32; 3],
    unrounded: &Corners,
    t_near: f32,
    t_far: f32,
) -> Option<TriangleHit> {
    let (px, py) = (px.map(f64::from), py.map(f64::from));
    let weight = |b: usize, c: usize| px[c] * py[b] - py[c] * px[b];
    let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
    let one_sided = weights.iter().all(|&w| w >= 0.0) || weights.iter().all(|&w| w <= 0.0);
    let sum: f64 = weights.iter().sum();
    if !one_sided || sum == 0.0 {
        return None;
    }
    let met = precise::meet(unrounded).unwrap_or_else(|| {
        // The triangle is seen edge on: as rounding has it.
        let [a, u, v] = weights.map(|w| w / sum);
        Weighed { t: a * f64::from(ts[0]) + u * f64::from(ts[1]) + v * f64::from(ts[2]), u, v }
    });
    met.within(ts, t_near, t_far)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Signed volumes in double precision; `None` too where the ray passes closer than `margin` to an edge.
    fn oracle(ray: &Ray, corners: &[[f32; 3]; 3], margin: f64) -> (bool, bool) {
        let dir = ray.dir.map(f64::from);
        let rel = corners.map(|c| [0, 1, 2].map(|k| f64::from(c[k]) - f64::from(ray.org[k])));
        let volume = |p: [f64; 3], q: [f64; 3]| {
            dir[0] * (p[1] * q[2] - p[2] * q[1])
                + dir[1] * (p[2] * q[0] - p[0] * q[2])
                + dir[2] * (p[0] * q[1] - p[1] * q[0])
        };
        let w = [volume(rel[1], rel[2]), volume(rel[2], rel[0]), volume(rel[0], rel[1])];
        let size: f64 = w.iter().map(|w| w.abs()).sum();
        let inside = w.iter().all(|&w| w > 0.0) || w.iter().all(|&w| w < 0.0);
        (inside, w.iter().any(|w| w.abs() < margin * size))
    }

    #[test]
    fn agrees_with_double_precision() {
        let mut state = 7u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut point = || [0; 3].map(|_: i32| random());
        let (mut hits, mut clear) = (0, 0);
        for _ in 0..20_000 {
            let corners = [point(), point(), point()];
            let ray = Ray::new(point(), point()).within(f32::NEG_INFINITY, f32::INFINITY);
            let met = ShearedRay::new(&ray).meet(&corners, true, f32::NEG_INFINITY, f32::INFINITY);
            let (inside, close) = oracle(&ray, &corners, 1e-5);
            if !close {
                clear += 1;
                assert_eq!(met.is_some(), inside, "{ray:?} against {corners:?}");
            }
            if let Some(TriangleHit { t, u, v }) = met.filter(|m| !close && m.t.abs() < 10.0) {
                hits += 1;
                let on_ray = ray.at(t);
                for k in 0..3 {
                    let on_triangle = (1.0 - u - v) * corners[0][k] + u * corners[1][k] + v * corners[2][k];
                    assert!((on_ray[k] - on_triangle).abs() < 2e-4, "{on_ray:?}[{k}] is on {corners:?}");
                }
            }
        }
        assert!(clear > 19_000 && hits > 1_000, "{clear} clear cases and {hits} hits are enough to tell");
    }

    #[test]
    fn tiny_and_huge_triangles_are_hit() {
        for size in [1e-36f32, 1e-30, 1e-20, 1.0, 1e10, 1e18] {
            let corners = [[0.0, 0.0, size], [size, 0.0, size], [0.0, size, size]];
            let ray = Ray::new([size / 4.0, size / 4.0, 0.0], [0.0, 0.0, 1.0]);
            let met = ShearedRay::new(&ray).meet(&corners, true, 0.0, f32::INFINITY);
            assert_eq!(met, Some(TriangleHit { t: size, u: 0.25, v: 0.25 }), "a triangle of size {size:e}");
        }
    }
}
