// SPDX-License-Identifier: GPL-3.0-or-later
//! Writing scenes: OBJ with MTL, PLY, glTF.
//! Source: the formats' own specifications, see `io::{obj, ply, gltf}`.
//! Every file appears whole or not at all; files that the main one refers to are written before it.
//! What a format cannot hold is left out with a warning: OBJ and PLY hold neither instances (they are unfolded) nor
//! cameras nor lights, PLY holds no materials, glTF no environment; animations are not written. Tests: `tests/save.rs`.

mod files;
mod gltf;
mod losses;
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
    let clips = scene.animation().map_or(0, |animation| animation.clips.len());
    warnings.note_many(Oddity::NotShown, clips as u64, path, None, "animation, written as it is shown");
    losses::of_scene(scene, path, &mut warnings);
    if format != Format::Ply {
        losses::of_materials(scene, path, &mut warnings);
    }
    match format {
        Format::Obj => obj::save(scene, path, &mut warnings)?,
        Format::Ply => ply::save(scene, path, &mut warnings)?,
        Format::Gltf | Format::Glb => gltf::save(scene, path, format, &mut warnings)?,
    }
    Ok(warnings)
}

/// The files that [`save`] writes for this scene and path: the one named, and those beside it that it refers to. Whoever must not lose
/// what is there looks at them first.
pub fn saved_files(scene: &Scene, path: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let path = path.as_ref();
    let mut files = vec![path.to_owned()];
    match Format::of(path)? {
        Format::Obj => files.extend(obj::companion_files(scene, path)),
        Format::Gltf => files.push(gltf::buffer_file(path)),
        Format::Ply | Format::Glb => {}
    }
    Ok(files)
}
