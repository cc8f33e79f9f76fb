// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights as choices see them, from one point or sixteen: what a group of lights or a triangle brings about, and points of triangles.
//! Source: as `light_tree` and `area`. Space: world.
//! Invariant: the same bits for one point as for sixteen. Tests: `light_set_tests::lanes_choose_as_points_do`, `light_tree`, `area`.

use super::spherical;
use crate::real::{Real, Vector};
use crate::sampling::triangle;

/// Least share that a part of an emitter counts as, of its mean or its brightest direction: its samples may be dark where the rest is
/// bright.
pub const LEAST_SHARE: f32 = 1.0 / 64.0;

/// A group of lights, as [`LightBounds`](super::light_tree::LightBounds).
#[derive(Clone, Copy)]
pub(super) struct GroupBounds<R: Real> {
    pub(super) centre: Vector<R>,
    /// Half of the box's diagonal.
    pub(super) half: Vector<R>,
    /// Square of the radius of the ball around the box.
    pub(super) radius2: R,
    pub(super) axis: Vector<R>,
    pub(super) cos_normals: R,
    pub(super) cos_emission: R,
    pub(super) power: R,
}

impl<R: Real> GroupBounds<R> {
    /// About what the group brings to surfaces at `p`, 0 only where it is dark for sure; points without normals are lit from all sides.
    #[inline(always)]
    pub(super) fn importance(&self, p: Vector<R>, normal: Option<Vector<R>>) -> R {
        let (zero, one, radius2) = (p.x.all(0.0), p.x.all(1.0), self.radius2);
        let offset = self.centre - p;
        let distance2 = offset.length_squared();
        let towards = offset.over(distance2.root());
        // The cone in which the ball around the box is seen; from within it lies everywhere.
        let cos_size =
            R::pick(distance2.above(radius2), (one - radius2 / distance2).or_more(zero).root(), -one);
        let cos_axis = -self.axis.dot(towards);
        let brightest = angle_less(angle_less(cos_axis, self.cos_normals), cos_size);
        // A little slack, because rounding must not hide grazing lights.
        let mut dark = (self.cos_emission - zero.all(1e-4)).above(brightest);
        // Light that leaves along normals alone has no cosine.
        let mean = mean_cosine(angle_less(cos_axis, cos_size), self.cos_normals);
        let cos_light = R::pick(self.cos_emission.above(zero), brightest, mean);
        let mut cos_surface = one;
        if let Some(normal) = normal {
            let cos = normal.dot(towards);
            let nearest = angle_less(cos, cos_size);
            let sin_size = (one - cos_size * cos_size).or_more(zero).root();
            cos_surface = R::pick(cos_size.above(zero), above_horizon(cos, sin_size), nearest);
            // Wholly below the horizon: the box's highest corner is.
            let highest = normal.dot(offset) + normal.abs().dot(self.half);
            dark = dark | zero.all(-1e-4).above(nearest) | !highest.above(zero);
        }
        let least = zero.all(1e-4);
        let estimate =
            self.power * cos_light.or_more(least) * cos_surface.or_more(least) / distance2.or_more(radius2);
        let estimate = R::pick(estimate.is_number(), estimate, zero.all(f32::MAX.sqrt()));
        let at_centre = self.power / radius2.or_more(zero.all(f32::MIN_POSITIVE));
        R::pick(towards.is_finite(), R::pick(dark, zero, estimate), at_centre)
    }
}

/// About the mean cosine of normals in a cone of half angle `b` to a direction at angle `a` to its axis, those that look away as 0; by the cosines of
/// both. Exact where the cone has no width, is half of the sphere or all of it.
#[inline(always)]
fn mean_cosine<R: Real>(cos_a: R, cos_b: R) -> R {
    let (zero, half, one) = (cos_a.all(0.0), cos_a.all(0.5), cos_a.all(1.0));
    // The mean of positive parts is half of that of cosines and that of their sizes.
    let (mean, narrow) = ((one + cos_b) * half, cos_b.or_more(zero));
    half * (cos_a * mean + narrow * cos_a.size() + half * (one - narrow))
}

