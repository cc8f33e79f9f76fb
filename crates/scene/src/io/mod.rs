// SPDX-License-Identifier: GPL-3.0-or-later
//! Scene files: OBJ with MTL, PLY, glTF 2.0.
//! See docs/reference/cli.md.
//! Nothing in a file makes a program panic, hang, or take memory that the file's own length does not account for.
//! Tests: `tests/{broken_files,mutations,benchmark_scenes}.rs`.

mod budget;
mod clean;
mod error;
mod format;
mod gltf;
mod lines;
mod loaded;
mod obj;
mod options;
mod ply;
mod polygon;
mod save;
mod source;
mod textures;
mod warnings;

use std::ffi::OsStr;
use std::path::Path;

pub use error::{Error, ErrorKind};
pub use format::Format;
pub use loaded::Loaded;
pub use options::LoadOptions;
pub use save::{save, saved_files};
pub use warnings::{Oddity, Warning, Warnings};

use source::Access;

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
