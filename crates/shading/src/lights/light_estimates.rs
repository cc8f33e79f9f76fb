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
    /// About the most that the group brings to surfaces at `p`; points without normals are lit from all sides.
    #[inline(always)]
    pub(super) fn importance(&self, p: Vector<R>, normal: Option<Vector<R>>) -> R {
        let (zero, one, radius2) = (p.x.all(0.0), p.x.all(1.0), self.radius2);
        let offset = self.centre - p;
        let distance2 = offset.length_squared();
        let towards = offset.over(distance2.root());
        // The cone in which the ball around the box is seen; from within it lies everywhere.
        let cos_size =
            R::pick(distance2.above(radius2), (one - radius2 / distance2).or_more(zero).root(), -one);
        let from_normal = angle_less(-self.axis.dot(towards), self.cos_normals);
        let cos_light = angle_less(from_normal, cos_size);
        // A little slack, because rounding must not hide grazing lights.
        let mut dark = (self.cos_emission - zero.all(1e-4)).above(cos_light);
        let mut cos_surface = one;
        if let Some(normal) = normal {
            cos_surface = angle_less(normal.dot(towards), cos_size);
            // Wholly below the horizon: the box's highest corner is.
            let highest = normal.dot(offset) + normal.abs().dot(self.half);
            dark = dark | zero.all(-1e-4).above(cos_surface) | !highest.above(zero);
        }
        let least = zero.all(1e-4);
        let estimate =
            self.power * cos_light.or_more(least) * cos_surface.or_more(least) / distance2.or_more(radius2);
        let estimate = R::pick(estimate.is_number(), estimate, zero.all(f32::MAX.sqrt()));
        let at_centre = self.power / radius2.or_more(zero.all(f32::MIN_POSITIVE));
        R::pick(towards.is_finite(), R::pick(dark, zero, estimate), at_centre)
    }
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
