// SPDX-License-Identifier: GPL-3.0-or-later
//! `TextureShader`: a surface that shows a texture, lit or not.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | texture | shader | 0 | radiance; 0 = white |
//!
//! Source: name and parameter as OpenRT programs know them. Tests: `tests::shows_texels`.

use std::sync::Arc;

use glam::Vec3;

use super::class::{Kind, Parameter, ShaderClass};
use super::shown::shown;
use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{RadianceShader, Tracer};
use crate::texture::TextureSampler;

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "TextureShader",
    kind: Kind::Surface,
    parameters: &[Parameter::texture("texture")],
    make: |values| shown(Texture { texture: values.texture(0) }, Vec::new()),
};

struct Texture {
    texture: Option<Arc<TextureSampler>>,
}

impl RadianceShader for Texture {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        texel_colors(self.texture.as_deref(), hits, out);
    }
}

/// Writes the texture's colour at each point; white without a texture.
pub(super) fn texel_colors(texture: Option<&TextureSampler>, hits: &SurfaceBatch, out: &mut Vec3s) {
    let Some(texture) = texture else {
        return out.reset(hits.len(), Vec3::ONE);
    };
    for i in 0..hits.len() {
        let [r, g, b, _] = texture.at_hit(hits, i);
        out.set(i, Vec3::new(r, g, b));
    }
}

#[cfg(test)]
mod tests {
    use gnurt_image::{TexelData, Texels};

    use super::super::probe::{Probe, floor, shade};
    use super::super::shown::Shown;
    use super::*;

    #[test]
    fn shows_texels() {
        let texels = Texels { width: 1, height: 1, data: TexelData::Linear8(vec![[255, 0, 51, 255]]) };
        let of = |texture| Shown { shader: Texture { texture }, attributes: Vec::new() };
        let texture = Arc::new(TextureSampler::new(Arc::new(texels)));
        let found = shade(&of(Some(texture)), &mut Probe::dark(), &floor());
        assert!((found - Vec3::new(1.0, 0.0, 0.2)).length() < 1e-6, "bytes are linear: {found}");
        assert_eq!(shade(&of(None), &mut Probe::dark(), &floor()), Vec3::ONE, "no texture is white");
    }
}
