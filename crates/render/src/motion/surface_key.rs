// SPDX-License-Identifier: GPL-3.0-or-later
//! The surface and light of a pixel of a picture in motion, and the light known there.
//! Source: light and surface apart: as [WKB*02]; when two pixels show one surface: `many_lights/interleave.rs`. Space: world.
//! Layout: the data that compares pixels is separate from the data of their colour, because filters read only
//! the former many times.

use glam::{Vec3, Vec4};
use gnurt_shading::real::Real;

/// Cosine between normals of one surface, at least.
const SAME_NORMAL: f32 = 0.9;
/// Greatest sine of the angle between a surface and the direction to another of its points.
const SAME_PLANE: f32 = 0.15;
/// Distances below this, in widths of pixels, are too short to compare planes.
const TOUCHING: f32 = 0.1;
/// Greatest foreshortening of a surface that adjacent pixels may show: in widths of pixels.
const NEAR: f32 = 8.0;

/// The visible point on a surface, behind mirrors and smooth glass if present.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SurfaceKey {
    pub(super) p: Vec3,
    /// Unit, on the side that it is seen from.
    pub(super) ns: Vec3,
    /// Of instance and material; 0 = no surface.
    pub(super) id: u32,
    /// Width of the pixel there.
    pub(super) width: f32,
}

impl SurfaceKey {
    pub(super) fn is_surface(&self) -> bool {
        self.id != 0
    }

    /// A number for the id, for comparisons: never NaN; 0 for no surface, else in 1..2.
    #[inline(always)]
    pub(super) fn number(&self) -> f32 {
        let fraction = (self.id ^ self.id >> 9) & 0x7f_ffff;
        if self.id == 0 { 0.0 } else { f32::from_bits(fraction | 1.0_f32.to_bits()) }
    }

    /// Whether the light on the two is about the same, for pixels at distance `pixels`.
    #[inline(always)]
    pub(super) fn agrees(&self, other: &Self, pixels: f32) -> bool {
        let offset = other.p - self.p;
        let cos = self.ns.dot(other.ns);
        let same = Same::new(self.width, pixels);
        (self.id == other.id) & same.holds(offset.length_squared(), offset.dot(self.ns), cos)
    }

    /// Those of four weights whose surface [agrees](Self::agrees); 0 for the others.
    #[inline(always)]
    pub(super) fn agreeing(&self, others: [&Self; 4], weights: Vec4, pixels: f32) -> Vec4 {
        let [a, b, c, d] = others;
        let point = |k: usize| Vec4::new(a.p[k], b.p[k], c.p[k], d.p[k]);
        let normal = |k: usize| Vec4::new(a.ns[k], b.ns[k], c.ns[k], d.ns[k]);
        let cos = normal(0) * self.ns.x + normal(1) * self.ns.y + normal(2) * self.ns.z;
        let same = |other: &Self| if other.id == self.id { 1.0 } else { 0.0 };
        let ids = Vec4::new(same(a), same(b), same(c), same(d));
        let weights = self.on_surface([point(0), point(1), point(2)], weights, pixels);
        Vec4::select(cos.cmpgt(Vec4::splat(SAME_NORMAL)), weights * ids, Vec4::ZERO)
    }

    /// Those of four weights whose points may be on this surface; 0 for the others.
    #[inline(always)]
    pub(super) fn on_surface(&self, [x, y, z]: [Vec4; 3], weights: Vec4, pixels: f32) -> Vec4 {
        let same = Same::new(self.width, pixels);
        let (x, y, z) = (x - self.p.x, y - self.p.y, z - self.p.z);
        let far2 = x * x + y * y + z * z;
        let off = x * self.ns.x + y * self.ns.y + z * self.ns.z;
        let off = (off.abs() - same.touching).max(Vec4::ZERO);
        let near = far2.cmplt(Vec4::splat(same.far2));
        let on_plane = (off * off).cmple(far2 * (SAME_PLANE * SAME_PLANE));
        Vec4::select(near, Vec4::select(on_plane, weights, Vec4::ZERO), Vec4::ZERO)
    }
}

