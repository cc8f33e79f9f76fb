// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures as PNG files. Bytes stay the bytes they were; floats get 16 bits, those of colours sRGB-encoded.
//! Source: original. Proof: `tests/save.rs::{textures_come_back, measures_stay_linear}`.

use std::collections::HashSet;
use std::path::Path;

use crate::id::TextureId;
use crate::io::Error;
use crate::material::{Alpha, OpacityChannel, Surface};
use crate::scene::Scene;
use crate::texture::Texels;

/// The textures of a scene that hold measures (normals, roughness, opacity), not colours.
pub(super) fn measures(scene: &Scene) -> HashSet<TextureId> {
    let mut found = HashSet::new();
    for material in scene.materials() {
        let (roughness, normals) = match &material.surface {
            Surface::MetallicRoughness { metallic_roughness_texture, normal_texture, .. } => {
                (*metallic_roughness_texture, *normal_texture)
            }
            Surface::Principled(p) => (p.metallic_roughness_texture, p.normal_texture),
            _ => (None, None),
        };
        let opacity = match material.alpha {
            Alpha::Mask { opacity, .. } | Alpha::Blend { opacity } => {
                opacity.texture.filter(|_| opacity.channel == OpacityChannel::Red)
            }
            Alpha::Opaque => None,
        };
        let brushed = match &material.surface {
            Surface::Principled(p) => p.anisotropy.texture,
            _ => None,
        };
        let used = [roughness, normals.map(|normals| normals.texture), opacity, brushed];
        found.extend(used.into_iter().flatten().map(|used| used.texture));
    }
    found
}

pub(super) fn encode(texels: &Texels, measures: bool, path: &Path) -> Result<Vec<u8>, Error> {
    gnurt_image::encode_texels(texels, measures)
        .map_err(|e| Error::io(path, format!("a texture cannot be written: {e}"), ""))
}