/// About the cosine by which a ball at angle `a` to the normal lights a surface, the part below the horizon left out; `sin_size` is
/// the sine of the angle of its radius.
#[inline(always)]
pub(super) fn above_horizon<R: Real>(cos_a: R, sin_size: R) -> R {
    let zero = cos_a.all(0.0);
    let part = (cos_a + sin_size).or_more(zero);
    let partly = part * part / (sin_size * zero.all(4.0)).or_more(zero.all(f32::MIN_POSITIVE));
    R::pick(cos_a.above(sin_size), cos_a, partly)
}

/// Cosine of angle `a` less angle `b`, at least zero; both by their cosines.
#[inline(always)]
fn angle_less<R: Real>(cos_a: R, cos_b: R) -> R {
    let (zero, one) = (cos_a.all(0.0), cos_a.all(1.0));
    let sin_a = (one - cos_a * cos_a).or_more(zero).root();
    let sin_b = (one - cos_b * cos_b).or_more(zero).root();
    R::pick(cos_b.above(cos_a), cos_a * cos_b + sin_a * sin_b, one)
}

/// A triangle, as [`Shape`](super::shape::Shape).
#[derive(Clone, Copy)]
pub(super) struct TriangleAt<R: Real> {
    pub(super) corners: [Vector<R>; 3],
    pub(super) normal: Vector<R>,
    pub(super) area: R,
    pub(super) power: R,
}

impl<R: Real> TriangleAt<R> {
    /// Approximate unoccluded contribution to surfaces at `p`; exactly 0 where there is none: seen from
    /// behind, or wholly below the horizon of `normal`. Points without normals have no horizon.
    #[inline(always)]
    pub(super) fn contribution(&self, p: Vector<R>, normal: Option<Vector<R>>) -> R {
        let zero = p.x.all(0.0);
        let [a, b, c] = [self.corners[0] - p, self.corners[1] - p, self.corners[2] - p];
        let before = -self.normal.dot(a);
        let above = match normal {
            Some(normal) => {
                normal.dot(a).or_more(zero) + normal.dot(b).or_more(zero) + normal.dot(c).or_more(zero)
            }
            None => a.length_squared().root() + b.length_squared().root() + c.length_squared().root(),
        };
        let above = above / zero.all(3.0);
        // Close to the triangle its nearest parts count most; its own size keeps the estimate finite there.
        let centre = (a + b + c).over(zero.all(3.0));
        let nearest = centre.length_squared().or_less(a.length_squared());
        let nearest = nearest.or_less(b.length_squared()).or_less(c.length_squared());
        let distance2 = nearest.or_more(self.area * 0.25);
        // Scaled step by step, so that it neither overflows nor vanishes in large or tiny scenes.
        let contribution = (before / distance2) * (above / distance2) * self.power;
        let contribution = R::pick(
            contribution.is_number(),
            contribution.or_more(zero.all(f32::MIN_POSITIVE)),
            zero.all(f32::MAX.sqrt()),
        );
        R::pick(before.above(zero) & above.above(zero), contribution, zero)
    }

    /// A point of it for two numbers in [0, 1), seen from `p`: near large triangles uniform by solid angle, for the points in `there`; else by area. It is
    /// short of the triangle by its rounding error, so that this does not shadow itself.
    #[inline(always)]
    pub(super) fn aim(&self, p: Vector<R>, u: [R; 2], there: R::Mask) -> Aim<R> {
        let (zero, one, [a, b, c]) = (p.x.all(0.0), p.x.all(1.0), self.corners);
        let [mut b1, mut b2] = triangle(u);
        let mut wide = zero;
        let from_here = [a - p, b - p, c - p];
        let (near, angle) = spherical::wide_angle(from_here, self.area);
        let near = near & there;
        if R::any(near) {
            let [w1, w2] = spherical::sample(from_here, angle, u);
            (b1, b2) = (R::pick(near, w1, b1), R::pick(near, w2, b2));
            wide = R::pick(near, one / angle, zero);
        }
        let point = a + (b - a) * b1 + (c - a) * b2;
        let reach = a.abs().max(b.abs()).max(c.abs()).max(p.abs()).max_element();
        let offset = point + self.normal * (reach * (16.0 * f32::EPSILON)) - p;
        let dist = offset.length_squared().root();
        let dir = offset.over(dist);
        Aim { position: [b1, b2], dir, dist, density: self.density_of(wide, dir, dist) }
    }