/// Criteria for the same surface, for pixels of this width at this distance.
#[derive(Clone, Copy)]
pub(super) struct Same<R> {
    /// Square of the greatest distance.
    far2: R,
    /// Off a plane by no more than this is on it.
    touching: R,
}

impl<R: Real> Same<R> {
    #[inline(always)]
    pub(super) fn new(width: R, pixels: f32) -> Self {
        let near = width * (NEAR * pixels);
        Self { far2: near * near, touching: width * TOUCHING }
    }

    /// Whether points may be on one surface: by the square of their distance, the distance of the one from
    /// the other's plane, and the cosine between normals.
    #[inline(always)]
    pub(super) fn holds(&self, far2: R, off: R, cos: R) -> R::Mask {
        let off = (off.size() - self.touching).or_more(off.all(0.0));
        let is_off = (off * off).above(far2 * (SAME_PLANE * SAME_PLANE));
        cos.above_all(SAME_NORMAL) & self.far2.above(far2) & !is_off
    }
}

/// The components of its colour.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tint {
    /// Radiance without filtering: lights and environment.
    pub(super) plain: Vec3,
    /// Factor of light on the surface.
    pub(super) share: Vec3,
    /// Width of its lobes, as slopes of microfacets: light stays valid while they are wide relative to the
    /// rotation of the view. 1 = the same to all sides.
    pub(super) roughness: f32,
    /// Whether anything was met.
    pub(super) opacity: f32,
}

/// Light on a surface, averaged over directions as the surface scatters them: a mean of this number of
/// samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Light {
    pub(super) mean: Vec3,
    pub(super) count: f32,
}

impl Light {
    /// Adds another with a weight.
    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self, weight: f32) {
        let count = weight * other.count;
        self.mean += other.mean * count;
        self.count += count;
    }

    /// The mean of the added values.
    #[inline(always)]
    pub(super) fn averaged(self) -> Self {
        let scale = if self.count > 0.0 { 1.0 / self.count } else { 0.0 };
        Self { mean: self.mean * scale, count: self.count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_are_told_apart() {
        let surface_key = SurfaceKey { p: Vec3::ZERO, ns: Vec3::Z, id: 3, width: 1.0 };
        let at = |x: f32, y: f32, z: f32| SurfaceKey { p: Vec3::new(x, y, z), ..surface_key };
        assert!(surface_key.agrees(&at(2.0, 0.0, 0.0), 1.0), "on one plane");
        assert!(surface_key.agrees(&at(0.0, 0.0, 0.05), 1.0), "off by rounding");
        assert!(!surface_key.agrees(&at(2.0, 0.0, 1.0), 1.0), "off the plane");
        assert!(
            !surface_key.agrees(&at(9.0, 0.0, 0.0), 1.0) && surface_key.agrees(&at(9.0, 0.0, 0.0), 2.0),
            "as far as pixels"
        );
        assert!(!surface_key.agrees(&SurfaceKey { id: 4, ..surface_key }, 1.0), "another thing");
        assert!(!surface_key.agrees(&SurfaceKey { ns: Vec3::X, ..surface_key }, 1.0), "around a corner");
    }

    #[test]
    fn means_are_weighted() {
        let mut sum = Light::default();
        sum.add(&Light { mean: Vec3::splat(1.0), count: 3.0 }, 1.0);
        sum.add(&Light { mean: Vec3::splat(5.0), count: 2.0 }, 0.5);
        let mean = sum.averaged();
        assert_eq!((mean.mean.x, mean.count), (2.0, 4.0), "three of one, and one of the other");
        assert_eq!(Light::default().averaged().mean, Vec3::ZERO, "of nothing");
    }
}
