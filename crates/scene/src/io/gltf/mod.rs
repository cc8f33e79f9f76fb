// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF 2.0, text and binary.
//! Source: Khronos, glTF 2.0 specification; KHR_lights_punctual, KHR_materials_{emissive_strength, ior, transmission,
//! unlit}, KHR_texture_transform, KHR_mesh_quantization, EXT_texture_webp.
//!
//! ```text
//! file -> container (JSON, binary chunk) -> Document (buffers) -> materials, meshes -> nodes: instances, cameras, lights
//! ```
//!
//! Every index is looked up where it is used, and what nobody uses is not looked at (see `json`).
//! Each glTF mesh becomes one object, each node that shows it one instance; what a skin or morph weights bend becomes an
//! object of its own, in its rest pose. Space: +Y up, metres, as here. Proof: `tests/gltf.rs`.

mod accessor;
mod base64;
mod container;
mod document;
mod json;
mod material;
mod mesh;
mod nodes;
mod primitive;
mod skin;

use std::path::Path;

use document::Document;

use super::source::{self, Access};
use super::{Error, Format, Loaded, Oddity, Warnings};
use crate::scene::Scene;

/// Loads a glTF file and all that it refers to.
pub(super) fn load(path: &Path, format: Format, access: &Access) -> Result<Loaded, Error> {
    let bytes = source::read(path)?;
    access.budget.add_file(bytes.len() as u64);
    let mut warnings = Warnings::default();
    let document = Document::new(path, &bytes, format, access, &mut warnings)?;

    let mut scene = Scene::new();
    let materials = material::add_all(&document, &mut scene, &mut warnings)?;
    nodes::add_all(&document, &materials, &mut scene, &mut warnings)?;
    let animations = document.root.animations.0;
    warnings.note_many(Oddity::NotShown, animations, path, None, "animation, shown in its rest pose");
    let files = document.files();
    Ok(Loaded { scene, warnings, files })
}
