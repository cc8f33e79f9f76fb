// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials by specular colour and glossiness, as plastic with a reflection of its own.
//! Source: KHR_materials_pbrSpecularGlossiness (archived). Its reflectance at normal incidence is that of
//! plastic of index 1.5 times KHR_materials_specular's colour; roughness is 1 minus glossiness. Tests:
//! `tests/extensions.rs::specular_and_gloss_become_plastic`.

use std::sync::Arc;

use super::json::SpecularGlossiness;
use gnurt_scene::factors::Factors;
use gnurt_scene::texture::{TexelData, Texels};

/// Reflectance of plastic of index 1.5 at normal incidence.
const PLASTIC: f32 = 0.04;

/// Writes the numbers of the model; textures are the caller's.
pub(super) fn set_factors(from: &SpecularGlossiness, to: &mut Factors) {
    to.base_color = from.diffuse_factor;
    to.metallic = 0.0;
    to.roughness = 1.0 - from.glossiness_factor;
    to.ior = 1.5;
    to.specular = 1.0;
    to.specular_color = from.specular_factor.map(|reflectance| reflectance / PLASTIC);
}

/// Bytes of [`roughness`] of a picture.
pub(super) fn roughness_bytes(from: &Texels) -> usize {
    4 * from.width as usize * from.height as usize
}

/// The roughness, in green, of a picture whose alpha is multiplied to the glossiness.
pub(super) fn roughness(from: &Texels, glossiness: f32) -> Arc<Texels> {
    let size = [from.width as usize, from.height as usize];
    let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let rough = all.map(|(x, y)| {
        let roughness = (1.0 - glossiness * from.texel(x, y)[3]).clamp(0.0, 1.0);
        [0, (roughness * 255.0).round() as u8, 0, 255]
    });
    let data = TexelData::Linear8(rough.collect());
    Arc::new(Texels { width: from.width, height: from.height, data })
}
