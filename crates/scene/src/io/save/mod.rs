// SPDX-License-Identifier: GPL-3.0-or-later
//! Writing scenes: OBJ with MTL, PLY, glTF.
//! Source: the formats' own specifications, see `io::{obj, ply, gltf}`.
//! Every file appears whole or not at all; files that the main one refers to are written before it.
//! What a format cannot hold is left out with a warning: OBJ and PLY hold neither instances (they are unfolded) nor
//! cameras nor lights, PLY holds no materials, glTF no environment. Proof: `tests/save.rs`.

mod gltf;
mod obj;
mod ply;
mod png;
mod world;

use std::path::{Path, PathBuf};

use super::{Error, Format, Oddity, Warnings};
use crate::scene::Scene;

/// Writes a scene; the extension of `path` says in which format. What was left out is in the warnings.
pub fn save(scene: &Scene, path: impl AsRef<Path>) -> Result<Warnings, Error> {
    let path = path.as_ref();
    let format = Format::of(path)?;
    scene
        .check()
        .map_err(|e| Error::data(path, None, e.to_string(), "the scene must be in order to be written"))?;
    let mut warnings = Warnings::default();
    match format {
        Format::Obj => obj::save(scene, path, &mut warnings)?,
        Format::Ply => ply::save(scene, path, &mut warnings)?,
        Format::Gltf | Format::Glb => gltf::save(scene, path, format, &mut warnings)?,
    }
    Ok(warnings)
}

/// Whether files can be written, as far as that can be known before the first of them is.
fn check_writable(paths: &[PathBuf]) -> Result<(), Error> {
    paths.iter().try_for_each(|path| gnurt_image::check_writable(path).map_err(|e| unwritable(path, &e)))
}

/// Writes one file whole.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    gnurt_image::replace_file(path, bytes).map_err(|e| unwritable(path, &e))
}

fn unwritable(path: &Path, error: &gnurt_image::Error) -> Error {
    match error {
        gnurt_image::Error::File { what, .. } => Error::io(path, what.clone(), ""),
        other => Error::io(path, format!("cannot be written: {other}"), ""),
    }
}

fn leave_out(count: usize, what: &str, path: &Path, warnings: &mut Warnings) {
    warnings.note_many(Oddity::NotShown, count as u64, path, None, what);
}
