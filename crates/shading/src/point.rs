// SPDX-License-Identifier: GPL-3.0-or-later
//! A point of a surface and the rays that leave it without meeting it again.
//! Source: [PJH23] section 6.8 (origins off the surface by the point's error); [Hanika2021] (`lift`); [KWR*17] (normals
//! bent until mirror images stay above). Space: world.
//! Horizon: light and scattered rays obey one rule, so that both strategies find the same light. On the side
//! that the path came from, a direction must be above the shading normal's horizon and, where the mesh is
//! flat or hollow, above the facet's; through the surface it must be below both. Written once for one point
//! and for sixteen.
//! Tests: `tests`, crates/render/tests/{offsets,terminator}.rs.

use glam::Vec3;
use gnurt_accel::Ray;

use crate::real::{Real, Vector};

/// The data of a point for rays that leave it.
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

/// The same of many points.
#[derive(Clone, Copy, Debug)]
pub struct Leaving<R> {
    /// Where they are.
    pub p: Vector<R>,
    /// How far they may be off.
    pub error: R,
    /// Geometric normals.
    pub ng: Vector<R>,
    /// Shading normals.
    pub ns: Vector<R>,
    /// To the curved surfaces.
    pub lift: Vector<R>,
}

/// Rays of many points; near ends are zero.
#[derive(Clone, Copy, Debug)]
pub struct Rays<R> {
    /// Origins.
    pub org: Vector<R>,
    /// Unit directions.
    pub dir: Vector<R>,
    /// Far ends.
    pub t_far: R,
}

impl Rays<f32> {
    fn ray(self) -> Ray {
        let [org, dir] = [self.org, self.dir].map(|v| Vec3::from(v).into());
        Ray::new(org, dir).within(0.0, self.t_far)
    }
}

impl<R: Real> Leaving<R> {
    /// See [`SurfacePoint::scatters_to`].
    #[inline(always)]
    pub fn scatters_to(&self, dir: Vector<R>, transmitted: R::Mask) -> R::Mask {
        let zero = self.error.all(0.0);
        let (above_ns, above_ng) = (self.ns.dot(dir), self.ng.dot(dir));
        let below_both = zero.above(above_ns) & zero.above(above_ng);
        let above = above_ns.above(zero) & (above_ng.above(zero) | !self.lift.is_zero());
        (transmitted & below_both) | (!transmitted & above)
    }

    /// Where rays towards `dir` start, where they may.
    #[inline(always)]
    fn origins(&self, dir: Vector<R>, transmitted: R::Mask) -> Vector<R> {
        let up = self.ng.dot(dir);
        let below = self.error.all(0.0).above(up);
        // Off to the side of the viewer, even if `dir` points below the face.
        let raised = !(transmitted | self.lift.is_zero());
        let p = Vector::pick(raised, self.p + self.lift, self.p);
        off_surface(p, self.ng, below & !raised, self.error)
    }

    /// See [`SurfacePoint::scatter_ray`]; the points that send one.
    #[inline(always)]
    pub fn scatter_rays(&self, dir: Vector<R>, transmitted: R::Mask) -> (Rays<R>, R::Mask) {
        let rays = Rays { org: self.origins(dir, transmitted), dir, t_far: self.error.all(f32::INFINITY) };
        (rays, self.scatters_to(dir, transmitted))
    }

    /// See [`SurfacePoint::shadow_ray`]; the points that send one.
    #[inline(always)]
    pub fn shadow_rays(&self, dir: Vector<R>, dist: R, transmitted: R::Mask) -> (Rays<R>, R::Mask) {
        let from = self.origins(dir, transmitted);
        (rays_joining(self.p, from, dir, dist, self.error), self.scatters_to(dir, transmitted))
    }
}

impl SurfacePoint {
    fn leaving(&self) -> Leaving<f32> {
        let Self { p, error, ng, ns, lift } = *self;
        Leaving { p: p.into(), error, ng: ng.into(), ns: ns.into(), lift: lift.into() }
    }

    fn off_surface(&self, dir: Vec3) -> Vector<f32> {
        off_surface(self.p.into(), self.ng.into(), self.ng.dot(dir) < 0.0, self.error)
    }

    /// A ray towards `dir` that will not meet the surface it leaves: its origin is off the surface by the point's error,
    /// on the side that `dir` points to.
    #[must_use]
    pub fn spawn(&self, dir: Vec3, t_far: f32) -> Ray {
        Rays { org: self.off_surface(dir), dir: dir.into(), t_far }.ray()
    }

    /// A ray that ends at `dist` along the unit direction `dir`, both measured from the point itself, as
    /// [`LightBatch`](crate::LightBatch) gives them. Its origin is off the surface, and it ends at the same
    /// distance before the light, because a surface of the light must not shadow it.
    #[must_use]
    pub fn spawn_to(&self, dir: Vec3, dist: f32) -> Ray {
        rays_joining(self.p.into(), self.off_surface(dir), dir.into(), dist, self.error).ray()
    }

