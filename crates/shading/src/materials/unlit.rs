// SPDX-License-Identifier: GPL-3.0-or-later
//! An unlit colour, the same under any light and from both sides: drawings, backgrounds, photographs on
//! models.
//! Source: KHR_materials_unlit, which defines its appearance. Light from such a surface to others would
//! create energy, so rays from diffuse surfaces see black here; mirrors, glass and glossy surfaces show it.
//! Units: radiance, W·sr⁻¹·m⁻². Tests: crates/render/tests/unlit.rs.

use crate::batch::{RayKind, SurfaceBatch, Vec3s};
use crate::bsdf::ClosureBatch;
use crate::materials::color::TexturedColor;
use crate::shader::SurfaceShader;

/// A colour that is seen as it is.
#[derive(Clone, Debug)]
pub struct Unlit {
    /// Radiance, times the mesh's own colour.
    pub color: TexturedColor,
}

impl SurfaceShader for Unlit {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in (0..hits.len()).filter(|&i| hits.ray_kind(i) != RayKind::Diffuse) {
            out.emit(i, self.color.at_hit(hits, i));
        }
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.color.at_hit(hits, i)));
    }
}
