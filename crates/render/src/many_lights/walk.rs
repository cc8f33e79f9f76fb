// SPDX-License-Identifier: GPL-3.0-or-later
//! Paths from the eye through the virtual lights' part of the light: their state, and their ends.
//! Source: [KK06] (rays bring the part that the bound removes from virtual lights), [VG95]. Space: world.
//! Tests: crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_shading::bsdf::left_after;
use gnurt_shading::{SampleKey, SurfacePoint};

use super::bound::Bound;
use super::eye::EyePoint;
use super::vpl::pdf_of_other_end;
use crate::cone::ConeHit;
use crate::transport::Vertex;
use crate::transport::manifold::{Chain, SmoothPoint};

/// Purposes of random numbers; those of light samples follow the last one.
pub(super) mod purpose {
    pub(crate) const DIRECTION: u32 = 0x5000;
    pub(crate) const LOBE: u32 = 0x5001;
    pub(crate) const POSITION: u32 = 0x5003;
    pub(crate) const CHOICE: u32 = 0x5004;
    pub(crate) const CUT: u32 = 0x5005;
    pub(crate) const SHARE: u32 = 0x5006;
}

/// The last smooth scattering of a path from the eye.
#[derive(Clone, Copy)]
pub(super) struct Last {
    pub(super) point: SurfacePoint,
    /// Density per solid angle of the ray that left it.
    pub(super) pdf: f32,
    /// The normal that light samples were taken for.
    pub(super) side: Vec3,
    /// How many light samples were taken there for each ray that left it.
    pub(super) light_samples: f32,
    /// The bound of virtual lights there.
    pub(super) bound: Bound,
}

/// An active path from the eye.
#[derive(Clone, Copy)]
pub(super) struct Walk {
    pub(super) lane: u32,
    pub(super) key: SampleKey,
    pub(super) throughput: Vec3,
    /// Start of the current edge, and the absorption there.
    pub(super) start: Vec3,
    pub(super) absorption: Vec3,
    /// Edges, the current one included.
    pub(super) edges: u32,
    /// `None` if the current edge comes from the eye, a mirror or smooth glass.
    pub(super) last: Option<Last>,
    /// Whether all edges so far do.
    pub(super) is_directly_visible: bool,
    /// Factor of direct light at its origin.
    pub(super) light_gain: f32,
    /// How many walks share the light of its lane.
    pub(super) siblings: f32,
    /// Smooth surfaces since it was scattered, if points search for lamps behind such.
    pub(super) chain: Chain,
}

impl Walk {
    /// The walk at the end of its current edge: without the light absorbed along it. `None` = it leaves the
    /// scene.
    pub(super) fn absorbed(&self, vertex: Option<&Vertex>) -> Self {
        let (offset, there) = vertex.map_or((f32::INFINITY, Vec3::ZERO), |vertex| {
            ((vertex.point.p - self.start).length(), vertex.scattering.bsdf.medium().on(true))
        });
        Self { throughput: self.throughput * left_after(offset, [self.absorption, there]), ..*self }
    }
}

/// The end of a walk's edge, where it continues.
pub(super) struct Stop {
    pub(super) walk: Walk,
    pub(super) eye: EyePoint,
    /// Factor of direct light here.
    pub(super) light_gain: f32,
    /// How many rays may go on from here, and the chance that each of them does.
    pub(super) rays: u32,
    pub(super) probability: f32,
    /// The hit, and the length of the last edge.
    pub(super) instance: u32,
    pub(super) distance: f32,
    /// How the ray's cone met it.
    pub(super) cone: ConeHit<f32>,
    /// Where chains of searches go on, if it is such a point.
    pub(super) smooth: Option<Box<SmoothPoint>>,
}

impl Stop {
    /// Fraction of light from `to` that is left for rays on this path; 1 if virtual lights bring none of it.
    pub(super) fn rest(&self, to: Vec3) -> f32 {
        let Some(last) = &self.walk.last else { return 1.0 };
        let point = &self.eye.point;
        let distance2 = (point.p - last.point.p).length_squared();
        let pdf_eye = last.pdf * point.ng.dot(self.eye.wo).abs() / distance2;
        let pdf_vpl = pdf_of_other_end(point, &self.eye.bsdf, to, self.eye.wo)
            * last.point.ng.dot(self.eye.wo).abs()
            / distance2;
        1.0 - last.bound.share(pdf_eye, pdf_vpl)
    }

    /// How many rays go on from here on average.
    pub(super) fn mean_rays(&self) -> f32 {
        self.rays as f32 * self.probability
    }

    /// Whether virtual lights bring all that it could.
    pub(super) fn is_spent(&self) -> bool {
        // Lambertian ends have the same density for any direction of the light: one answer for all.
        self.eye.bsdf.lambertian().is_some() && self.rest(self.eye.wo) <= 0.0
    }
}
