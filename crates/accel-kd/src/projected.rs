// SPDX-License-Identifier: GPL-3.0-or-later
//! Badouel's test on triangles projected beforehand to the plane of two axes.
//! Source: [Bad90] as in [Wal04] section 7.1. Differs: distances are taken from the first corner instead of the origin
//! of space, which costs nothing and keeps precision far from it.
//! Bound: corners and planes are rounded, so rays may pass between neighbours; a direction in the triangle's plane
//! gives NaN or infinity and misses. Tests: `tests::precise_on_plain_triangles`, `tests/brute_force.rs`.

mod store;

use gnurt_simd::{Simd, f32x8, mask32x8, prelude::*};

use gnurt_accel_core::Ray;
use gnurt_accel_core::triangle::TriangleHit;

use crate::packet_rays::{HitPacket, RayPacket};

/// 40 bytes of one triangle. With `n` its normal, `k` the axis where `n` is longest and `i`, `j` the next ones.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Projected {
    k: u32,
    /// First corner along `i`, `j` and `k`.
    corner: [f32; 3],
    /// `n[i] / n[k]` and `n[j] / n[k]`.
    normal: [f32; 2],
    /// Weight of the second corner per unit along `i` and `j`.
    second: [f32; 2],
    /// Weight of the third corner.
    third: [f32; 2],
}

/// Projected triangles by number; those of dropped ones are never read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ProjectedTriangles {
    triangles: Vec<Projected>,
}

impl Projected {
    fn new([a, b, c]: &[[f32; 3]; 3]) -> Self {
        let edge = |p: &[f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k]));
        let (b, c) = (edge(b), edge(c));
        let n = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let k = (0..3).fold(0, |most, k| if n[k].abs() > n[most].abs() { k } else { most });
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        // The placeholder of a dropped triangle has no normal, but equals itself.
        let over = if n[k] == 0.0 { 0.0 } else { 1.0 / n[k] };
        Self {
            k: k as u32,
            corner: [a[i], a[j], a[k]],
            normal: [(n[i] * over) as f32, (n[j] * over) as f32],
            second: [(c[j] * over) as f32, (-c[i] * over) as f32],
            third: [(-b[j] * over) as f32, (b[i] * over) as f32],
        }
    }
}

impl ProjectedTriangles {
    /// From the corners of each triangle by number.
    pub(crate) fn new(corners: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        Self { triangles: corners.map(|corners| Projected::new(&corners)).collect() }
    }

    /// Of one.
    pub(crate) const BYTES: usize = size_of::<Projected>();

    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.triangles[..])
    }

    /// The corners of triangle `number`, as well as they are known.
    pub(crate) fn corners(&self, number: u32) -> [[f64; 3]; 3] {
        let Projected { k, corner, normal, second, third } = self.triangles[number as usize];
        let (corner, normal) = (corner.map(f64::from), normal.map(f64::from));
        let (second, third) = (second.map(f64::from), third.map(f64::from));
        // The products of weights (1, 0) and (0, 1) along `i` and `j`; the normal gives the third component.
        let over = 1.0 / (second[0] * third[1] - second[1] * third[0]);
        let edges = [[0.0; 2], [third[1] * over, -third[0] * over], [-second[1] * over, second[0] * over]];
        edges.map(|[pi, pj]| {
            let mut p = [0.0; 3];
            let k = k as usize;
            (p[(k + 1) % 3], p[(k + 2) % 3]) = (corner[0] + pi, corner[1] + pj);
            p[k] = corner[2] - normal[0] * pi - normal[1] * pj;
            p
        })
    }

    /// Where `ray` meets triangle `number` in `[t_near, t_far]`.
    #[inline(always)]
    pub(crate) fn meet(&self, number: u32, ray: &Ray, t_near: f32, t_far: f32) -> Option<TriangleHit> {
        let Projected { k, corner, normal, second, third } = self.triangles[number as usize];
        let k = k as usize;
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (org, dir) = (&ray.org, &ray.dir);

        let from = [corner[0] - org[i], corner[1] - org[j], corner[2] - org[k]];
        let t = (from[2] + normal[0] * from[0] + normal[1] * from[1])
            / (dir[k] + normal[0] * dir[i] + normal[1] * dir[j])
            + 0.0;
        let (pi, pj) = (t * dir[i] - from[0], t * dir[j] - from[1]);
        let u = pi * second[0] + pj * second[1];
        let v = pi * third[0] + pj * third[1];
        let hit = t >= t_near && t <= t_far && u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        hit.then_some(TriangleHit { t, u, v })
    }

    /// The same in lanes, for those in `active`.
    #[inline(always)]
    pub(crate) fn meet_packet<S: Simd>(
        &self,
        simd: S,
        number: u32,
        rays: &RayPacket<S>,
        active: mask32x8<S>,
        t_near: f32x8<S>,
        t_far: f32x8<S>,
    ) -> HitPacket<S> {
        let Projected { k, corner, normal, second, third } = self.triangles[number as usize];
        let k = k as usize;
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let at = |value: f32| f32x8::splat(simd, value);
        let (org, dir) = (&rays.org, &rays.dir);

        let from = [at(corner[0]) - org[i], at(corner[1]) - org[j], at(corner[2]) - org[k]];
        let t = (from[2] + at(normal[0]) * from[0] + at(normal[1]) * from[1])
            / (dir[k] + at(normal[0]) * dir[i] + at(normal[1]) * dir[j])
            + at(0.0);
        let (pi, pj) = (t * dir[i] - from[0], t * dir[j] - from[1]);
        let u = pi * at(second[0]) + pj * at(second[1]);
        let v = pi * at(third[0]) + pj * at(third[1]);
        let reached = t.simd_ge(t_near) & t.simd_le(t_far);
        let inside = u.simd_ge(at(0.0)) & v.simd_ge(at(0.0)) & (u + v).simd_le(at(1.0));
        HitPacket { t, u, v, hit: active & reached & inside }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn precise_on_plain_triangles() {
        for offset in [0.0f32, 1000.0] {
            let corners = [[0.0, 0.0, 4.0], [2.0, 0.0, 4.0], [0.0, 2.0, 6.0]].map(|p| p.map(|x| x + offset));
            let triangles = ProjectedTriangles::new([corners].into_iter());
            assert_eq!(triangles.corners(0), corners.map(|p| p.map(f64::from)), "corners come back");
            let ray = Ray::new([0.5, 1.0, 0.0].map(|x| x + offset), [0.0, 0.0, 2.0]);
            let met = triangles.meet(0, &ray, 0.0, f32::INFINITY);
            assert_eq!(met, Some(TriangleHit { t: 2.5, u: 0.25, v: 0.5 }), "moved by {offset}");
            let outside = Ray::new([1.5 + offset, 1.0 + offset, offset], [0.0, 0.0, 2.0]);
            assert_eq!(triangles.meet(0, &outside, 0.0, f32::INFINITY), None, "beside it");
            let along = Ray::new([offset; 3], [1.0, 0.0, 0.0]);
            assert_eq!(triangles.meet(0, &along, 0.0, f32::INFINITY), None, "in a parallel plane");
        }
    }
}
