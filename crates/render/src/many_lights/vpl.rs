// SPDX-License-Identifier: GPL-3.0-or-later
//! Virtual point lights: the vertices of light paths and their power.
//! Source: [Kel97]; glossy ones emit by their BSDF, so the BSDFs of both ends count. Space: world.
//! Invariant: the light that a point gets from a path's vertex, over the density of that path, is
//! `eye BSDF |cos| * vpl BSDF |cos| * adjoint correction * power / distance^2` where both see each other.
//! Tests: crates/render/tests/many_lights.rs.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use gnurt_image::srgb::luminance;
use gnurt_shading::SurfacePoint;
use gnurt_shading::bsdf::{Bsdf, Carrying, left_after};

use super::bound::Bound;
use super::eye::EyePoint;

/// A virtual point light.
#[derive(Clone, Debug)]
pub(crate) struct Vpl {
    /// Where it is; its geometric normal is on the side that its light came from.
    pub(crate) point: SurfacePoint,
    pub(crate) bsdf: Bsdf,
    /// Unit, to where its light came from.
    pub(crate) from: Vec3,
    /// Light that arrives, over the density of its path.
    pub(crate) power: Vec3,
    /// Edges of its path, from the light to it.
    pub(crate) edges: u32,
    /// For Lambertian surfaces, the factor of the geometric cosine and the distance.
    pub(crate) diffuse: Option<Vec3>,
}

impl Vpl {
    pub(crate) fn new(point: SurfacePoint, bsdf: Bsdf, from: Vec3, power: Vec3, edges: u32) -> Self {
        let tilt = bsdf.normal().dot(from).max(0.0) / point.ng.dot(from).max(f32::MIN_POSITIVE);
        let diffuse = bsdf.lambertian().map(|albedo| albedo * power * (FRAC_1_PI * tilt));
        Self { point, bsdf, from, power, edges, diffuse }
    }

    /// The same light, `share` times as strong.
    pub(crate) fn scaled(&self, share: f32) -> Self {
        Self { power: self.power * share, diffuse: self.diffuse.map(|d| d * share), ..self.clone() }
    }

    /// About how much light it sends.
    pub(crate) fn strength(&self) -> f32 {
        luminance(self.diffuse.unwrap_or_else(|| self.power * self.bsdf.albedo(self.from)).into())
    }

    /// Whether any light may come from it.
    pub(crate) fn emits(&self) -> bool {
        self.diffuse
            .map_or(self.bsdf.is_smooth() && self.power != Vec3::ZERO, |diffuse| diffuse != Vec3::ZERO)
    }

    /// Radiance towards `to` (unit) per solid angle and projected area of the geometric surface.
    pub(crate) fn sent(&self, to: Vec3) -> Vec3 {
        let (sent, came) = (self.point.ng.dot(to), self.point.ng.dot(self.from));
        if sent < 0.0 {
            // Through the surface: the frame is that of the side that light came from.
            let through = self.bsdf.is_transmitted(to) && self.point.ns.dot(to) < 0.0;
            return if through {
                let carrying = Carrying::new(&self.bsdf, self.from);
                let (value, _) = carrying.eval_pdf(to, self.point.ng);
                value * self.power * carrying.correction(to, self.point.ng)
            } else {
                Vec3::ZERO
            };
        }
        // Seen from `to`, so that it counts as paths from the eye count it.
        match self.diffuse {
            Some(diffuse) => diffuse * sent,
            None => self.bsdf.eval(to, self.from) * self.power * (sent / came),
        }
    }

    /// Unoccluded contribution to a visible point, limited to the share of virtual lights; `None` if there is
    /// none.
    pub(crate) fn brings(&self, eye: &EyePoint, bound: &Bound, max_edges: u32) -> Option<Vec3> {
        if self.edges + 1 + eye.edges > max_edges {
            return None;
        }
        let offset = self.point.p - eye.point.p;
        let distance2 = offset.length_squared();
        let to = offset / distance2.sqrt();
        if !(distance2 > 0.0 && to.is_finite() && eye.point.scatters_to(to, eye.bsdf.is_transmitted(to))) {
            return None;
        }
        // The cheap test comes first: a Lambertian light shines to its front only.
        let sent = self.sent(-to);
        if sent == Vec3::ZERO {
            return None;
        }
        let (got, pdf) = eye.bsdf.eval_pdf(eye.wo, to);
        if got == Vec3::ZERO {
            return None;
        }
        let pdf_eye = pdf * self.point.ng.dot(to).abs() / distance2;
        let pdf_vpl = pdf_of_other_end(&self.point, &self.bsdf, self.from, -to) * eye.point.ng.dot(to).abs()
            / distance2;
        let left = left_after(distance2.sqrt(), [eye.bsdf.absorption(to), self.bsdf.absorption(-to)]);
        Some(eye.throughput * got * sent * left * (bound.share(pdf_eye, pdf_vpl) / distance2))
    }
}

/// Density per solid angle with which a light path from `from` would continue to `to`, if both are on one
/// side of the surface; 0 elsewhere, so that it can be evaluated from either side.
pub(crate) fn pdf_of_other_end(point: &SurfacePoint, bsdf: &Bsdf, from: Vec3, to: Vec3) -> f32 {
    if point.ng.dot(from) * point.ng.dot(to) <= 0.0 {
        0.0
    } else if bsdf.lambertian().is_some() {
        bsdf.normal().dot(to).max(0.0) * FRAC_1_PI
    } else {
        bsdf.pdf(from, to)
    }
}

/// Whether light from `dir` (any length) may count at a hit point, with any BSDF: above the horizon, or
/// through the surface.
pub(crate) fn is_open(point: &SurfacePoint, dir: Vec3) -> bool {
    let (above_ns, above_ng) = (point.ns.dot(dir), point.ng.dot(dir));
    if above_ns > 0.0 { above_ng > 0.0 || point.lift != Vec3::ZERO } else { above_ns < 0.0 && above_ng < 0.0 }
}

/// Where shadow rays towards `dir` (any length) leave a point that is seen, if its light counts.
pub(crate) fn start(eye: &EyePoint, dir: Vec3) -> Option<Vec3> {
    eye.point.scatter_ray(dir, eye.bsdf.is_transmitted(dir), 1.0).map(|ray| ray.org.into())
}

/// Where they end at a virtual light that sends to `dir` (any length).
pub(crate) fn end(point: &SurfacePoint, dir: Vec3) -> Vec3 {
    point.spawn(dir, 1.0).org.into()
}
