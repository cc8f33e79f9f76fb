// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures as PNG files. Bytes stay the bytes they were; floats get 16 bits, those of colours sRGB-encoded.
//! Tests: `tests/save.rs::{textures_come_back, measures_stay_linear}`.

use std::collections::HashSet;
use std::path::Path;

use crate::id::TextureId;
use crate::io::Error;
use crate::material::{Material, TextureRole};
use crate::scene::Scene;
use crate::texture::Texels;

/// The textures of a scene that hold measures (heights, normals, roughness, opacity), not colours.
pub fn measures(scene: &Scene) -> HashSet<TextureId> {
    let used = scene.materials().iter().flat_map(Material::textures);
    used.filter(|(_, role)| *role == TextureRole::Data).map(|(used, _)| used.texture).collect()
}

/// The bytes of a PNG file.
///
/// # Errors
/// If the picture cannot be a PNG file; the message names `path`.
pub fn encode(texels: &Texels, measures: bool, path: &Path) -> Result<Vec<u8>, Error> {
    gnurt_image::encode_texels(texels, measures)
        .map_err(|e| Error::io(path, format!("a texture cannot be written: {e}"), ""))
}
