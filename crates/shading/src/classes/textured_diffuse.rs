// SPDX-License-Identifier: GPL-3.0-or-later
//! `TexturedDiffuseShader`: a textured Lambertian surface with shadows and ambient light.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | texture | shader | 0 | its colour; 0 = white |
//! | radiance | shader | 1 1 1 | ambient light, times the texture |
//!
//! Shows `T (radiance + sum over lights of E V max(0, n·l))` with T the texture and V the transmittance of
//! the shadow ray.
//! Source: name and parameters as OpenRT programs know them. Tests: `tests`.

use std::sync::Arc;

use glam::Vec3;

use super::class::{Kind, Parameter, ShaderClass};
use super::lambert::{Shadows, direct_light, normals_given, shading_normals};
use super::shown::shown;
use super::texture::texel_colors;
use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{RadianceShader, Tracer};
use crate::texture::TextureSampler;

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "TexturedDiffuseShader",
    kind: Kind::Surface,
    parameters: &[Parameter::texture("texture"), Parameter::floats("radiance", &[1.0; 3])],
    make: |values| {
        let (texture, ambient) = (values.texture(0), values.vec3(1));
        shown(TexturedDiffuse { texture, ambient }, vec![normals_given()])
    },
};

struct TexturedDiffuse {
    texture: Option<Arc<TextureSampler>>,
    ambient: Vec3,
}

impl RadianceShader for TexturedDiffuse {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let normals = shading_normals(hits, 0);
        let light = direct_light(tracer, hits, &normals, Shadows::Traced);
        texel_colors(self.texture.as_deref(), hits, out);
        (0..hits.len()).for_each(|i| out.set(i, out.get(i) * (self.ambient + light.get(i))));
    }
}

#[cfg(test)]
mod tests {
    use super::super::probe::{Probe, floor, shade};
    use super::super::shown::Shown;
    use super::*;

    #[test]
    fn adds_ambient_light_and_asks_for_shadows() {
        let shader = TexturedDiffuse { texture: None, ambient: Vec3::splat(0.25) };
        let shader = Shown { shader, attributes: vec![normals_given()] };
        let mut probe = Probe::lit(Vec3::Y, Vec3::ONE);
        assert_eq!(shade(&shader, &mut probe, &floor()), Vec3::splat(1.25), "ambient and direct");
        probe.transmittance = Vec3::new(0.0, 0.0, 1.0);
        let found = shade(&shader, &mut probe, &floor());
        assert_eq!(found, Vec3::new(0.25, 0.25, 1.25), "only what comes through");
    }
}
