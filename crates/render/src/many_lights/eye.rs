// SPDX-License-Identifier: GPL-3.0-or-later
//! Points visible from the eye, directly or by mirrors and glass: receivers of virtual lights.
//! Source: [Kel97]. Space: world. Tests: crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_shading::SurfacePoint;
use gnurt_shading::bsdf::{Bsdf, BsdfSample};

use crate::transport::{Vertex, walks};

/// A point that light is gathered at.
#[derive(Clone, Debug)]
pub(crate) struct EyePoint {
    pub(crate) point: SurfacePoint,
    /// Unit, towards the eye.
    pub(crate) wo: Vec3,
    pub(crate) bsdf: Bsdf,
    /// Factor of its light along the path to the eye.
    pub(crate) throughput: Vec3,
    /// Edges of the path from the eye to it.
    pub(crate) edges: u32,
    /// Which lane of the batch it belongs to.
    pub(crate) lane: u32,
}

impl EyePoint {
    pub(crate) fn new(vertex: Vertex, throughput: Vec3, edges: u32, lane: u32) -> Self {
        let Vertex { point, wo, scattering, .. } = vertex;
        Self { point, wo, bsdf: scattering.bsdf, throughput, edges, lane }
    }

    /// The next ray of a walk from it.
    pub(super) fn scatter(&self, u: [f32; 3]) -> Option<(Ray, BsdfSample)> {
        walks::scatter(&self.point, &self.bsdf, (self.wo, self.throughput), u)
    }
}
