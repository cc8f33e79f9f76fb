// SPDX-License-Identifier: GPL-3.0-or-later
//! A point of a surface and the rays that leave it without meeting it again.
//! Source: [PJH23] section 6.8 (origins off the surface by the point's error); [Hanika2021] (`lift`); [KWR*17] (normals
//! bent until mirror images stay above). Space: world.
//! Horizon: light and scattered rays obey one rule, so that the two ways to meet a light agree. On the side that the
//! path came from, a direction must be above the shading normal's horizon and, where the mesh is flat or hollow, above
//! the facet's; through the surface it must be below both.
//! Sixteen at once: `point_lanes`.
//! Proof: `tests`, crates/render/tests/{offsets,terminator}.rs.

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
        let from = self.origin_towards(dir, false)?;
        Some(ray_between(self.p, from, dir, dist, self.error))
    }

    /// The same for light that arrives through the surface, from the side that the path did not come from.
    #[must_use]
    pub fn shadow_ray_through(&self, dir: Vec3, dist: f32) -> Option<Ray> {
        let from = self.origin_towards(dir, true)?;
        Some(ray_between(self.p, from, dir, dist, self.error))
    }

    /// The ray on which a path goes on in the unit direction `dir` that a BSDF chose, `transmitted` or not; `None` where
    /// light samples from there would bring nothing, either.
    #[must_use]
    pub fn scatter_ray(&self, dir: Vec3, transmitted: bool, t_far: f32) -> Option<Ray> {
        let from = self.origin_towards(dir, transmitted)?;
        Some(Ray::new(from.into(), dir.into()).within(0.0, t_far))
    }

    /// Whether [`scatter_ray`](Self::scatter_ray) gives a ray; `dir` may have any length.
    #[must_use]
    pub fn scatters_to(&self, dir: Vec3, transmitted: bool) -> bool {
        let (above_ns, above_ng) = (self.ns.dot(dir), self.ng.dot(dir));
        if transmitted {
            above_ns < 0.0 && above_ng < 0.0
        } else {
            above_ns > 0.0 && (above_ng > 0.0 || self.lift != Vec3::ZERO)
        }
    }

    /// Where rays towards `dir` start; `None` below the horizon.
    fn origin_towards(&self, dir: Vec3, transmitted: bool) -> Option<Vec3> {
        if !self.scatters_to(dir, transmitted) {
            return None;
        }
        if transmitted || self.lift == Vec3::ZERO {
            return Some(off_surface(self.p, self.ng, dir, self.error));
        }
        // Off to the side of the viewer, even where `dir` points below the facet.
        Some(off_surface(self.p + self.lift, self.ng, self.ng, self.error))
    }

    /// The unit normal `ns`, bent as little as it takes that a ray from `wo` (unit, above `ng`) sees it from the front
    /// and its mirror image leaves above the horizon: so that shiny surfaces are not black at their edges.
    #[must_use]
    pub fn bent_normal(&self, ns: Vec3, wo: Vec3) -> Vec3 {
        // Mirror images must clear both normals where both count.
        let horizons = [Some(self.ns), (self.lift == Vec3::ZERO).then_some(self.ng)];
        let mut bent = ns;
        for up in horizons.into_iter().flatten() {
            let mirrored = (-wo).reflect(bent);
            if bent.dot(wo) > 0.0 && mirrored.dot(up) >= LOWEST_MIRROR_IMAGE {
                continue;
            }
            let raised = mirrored + up * (2.0 * LOWEST_MIRROR_IMAGE - mirrored.dot(up)).max(0.0);
            let half = raised.try_normalize().and_then(|raised| (wo + raised).try_normalize());
            bent = half.filter(|half| half.dot(wo) > 0.0).unwrap_or(self.ng);
        }
        bent
    }
}

/// Cosine to the horizon's normal below which mirror images are raised.
const LOWEST_MIRROR_IMAGE: f32 = 1e-3;

/// How far rounding may move the end of a ray, as a multiple of its length.
pub(crate) const END_ERROR: f32 = 8.0 * f32::EPSILON;

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

#[cfg(test)]
mod tests {
    use super::*;

    fn point(ns: Vec3, lift: Vec3) -> SurfacePoint {
        SurfacePoint { p: Vec3::ZERO, error: 1e-6, ng: Vec3::Z, ns, lift }
    }

    #[test]
    fn scattered_rays_and_light_samples_share_their_horizon() {
        let tilted = Vec3::new(0.6, 0.0, 0.8);
        for (ns, lift) in [(Vec3::Z, Vec3::ZERO), (tilted, Vec3::ZERO), (tilted, tilted * 0.1)] {
            let point = point(ns, lift);
            for k in 0..200 {
                let (z, azimuth) = (k as f32 / 100.0 - 0.995, k as f32 * 2.4);
                let r = (1.0 - z * z).sqrt();
                let dir = Vec3::new(r * azimuth.cos(), r * azimuth.sin(), z);
                let (ray, shadow) =
                    (point.scatter_ray(dir, false, 1.0), point.shadow_ray(dir, f32::INFINITY));
                assert_eq!(ray.map(|r| r.org), shadow.map(|r| r.org), "mirrored to {dir}");
                let (ray, shadow) =
                    (point.scatter_ray(dir, true, 1.0), point.shadow_ray_through(dir, f32::INFINITY));
                assert_eq!(ray.map(|r| r.org), shadow.map(|r| r.org), "through to {dir}");
                assert!(ray.is_none() || dir.z < 0.0, "through means below: {dir}");
            }
        }
    }

    #[test]
    fn bent_normals_keep_mirror_images_above() {
        for k in 0..2000_u32 {
            let turn = |n: u32, by: f32| ((k * n) as f32 * by).fract();
            let unit = |z: f32, azimuth: f32| {
                let r = (1.0 - z * z).sqrt();
                Vec3::new(r * azimuth.cos(), r * azimuth.sin(), z)
            };
            let wo = unit(0.002 + 0.99 * turn(1, 0.618_034), 0.0);
            let mesh = unit(0.3 + 0.7 * turn(3, 0.754_877_7), 7.0 * turn(5, 0.569_840_3));
            let mapped = unit(0.2 + 0.8 * turn(7, 0.819_172_5), 7.0 * turn(11, 0.671_043_6));
            let lift = if k % 2 == 0 { Vec3::ZERO } else { mesh * 0.1 };
            let point = point(mesh, lift);
            let bent = point.bent_normal(mapped, wo);
            let mirrored = (-wo).reflect(bent);
            assert!((bent.length() - 1.0).abs() < 1e-5 && bent.dot(wo) > 0.0, "seen from the front");
            let leaves = point.scatter_ray(mirrored, false, 1.0).is_some();
            // Two horizons far apart can leave no room between them.
            assert!(leaves || bent == Vec3::Z, "{k}: wo {wo}, mesh {mesh}, mapped {mapped}: {mirrored}");
            let fine = (-wo).reflect(mapped);
            if mapped.dot(wo) > 0.0 && fine.dot(mesh) > 0.002 && fine.z > 0.002 {
                assert_eq!(bent, mapped, "nothing is bent without need");
            }
        }
    }
}