    /// Density per solid angle at `p` of the point that lies along the unit `dir`, `dist` away; 0 from behind.
    #[inline(always)]
    pub(super) fn density(&self, p: Vector<R>, dir: Vector<R>, dist: R) -> R {
        let [a, b, c] = self.corners;
        let (near, angle) = spherical::wide_angle([a - p, b - p, c - p], self.area);
        self.density_of(R::pick(near, dist.all(1.0) / angle, dist.all(0.0)), dir, dist)
    }

    /// The same where `wide` is that by solid angle, or 0.
    #[inline(always)]
    fn density_of(&self, wide: R, dir: Vector<R>, dist: R) -> R {
        let (zero, cos) = (dist.all(0.0), -self.normal.dot(dir));
        let density = R::pick(wide.above(zero), wide, dist * dist / (cos * self.area));
        R::pick(cos.above(zero), density, zero)
    }
}

/// Points of lights, seen from others.
pub(super) struct Aim<R: Real> {
    /// The place, as `shape` has it.
    pub(super) position: [R; 2],
    /// Unit, towards it.
    pub(super) dir: Vector<R>,
    pub(super) dist: R,
    /// Density per solid angle; 0 from behind.
    pub(super) density: R,
}

impl<R: Real> Aim<R> {
    /// Its own points in `mask`, else the other's.
    #[inline(always)]
    pub(super) fn or(self, mask: R::Mask, other: Self) -> Self {
        let [[a, b], [c, d]] = [self.position, other.position];
        Self {
            position: [R::pick(mask, a, c), R::pick(mask, b, d)],
            dir: Vector::pick(mask, self.dir, other.dir),
            dist: R::pick(mask, self.dist, other.dist),
            density: R::pick(mask, self.density, other.density),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beside sums over normals that are even over a cone, and over points of a ball.
    #[test]
    fn means_are_near_those_of_cones_and_balls() {
        let even = |n: u32| (0..n).map(move |i| (i as f32 + 0.5) / n as f32);
        for (cos_cone, slack) in
            [(1.0_f32, 1e-4), (0.8, 0.05), (0.4, 0.05), (0.0, 1e-3), (-0.5, 0.05), (-1.0, 1e-3)]
        {
            for angle in even(16).map(|x| x * std::f32::consts::PI) {
                let (sin_a, cos_a) = angle.sin_cos();
                let mut sum = 0.0;
                for (u, v) in even(64).flat_map(|u| even(64).map(move |v| (u, v))) {
                    let z = 1.0 - u * (1.0 - cos_cone);
                    let x = (1.0 - z * z).max(0.0).sqrt() * (v * std::f32::consts::TAU).cos();
                    sum += (x * sin_a + z * cos_a).max(0.0) / 4096.0;
                }
                let found = mean_cosine(cos_a, cos_cone);
                assert!((found - sum).abs() < slack, "{cos_cone} at {angle}: {found}, not {sum}");
            }
        }
        for (cos, expected) in [(0.9, 0.9), (0.6, 0.6), (0.0, 0.15), (-0.59, 0.0), (-0.9, 0.0)] {
            let found = above_horizon(cos, 0.6_f32);
            assert!((found - expected).abs() < 1e-3, "{cos}: {found}, not {expected}");
        }
    }
}
