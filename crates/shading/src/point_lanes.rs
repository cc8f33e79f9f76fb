// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays that leave sixteen flat points, each upwards from its own.
//! Source: as `point`. Space: world.
//! Invariant: the rays of [`SurfacePoint`](crate::SurfacePoint), bit for bit, where both normals are one, `lift` is zero
//! and directions lie above.
//! Proof: `tests::the_same_rays`.

use gnurt_simd::{Simd, f32x16, prelude::*, u32x16};

use crate::lanes::{Floats, Vec3x16, Words, select3};
use crate::point::END_ERROR;

/// Rays in lanes; near ends are zero.
#[derive(Clone, Copy, Debug)]
pub struct RayX16<S: Simd> {
    /// Origins.
    pub org: Vec3x16<S>,
    /// Unit directions.
    pub dir: Vec3x16<S>,
    /// Far ends.
    pub t_far: Floats<S>,
}

/// Where rays start that leave `p` to the side of the unit `normal`; `error` is how far `p` may be off its surface.
#[inline(always)]
pub fn above_x16<S: Simd>(p: Vec3x16<S>, normal: Vec3x16<S>, error: Floats<S>) -> Vec3x16<S> {
    let offset = normal * error;
    Vec3x16::new(moved(p.x, offset.x), moved(p.y, offset.y), moved(p.z, offset.z))
}

/// `x + d` and one float more.
#[inline(always)]
fn moved<S: Simd>(x: Floats<S>, d: Floats<S>) -> Floats<S> {
    let zero = f32x16::splat(x.token(), 0.0);
    let moved = x + d;
    let (up, down) = (next(moved, false), next(moved, true));
    d.simd_gt(zero).select(up, d.simd_lt(zero).select(down, x))
}

/// The ray that decides whether light from the unit direction `dir`, `dist` away, reaches `p`; it starts at `org`.
#[inline(always)]
pub fn shadow_ray_x16<S: Simd>(
    p: Vec3x16<S>,
    org: Vec3x16<S>,
    dir: Vec3x16<S>,
    dist: Floats<S>,
    error: Floats<S>,
) -> RayX16<S> {
    let zero = f32x16::splat(dist.token(), 0.0);
    let far = dist.is_infinite();
    let way = p + dir * dist - org;
    let length = way.length_squared().sqrt();
    let long = length.simd_gt(zero);
    let towards = select3(long, way.over(length), dir);
    let end = (length * (1.0 - END_ERROR) - error).max(zero);
    RayX16 { org, dir: select3(far, dir, towards), t_far: far.select(dist, end) }
}

/// The float after a finite one, or the one before if `down`.
#[inline(always)]
fn next<S: Simd>(x: Floats<S>, down: bool) -> Floats<S> {
    let simd = x.token();
    let bits: Words<S> = x.bitcast();
    let zero = f32x16::splat(simd, 0.0);
    let away = if down { x.simd_lt(zero) } else { x.simd_gt(zero) };
    let stepped = away.select(bits + 1, bits - 1);
    // From zero, to the smallest float of the sign.
    let least = u32x16::splat(simd, if down { 0x8000_0001 } else { 1 });
    x.simd_eq(zero).select(least, stepped).bitcast()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SampleKey;
    use crate::SurfacePoint;
    use crate::lanes::LANES;
    use crate::sampling::{Basis, cosine_hemisphere, sample_pair, uniform_sphere};
    use glam::Vec3;
    use gnurt_accel::Ray;
    use gnurt_simd::{Level, dispatch_wide};

    #[inline(always)]
    fn in_lanes<S: Simd>(simd: S, points: &[(SurfacePoint, Vec3, f32); LANES]) -> [(Vec3, Ray); LANES] {
        let floats = |f: &dyn Fn(usize) -> f32| f32x16::from_fn(simd, f);
        let vectors = |f: &dyn Fn(usize) -> Vec3| {
            let [x, y, z] = [0, 1, 2].map(|k| floats(&|i| f(i)[k]));
            Vec3x16::new(x, y, z)
        };
        let (p, n) = (vectors(&|i| points[i].0.p), vectors(&|i| points[i].0.ng));
        let (dir, dist) = (vectors(&|i| points[i].1), floats(&|i| points[i].2));
        let error = floats(&|i| points[i].0.error);
        let org = above_x16(p, n, error);
        let shadow = shadow_ray_x16(p, org, dir, dist, error);
        std::array::from_fn(|i| {
            let ray = Ray::new(shadow.org.get(i).into(), shadow.dir.get(i).into());
            (org.get(i), ray.within(0.0, shadow.t_far[i]))
        })
    }

    #[test]
    fn the_same_rays() {
        for round in 0..400 {
            let points = std::array::from_fn(|i| {
                let draw = |n| sample_pair(4, SampleKey { pixel: round, sample: i as u32, branch: 0 }, 0, n);
                let axis = [Vec3::X, -Vec3::Y, Vec3::Z][i % 3];
                let n = if i < 4 { axis } else { uniform_sphere(draw(1)) };
                let scale = 10.0_f32.powi(i as i32 % 7 - 3);
                let p = if i == 9 { Vec3::ZERO } else { uniform_sphere(draw(2)) * scale };
                let dir = Basis::around(n).to_world(cosine_hemisphere(draw(3))).normalize();
                let dist = [f32::INFINITY, 0.0, 1e-6, draw(5)[0] * 10.0][(i + round as usize) % 4];
                let error = if i == 12 { 0.0 } else { 8.0 * f32::EPSILON * scale };
                (SurfacePoint { p, error, ng: n, ns: n, lift: Vec3::ZERO }, dir, dist)
            });
            let found = dispatch_wide!(Level::default(), simd => in_lanes(simd, &points), else return);
            for ((point, dir, dist), (org, shadow)) in points.into_iter().zip(found) {
                let Some(ray) = point.scatter_ray(dir, false, 1.0) else { continue };
                assert_eq!(Vec3::from(ray.org), org, "{point:?} towards {dir}");
                assert_eq!(point.shadow_ray(dir, dist), Some(shadow), "{point:?} towards {dir}, {dist} away");
            }
        }
    }
}