    /// The ray that decides whether light from the unit direction `dir`, `dist` away, reaches the point; `None` where
    /// `dir` lies below the horizon. If the mesh approximates a curved surface, the horizon is that of the
    /// shading normal and the ray starts there \[Hanika2021\]; elsewhere both normals must face the light.
    /// Light that is `transmitted` arrives through the surface, from the side that the path did not come
    /// from.
    #[must_use]
    pub fn shadow_ray(&self, dir: Vec3, dist: f32, transmitted: bool) -> Option<Ray> {
        let (ray, some) = self.leaving().shadow_rays(dir.into(), dist, transmitted);
        some.then(|| ray.ray())
    }

    /// The ray of a path in the unit direction `dir` that a BSDF chose, `transmitted` or not; `None` where
    /// light samples from there would bring nothing, either.
    #[must_use]
    pub fn scatter_ray(&self, dir: Vec3, transmitted: bool, t_far: f32) -> Option<Ray> {
        let (ray, some) = self.leaving().scatter_rays(dir.into(), transmitted);
        some.then(|| Rays { t_far, ..ray }.ray())
    }

    /// Whether [`scatter_ray`](Self::scatter_ray) gives a ray; `dir` may have any length.
    #[must_use]
    pub fn scatters_to(&self, dir: Vec3, transmitted: bool) -> bool {
        self.leaving().scatters_to(dir.into(), transmitted)
    }

