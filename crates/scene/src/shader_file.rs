// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders that a scene's file names for its materials, unparsed: the renderer's caller compiles them. glTF:
//! `extras` of a material, `{"gnurt": {"shader": "wood.osl", "parameters": {"scale": 2}}}`; MTL:
//! `gnurt_shader wood.osl scale=2 tint=1,0.5,0.2`. Tests: `tests/obj.rs`, `tests/gltf.rs`.

use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::id::TextureId;

/// A file in the shading language, and values for its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ShaderFile {
    /// The file; of a shader in memory the name that messages call it.
    pub file: PathBuf,
    /// The source text of a shader in memory, which a reader has made.
    pub text: Option<Arc<str>>,
    /// Textures of the scene by the names that the shader calls them.
    pub pictures: Vec<(String, TextureId)>,
    /// Names and values: numbers between commas, or texts.
    pub parameters: Vec<(String, String)>,
    /// The folder that it and all that it names must be in; `None` = anywhere.
    pub confined_to: Option<PathBuf>,
}
