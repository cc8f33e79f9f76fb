// SPDX-License-Identifier: GPL-3.0-or-later
//! Features of every surface beside its scattering: emission on its front, bumps, and opacity.
//! Source: glTF 2.0 section 3.9 (alpha modes, emission). Radiance is coverage * (scattered + emitted) + (1 -
//! coverage) * radiance straight behind. Tests: `crates/render/tests/appearance.rs`.

use std::borrow::Cow;
use std::sync::Arc;

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::bsdf::ClosureBatch;
use crate::materials::bump::BumpMap;
use crate::materials::color::{Coverage, Emission};
use crate::shader::{AttributeRequest, RadianceShader, ShaderOutput, SurfaceShader, Tracer};

/// A surface with emission and opacity.
#[derive(Clone)]
pub struct Material {
    /// How it scatters.
    pub surface: Arc<dyn SurfaceShader>,
    /// Radiance that leaves its front.
    pub emission: Option<Emission>,
    /// Where it is there; `None` = everywhere.
    pub coverage: Option<Coverage>,
    /// The map that bends its normals.
    pub bump: Option<BumpMap>,
    /// The attributes that its textures read; empty = those of the surface.
    pub attributes: Vec<AttributeRequest>,
}

impl Material {
    /// The points with their normals bent.
    fn bumpy<'a>(&self, hits: &'a SurfaceBatch) -> Cow<'a, SurfaceBatch> {
        match &self.bump {
            Some(bump) => Cow::Owned(SurfaceBatch { bent: bump.bent(hits), ..hits.clone() }),
            None => Cow::Borrowed(hits),
        }
    }

    /// Adds the light through transparent parts to the transmittance.
    fn open(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        let Some(coverage) = &self.coverage else { return };
        for i in 0..hits.len() {
            let c = coverage.at_hit(hits, i);
            out.set(i, out.get(i) * c + Vec3::splat(1.0 - c));
        }
    }
}

impl SurfaceShader for Material {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        let inner = self.surface.radiance()?;
        Some(if self.bump.is_some() { self } else { inner })
    }

    fn emits(&self) -> bool {
        self.emission.is_some() || self.surface.emits()
    }

    fn transmit(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        if !self.surface.is_opaque() {
            self.surface.transmit(tracer, hits, out);
        }
        self.open(hits, out);
    }

    fn gaps(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        if !self.surface.is_solid() {
            self.surface.gaps(tracer, hits, out);
        }
        self.open(hits, out);
    }

    fn has_medium(&self) -> bool {
        self.surface.has_medium()
    }

    fn has_holes(&self) -> bool {
        self.surface.has_holes()
    }

    fn is_clear(&self) -> bool {
        self.surface.is_clear()
    }

    fn is_solid(&self) -> bool {
        self.coverage.is_none() && self.surface.is_solid()
    }

    fn is_opaque(&self) -> bool {
        self.coverage.is_none() && self.surface.is_opaque()
    }

    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        self.surface.evaluate(&self.bumpy(hits), out);
        for i in 0..hits.len() {
            if let Some(emission) = self.emission.as_ref().filter(|_| hits.front(i)) {
                out.emit(i, emission.at_hit(hits, i));
            }
            if let Some(coverage) = &self.coverage {
                out.fade(i, coverage.at_hit(hits, i));
            }
        }
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        self.surface.albedo(hits, out);
    }

    fn backdrop(&self) -> Option<Vec3> {
        self.surface.backdrop()
    }

    fn describe(&self, hits: &SurfaceBatch, lane: usize) -> Vec<String> {
        self.surface.describe(&self.bumpy(hits), lane)
    }

    fn outputs(&self) -> &[ShaderOutput] {
        self.surface.outputs()
    }

    fn output(&self, name: &str, hits: &SurfaceBatch, out: &mut Vec3s) {
        self.surface.output(name, &self.bumpy(hits), out);
    }

    fn attributes(&self) -> &[AttributeRequest] {
        if self.attributes.is_empty() { self.surface.attributes() } else { &self.attributes }
    }
}

/// Where the surface computes its radiance itself and normals are bent.
impl RadianceShader for Material {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        if let Some(surface) = self.surface.radiance() {
            surface.shade(tracer, &self.bumpy(hits), out);
        }
    }
}