    /// The unit normal `ns`, bent by the least angle at which a ray from `wo` (unit, above `ng`) sees its
    /// front and the mirror reflection leaves above the horizon: so that shiny surfaces are not black at
    /// their edges.
    #[must_use]
    pub fn bent_normal(&self, ns: Vec3, wo: Vec3) -> Vec3 {
        // Mirror images must clear both normals where both count.
        let horizons = [Some(self.ns), (self.lift == Vec3::ZERO).then_some(self.ng)];
        // A normal that faces away is tilted towards the ray until it is edge-on.
        let away = ns.dot(wo).min(0.0);
        let mut bent =
            if away < 0.0 { (ns - wo * (away - LOWEST_MIRROR_IMAGE)).normalize_or(self.ng) } else { ns };
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

/// Points whose unit normals [`SurfacePoint::bent_normal`] leaves as they are; those of the mesh that count are `ns`, and `ng` where it is
/// flat.
#[inline(always)]
pub(crate) fn is_unbent<R: Real>(
    n: Vector<R>,
    wo: Vector<R>,
    ns: Vector<R>,
    ng: Vector<R>,
    is_flat: R::Mask,
) -> R::Mask {
    let least = n.x.all(LOWEST_MIRROR_IMAGE);
    let ray = -wo;
    let mirrored = ray - n * (ray.dot(n) * 2.0);
    let (over_ns, over_ng) = (mirrored.dot(ns), mirrored.dot(ng));
    let clears_ng = over_ng.above(least) | over_ng.is(least) | !is_flat;
    n.dot(wo).above_all(0.0) & (over_ns.above(least) | over_ns.is(least)) & clears_ng
}

/// Cosine to the horizon's normal below which mirror images are raised.
const LOWEST_MIRROR_IMAGE: f32 = 1e-3;

/// How far rounding may move the end of a ray, as a multiple of its length.
const END_ERROR: f32 = 8.0 * f32::EPSILON;

/// The rays from `from` to the points at distance `dist` from `p` along `dir`; they stop short by `error` and
/// their rounding.
#[inline(always)]
fn rays_joining<R: Real>(p: Vector<R>, from: Vector<R>, dir: Vector<R>, dist: R, error: R) -> Rays<R> {
    let zero = dist.all(0.0);
    let near = dist.is_number();
    let to_point = p + dir * dist - from;
    let length = to_point.length_squared().root();
    let towards = Vector::pick(length.above(zero) & near, to_point.over(length), dir);
    let end = (length * (1.0 - END_ERROR) - error).or_more(zero);
    Rays { org: from, dir: towards, t_far: R::pick(near, end, dist) }
}

/// Moves `p` along `normal` by `error`, or against it where `below`, and then away from it by one float more in
/// each coordinate: adding a small number to a large one may have moved nothing.
#[inline(always)]
fn off_surface<R: Real>(p: Vector<R>, normal: Vector<R>, below: R::Mask, error: R) -> Vector<R> {
    let offset = Vector::pick(below, -normal * error, normal * error);
    p.with(
        offset,
        #[inline(always)]
        |x, d| {
            let (zero, moved) = (x.all(0.0), x + d);
            R::pick(d.above(zero), moved.next_up(), R::pick(zero.above(d), moved.next_down(), x))
        },
    )
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
                    (point.scatter_ray(dir, false, 1.0), point.shadow_ray(dir, f32::INFINITY, false));
                assert_eq!(ray.map(|r| r.org), shadow.map(|r| r.org), "mirrored to {dir}");
                let (ray, shadow) =
                    (point.scatter_ray(dir, true, 1.0), point.shadow_ray(dir, f32::INFINITY, true));
                assert_eq!(ray.map(|r| r.org), shadow.map(|r| r.org), "through to {dir}");
                assert!(ray.is_none() || dir.z < 0.0, "through means below: {dir}");
            }
        }
    }

    #[test]
    fn bent_normals_keep_mirror_images_above() {
        for k in 0..2000_u32 {
            let quasi_random = |n: u32, by: f32| ((k * n) as f32 * by).fract();
            let unit = |z: f32, azimuth: f32| {
                let r = (1.0 - z * z).sqrt();
                Vec3::new(r * azimuth.cos(), r * azimuth.sin(), z)
            };
            let wo = unit(0.002 + 0.99 * quasi_random(1, 0.618_034), 0.0);
            let mesh = unit(0.3 + 0.7 * quasi_random(3, 0.754_877_7), 7.0 * quasi_random(5, 0.569_840_3));
            let mapped = unit(0.2 + 0.8 * quasi_random(7, 0.819_172_5), 7.0 * quasi_random(11, 0.671_043_6));
            let lift = if k % 2 == 0 { Vec3::ZERO } else { mesh * 0.1 };
            let point = point(mesh, lift);
            let bent = point.bent_normal(mapped, wo);
            let mirrored = (-wo).reflect(bent);
            assert!((bent.length() - 1.0).abs() < 1e-5 && bent.dot(wo) > 0.0, "seen from the front");
            let leaves = point.scatter_ray(mirrored, false, 1.0).is_some();
            // Two horizons far apart can leave no directions between them.
            assert!(leaves || bent == Vec3::Z, "{k}: wo {wo}, mesh {mesh}, mapped {mapped}: {mirrored}");
            let fine = (-wo).reflect(mapped);
            if mapped.dot(wo) > 0.0 && fine.dot(mesh) > 0.002 && fine.z > 0.002 {
                assert_eq!(bent, mapped, "nothing is bent without need");
            }
        }
    }

    #[test]
    fn normals_that_look_away_do_not_turn_over() {
        // The far side of a ridge, whose triangles are still seen.
        let ns = Vec3::new(0.24, 0.89, -0.38).normalize();
        let wo = Vec3::new(0.45, -0.19, 0.87).normalize();
        let bent = point(ns, Vec3::Z * 0.1).bent_normal(ns, wo);
        assert!(bent.dot(wo) > 0.0 && bent.dot(ns) > 0.9, "{bent}");
    }

    #[test]
    fn lanes_know_which_normals_stay_as_they_are() {
        use crate::batch::{Detail, SurfaceBatch};
        use gnurt_simd::Level;
        let mut hits = SurfaceBatch::default();
        hits.resize(45, Detail::Full);
        let unit = |k: usize, by: f32| {
            let quasi_random = |n: usize| ((k * n + n) as f32 * by).fract() - 0.5;
            Vec3::new(quasi_random(3), quasi_random(5), quasi_random(7)).normalize()
        };
        for k in 0..45 {
            hits.ng.set(k, unit(k, 0.618_034));
            hits.ns.set(k, (hits.ng.get(k) + 0.3 * unit(k, 0.754_877_7)).normalize());
            hits.ray_dir.set(k, if k % 3 == 0 { unit(k, 0.37) } else { -hits.ns.get(k) });
            hits.lift.set(k, if k % 4 == 0 { Vec3::ZERO } else { Vec3::Y });
            hits.error[k] = 0.0;
        }
        let mut counts = [0; 2];
        for level in Level::available() {
            for first in [0, 16, 32] {
                let facing = hits.facing_rows(first);
                let mut normals = facing.ns;
                normals.iter_mut().for_each(|row| row[5] = 0.577_350_26);
                let found = hits.unbent(level, first, &normals);
                for (lane, i) in (first..45.min(first + 16)).enumerate() {
                    let n = Vec3::new(normals[0][lane], normals[1][lane], normals[2][lane]);
                    let stays = hits.point(i).bent_normal(n, -hits.ray_dir.get(i)) == n;
                    assert_eq!(found >> lane & 1 != 0, stays, "{level}, point {i}");
                    counts[usize::from(stays)] += 1;
                }
            }
        }
        assert!(counts.iter().all(|&count| count > 5), "both are there: {counts:?}");
    }
}
