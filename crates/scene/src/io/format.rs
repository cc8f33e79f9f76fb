// SPDX-License-Identifier: GPL-3.0-or-later
//! Which scene format a file has, by its name. Tests: `tests/broken_files.rs`.

use std::path::Path;

use super::error::{Error, ErrorKind, quoted};

/// Scene formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ with its MTL libraries.
    Obj,
    /// Stanford PLY, text or binary.
    Ply,
    /// glTF 2.0 as text.
    Gltf,
    /// glTF 2.0 as one binary file.
    Glb,
}

impl Format {
    /// The format that the extension of `path` names, in any case.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("obj") => Ok(Self::Obj),
            Some("ply") => Ok(Self::Ply),
            Some("gltf") => Ok(Self::Gltf),
            Some("glb") => Ok(Self::Glb),
            other => {
                let problem = match other {
                    Some(other) => format!("unknown scene format {}", quoted(&format!(".{other}"))),
                    None => "no extension says which scene format it has".to_owned(),
                };
                let kind = ErrorKind::UnknownFormat;
                Err(Error {
                    kind,
                    ..Error::data(path, None, problem, "valid are .obj, .ply, .gltf and .glb")
                })
            }
        }
    }
}
