// SPDX-License-Identifier: GPL-3.0-or-later
//! A point of a surface and the rays that leave it without meeting it again.
//! Source: [PJH23] section 6.8 (origins off the surface by the point's error); [Hanika2021] (`lift`). Space: world.
//! Proof: crates/render/tests/{offsets,terminator}.rs.

use glam::Vec3;
use gnurt_accel::Ray;

/// What rays that leave a point need to know of it.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Where it is.
    pub p: Vec3,
    /// How far it may be off its surface by rounding, world units.
    pub error: f32,
    /// Unit geometric normal on the side that the first ray came from.
    pub ng: Vec3,
    /// Unit shading normal on the side of `ng`.
    pub ns: Vec3,
    /// From the point to the curved surface that the vertex normals suggest; zero where there is none.
    pub lift: Vec3,
}

impl SurfacePoint {
    /// A ray towards `dir` that will not meet the surface it leaves: its origin is off the surface by the point's error,
    /// on the side that `dir` points to.
    #[must_use]
    pub fn spawn(&self, dir: Vec3, t_far: f32) -> Ray {
        Ray::new(off_surface(self.p, self.ng, dir, self.error).into(), dir.into()).within(0.0, t_far)
    }

    /// A ray that ends at `dist` along the unit direction `dir`, seen from the point itself: what
    /// [`LightBatch`](crate::LightBatch) gives. Its origin is off the surface, and it ends as much before the light: that
    /// may lie on a surface, which must not shadow it.
    #[must_use]
    pub fn spawn_to(&self, dir: Vec3, dist: f32) -> Ray {
        ray_between(self.p, off_surface(self.p, self.ng, dir, self.error), dir, dist, self.error)
    }

    /// The ray that decides whether light from the unit direction `dir`, `dist` away, reaches the point; `None` where
    /// `dir` lies below the horizon. Where the mesh stands for a curved surface, the horizon is that of the shading normal
    /// and the ray starts there \[Hanika2021\]; elsewhere both normals must see the light.
    #[must_use]
    pub fn shadow_ray(&self, dir: Vec3, dist: f32) -> Option<Ray> {
        if self.ns.dot(dir) <= 0.0 {
            return None;
        }
        if self.lift == Vec3::ZERO {
            return (self.ng.dot(dir) > 0.0).then(|| self.spawn_to(dir, dist));
        }
        // Off to the side of the viewer, even where `dir` points below the facet.
        let from = off_surface(self.p + self.lift, self.ng, self.ng, self.error);
        Some(ray_between(self.p, from, dir, dist, self.error))
    }
}

/// How far rounding may move the end of a ray, as a multiple of its length.
const END_ERROR: f32 = 8.0 * f32::EPSILON;

/// The ray from `from` to what is seen from `p` along `dir`, `dist` away; it stops short by `error` and its rounding.
fn ray_between(p: Vec3, from: Vec3, dir: Vec3, dist: f32, error: f32) -> Ray {
    if dist.is_infinite() {
        return Ray::new(from.into(), dir.into()).within(0.0, dist);
    }
    let way = p + dir * dist - from;
    let length = way.length();
    let dir = if length > 0.0 { way / length } else { dir };
    let end = length * (1.0 - END_ERROR) - error;
    Ray::new(from.into(), dir.into()).within(0.0, end.max(0.0))
}

/// Moves `p` along `normal` by `error`, to the side that `dir` points to, and then away from it by one float more in
/// each coordinate: adding a small number to a large one may have moved nothing.
fn off_surface(p: Vec3, normal: Vec3, dir: Vec3, error: f32) -> Vec3 {
    let offset = if normal.dot(dir) < 0.0 { -normal * error } else { normal * error };
    let step = |x: f32, d: f32| match d {
        d if d > 0.0 => (x + d).next_up(),
        d if d < 0.0 => (x + d).next_down(),
        _ => x,
    };
    Vec3::new(step(p.x, offset.x), step(p.y, offset.y), step(p.z, offset.z))
}
