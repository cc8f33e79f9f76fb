// SPDX-License-Identifier: GPL-3.0-or-later
//! Perfect mirrors, on both sides.
//! Source: [Whi80]. Proof: crates/render/tests/mirrors.rs.

use crate::batch::{Detail, SurfaceBatch, Vec3s};
use crate::bsdf::{Lobe, Model, Scattering};
use crate::materials::color::{PlainColor, TexturedColor};
use crate::materials::whitted;
use crate::shader::{SurfaceShader, Tracer};

/// A perfect mirror.
#[derive(Clone, Debug)]
pub struct Mirror {
    /// Share of light that is mirrored.
    pub reflectance: TexturedColor,
}

impl SurfaceShader for Mirror {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        whitted::shade(tracer, hits, self, out);
    }

    fn scatter(&self, hits: &SurfaceBatch, out: &mut Vec<Scattering>) -> bool {
        out.extend((0..hits.len()).map(|i| {
            let lobe = Lobe::Mirror { reflectance: self.reflectance.at_hit(hits, i) };
            let ns = hits.point(i).bent_normal(hits.facing_ns(i), -hits.ray_dir.get(i));
            Scattering::around(ns, Model::Lobe(lobe))
        }));
        true
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.reflectance.at_hit(hits, i)));
    }

    fn albedo_detail(&self) -> Detail {
        Detail::Color
    }

    fn plain_albedo(&self) -> Option<PlainColor> {
        self.reflectance.plain()
    }
}
