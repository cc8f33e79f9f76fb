// SPDX-License-Identifier: GPL-3.0-or-later
//! Points of light, with or without a radius and a cone, as places see them, from one place or sixteen: what one brings about, and
//! directions to it. With a radius it is a disc that faces the place.
//! Source: as `punctual`. Space: world.
//! Invariant: the same bits for one place as for sixteen. Tests: `punctual::tests`, `light_set_tests::lanes_choose_as_points_do`.

use super::light_estimates::above_horizon;
use crate::real::{Real, Vector};
use crate::sampling::{concentric_disk_of, frame_around};

/// A [`PointLight`](super::PointLight).
#[derive(Clone, Copy)]
pub(super) struct DiscAt<R: Real> {
    pub(super) position: Vector<R>,
    pub(super) radius: R,
    pub(super) cone: ConeAt<R>,
}

/// A [`Cone`](super::Cone); that of lights which shine to all sides has no axis.
#[derive(Clone, Copy)]
pub(super) struct ConeAt<R: Real> {
    pub(super) axis: Vector<R>,
    pub(super) cos_outer: R,
    /// One over the difference of the cones' cosines.
    pub(super) scale: R,
    /// Above zero where the edge is smooth.
    pub(super) smooth: R,
}

/// Points of lights, as places see them.
pub(super) struct Seen<R: Real> {
    /// Unit, to the light.
    pub(super) dir: Vector<R>,
    pub(super) dist: R,
    /// The irradiance of a surface that faces that direction, over the density of the point, as a share of the light's intensity.
    pub(super) share: R,
    /// The places from which there is a direction: not the light itself.
    pub(super) there: R::Mask,
}

/// Length of a row: position, axis, cosine, scale and edge of the cone, radius.
pub(super) const NUMBERS: usize = 10;

impl ConeAt<f32> {
    /// That of lights which shine to all sides.
    pub(super) const EVERYWHERE: Self =
        Self { axis: Vector { x: 0.0, y: 0.0, z: 0.0 }, cos_outer: -2.0, scale: 1.0, smooth: 0.0 };
}

impl DiscAt<f32> {
    /// Its numbers in a row, as [`of`](Self::of) reads them.
    pub(super) fn row(&self) -> [f32; NUMBERS] {
        let ConeAt { axis, cos_outer, scale, smooth } = self.cone;
        let Vector { x, y, z } = self.position;
        [x, y, z, axis.x, axis.y, axis.z, cos_outer, scale, smooth, self.radius]
    }
}

impl<R: Real> ConeAt<R> {
    /// Share of the intensity at this cosine to the axis.
    #[inline(always)]
    pub(super) fn falloff(&self, cos: R) -> R {
        let share = ((cos - self.cos_outer) * self.scale).within(0.0, 1.0);
        let squared = share * share;
        R::pick(self.smooth.above_all(0.0), squared * (share.all(3.0) - share * 2.0), squared)
    }
}

impl<R: Real> DiscAt<R> {
    #[inline(always)]
    pub(super) fn of(row: &[R]) -> Self {
        let vector = |k: usize| Vector::new(row[k], row[k + 1], row[k + 2]);
        let cone = ConeAt { axis: vector(3), cos_outer: row[6], scale: row[7], smooth: row[8] };
        Self { position: vector(0), radius: row[9], cone }
    }

    /// About how bright it makes surfaces at `p` by an intensity of this brightness; above zero wherever any of its disc is seen. Points
    /// without normals are lit from all sides.
    #[inline(always)]
    pub(super) fn contribution(&self, power: R, p: Vector<R>, normal: Option<Vector<R>>) -> R {
        let (zero, one) = (p.x.all(0.0), p.x.all(1.0));
        let offset = self.position - p;
        let distance2 = offset.length_squared();
        let dir = offset.over(distance2.root());
        let cos = normal.map_or(one, |normal| normal.dot(dir));
        // Sine and cosine of the angle of its radius.
        let across2 = distance2 + self.radius * self.radius;
        let (sin, straight) = (self.radius / across2.root(), (distance2 / across2).root());
        let along = -dir.dot(self.cone.axis);
        let across = (one - along * along).or_more(zero).root();
        let nearest = R::pick(straight.above(along), along * straight + across * sin, one);
        let found = power * self.cone.falloff(nearest) * above_horizon(cos, sin) / across2;
        let found = R::pick(found.is_number(), found, zero.all(f32::MAX.sqrt()));
        R::pick(distance2.above(zero), found, zero)
    }

    /// Its light at `p` from a point of its disc by two numbers in [0, 1), uniform by area.
    #[inline(always)]
    pub(super) fn seen_from(&self, p: Vector<R>, u: [R; 2]) -> Seen<R> {
        let (zero, one) = (p.x.all(0.0), p.x.all(1.0));
        let mut offset = self.position - p;
        let mut dist = offset.length_squared().root();
        let mut dir = offset.over(dist);
        let there = dist.above(zero) & dist.is_number();
        let mut facing = one;
        let wide = self.radius.above(zero);
        if R::any(wide) {
            let ([x, y], [side, up], middle) = (concentric_disk_of(u), frame_around(dir), dir);
            let on_disc = (side * x + up * y) * self.radius;
            offset = Vector::pick(wide, offset + on_disc, offset);
            dist = offset.length_squared().root();
            dir = offset.over(dist);
            facing = R::pick(wide, dir.dot(middle), one);
        }
        Seen { dir, dist, share: self.cone.falloff(-dir.dot(self.cone.axis)) * facing / (dist * dist), there }
    }
}
