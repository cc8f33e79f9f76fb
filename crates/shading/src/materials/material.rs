// SPDX-License-Identifier: GPL-3.0-or-later
//! What every surface may have beside its scattering: emission on its front, and places where it is not there.
//! Source: glTF 2.0 section 3.9 (alpha modes, emission). Radiance is coverage * (scattered + emitted) + (1 - coverage) *
//! what lies straight behind. Proof: `crates/render/tests/appearance.rs`.

use std::sync::Arc;

use crate::batch::{Detail, SurfaceBatch, Vec3s};
use crate::bsdf::Scattering;
use crate::materials::Lambertian;
use crate::materials::color::{Coverage, Emission, PlainColor};
use crate::materials::whitted::branch;
use crate::shader::{AttributeRequest, RayRequest, SurfaceShader, Tracer};

/// A surface with emission and holes.
#[derive(Clone)]
pub struct Material {
    /// How it scatters.
    pub surface: Arc<dyn SurfaceShader>,
    /// Radiance that leaves its front.
    pub emission: Option<Emission>,
    /// Where it is there; `None` = everywhere.
    pub coverage: Option<Coverage>,
}

impl Material {
    /// Adds what passes the holes to what the surface lets through.
    fn open(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        let Some(coverage) = &self.coverage else { return };
        for i in 0..hits.len() {
            let c = coverage.at_hit(hits, i);
            out.set(i, out.get(i) * c + glam::Vec3::splat(1.0 - c));
        }
    }

    fn shade_solid(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        self.surface.shade(tracer, hits, out);
        let Some(emission) = &self.emission else { return };
        for i in (0..hits.len()).filter(|&i| hits.front(i)) {
            out.add(i, emission.at([hits.texcoord[0][i], hits.texcoord[1][i]]));
        }
    }
}

impl SurfaceShader for Material {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let Some(coverage) = &self.coverage else {
            return self.shade_solid(tracer, hits, out);
        };
        let covered: Vec<f32> = (0..hits.len()).map(|i| coverage.at_hit(hits, i)).collect();
        let lanes_where = |there: &dyn Fn(f32) -> bool| -> Vec<u32> {
            (0..hits.len() as u32).filter(|&i| there(covered[i as usize])).collect()
        };
        let solid = lanes_where(&|c| c > 0.0);
        if !solid.is_empty() {
            let part = hits.gather(&solid);
            let mut radiance = Vec3s::splat(solid.len(), glam::Vec3::ZERO);
            self.shade_solid(tracer, &part, &mut radiance);
            for (k, &i) in solid.iter().enumerate() {
                out.add(i as usize, radiance.get(k) * covered[i as usize]);
            }
        }
        let open = lanes_where(&|c| c < 1.0);
        if !open.is_empty() {
            let mut request = RayRequest::default();
            for &i in &open {
                let dir = hits.ray_dir.get(i as usize);
                request.rays.push(hits.spawn(i as usize, dir, f32::INFINITY));
                request.parent.push(i);
                request.key.push(hits.key[i as usize].fork(branch::STRAIGHT));
                request.width.push(hits.footprint.get(i as usize).copied().unwrap_or(0.0));
            }
            let mut behind = Vec3s::default();
            tracer.trace(hits.depth, &request, &mut behind);
            for (k, &i) in open.iter().enumerate() {
                out.add(i as usize, behind.get(k) * (1.0 - covered[i as usize]));
            }
        }
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

    fn is_solid(&self) -> bool {
        self.coverage.is_none() && self.surface.is_solid()
    }

    fn is_opaque(&self) -> bool {
        self.coverage.is_none() && self.surface.is_opaque()
    }

    fn scatter(&self, hits: &SurfaceBatch, out: &mut Vec<Scattering>) -> bool {
        let first = out.len();
        if !self.surface.scatter(hits, out) {
            return false;
        }
        for (i, point) in out[first..].iter_mut().enumerate() {
            if let Some(emission) = self.emission.as_ref().filter(|_| hits.front(i)) {
                point.emission += emission.at([hits.texcoord[0][i], hits.texcoord[1][i]]);
            }
            if let Some(coverage) = &self.coverage {
                point.coverage *= coverage.at_hit(hits, i);
            }
        }
        true
    }

    fn lambertian(&self) -> Option<Lambertian> {
        let surface = self.surface.lambertian().filter(|_| self.coverage.is_none())?;
        // Two emissions would have to be added up: nobody nests materials so.
        let emission = if surface.emission.is_none() { self.emission.clone() } else { return None };
        Some(Lambertian { emission, ..surface })
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        self.surface.albedo(hits, out);
    }

    fn albedo_detail(&self) -> Detail {
        self.surface.albedo_detail()
    }

    fn plain_albedo(&self) -> Option<PlainColor> {
        self.surface.plain_albedo()
    }

    fn attributes(&self) -> &[AttributeRequest] {
        self.surface.attributes()
    }
}
