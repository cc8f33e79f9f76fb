// SPDX-License-Identifier: GPL-3.0-or-later
//! Scene files: OBJ with MTL, PLY, glTF 2.0.
//! Source: original; what is an error and what a warning is the contract of the command line.
//! Nothing in a file makes a program panic, hang, or take memory that the file's own length does not account for.
//! Proof: `tests/{broken_files,mutations,benchmark_scenes}.rs`.

mod budget;
mod clean;
mod error;
mod gltf;
mod lines;
mod obj;
mod options;
mod ply;
mod polygon;
mod save;
mod source;
mod textures;
mod warnings;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

pub use error::{Error, ErrorKind};
pub use options::LoadOptions;
pub use save::save;
pub use warnings::{Oddity, Warning, Warnings};

use source::Access;

use crate::scene::Scene;

/// A scene and the oddities of its file.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// What was odd about its file.
    pub warnings: Warnings,
    /// All files that it was read from, those included that are missing; empty for built-in scenes.
    pub files: Vec<PathBuf>,
}

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
                    Some(other) => format!("unknown scene format {}", error::quoted(&format!(".{other}"))),
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

/// Loads a scene file; its extension says which format it has.
pub fn load(path: impl AsRef<Path>) -> Result<Loaded, Error> {
    load_with(path, &LoadOptions::default())
}

/// Loads a scene file that may do what `options` allow.
pub fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, Error> {
    let path = path.as_ref();
    let access = Access::new(options)?;
    let mut loaded = match Format::of(path) {
        Ok(Format::Obj) => obj::load(path, &access),
        Ok(Format::Ply) => ply::load(path, &access),
        Ok(format @ (Format::Gltf | Format::Glb)) => gltf::load(path, format, &access),
        // A path that is not there is the more helpful thing to say.
        Err(unknown) => Err(source::open(path).err().unwrap_or(unknown)),
    }?;
    if loaded.scene.meshes().iter().all(|mesh| mesh.indices.is_empty()) {
        loaded.warnings.note(Oddity::EmptyScene, path, None, "");
    }
    Ok(loaded)
}

/// What a `builtin:` source begins with.
pub const BUILTIN_PREFIX: &str = "builtin:";

/// Loads `builtin:NAME` or else a scene file.
pub fn load_source(source: impl AsRef<OsStr>) -> Result<Loaded, Error> {
    load_source_with(source, &LoadOptions::default())
}

/// Loads `builtin:NAME` or else a scene file that may do what `options` allow.
pub fn load_source_with(source: impl AsRef<OsStr>, options: &LoadOptions) -> Result<Loaded, Error> {
    let source = source.as_ref();
    let Some(name) = source.to_str().and_then(|text| text.strip_prefix(BUILTIN_PREFIX)) else {
        return load_with(source, options);
    };
    let scene = crate::builtin::load(name).ok_or_else(|| {
        let problem = "no built-in scene has this name";
        let remedy = crate::builtin::suggestion(name);
        Error { kind: ErrorKind::UnknownName, ..Error::data(Path::new(source), None, problem, remedy) }
    })?;
    Ok(Loaded { scene, ..Loaded::default() })
}
