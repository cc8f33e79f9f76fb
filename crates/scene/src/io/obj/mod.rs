// SPDX-License-Identifier: GPL-3.0-or-later
//! Wavefront OBJ and MTL.
//! Source: Wavefront, Advanced Visualizer manual, appendix B1 (OBJ) and MTL 4.2.
//!
//! ```text
//! file -> blocks of LogicalLines -> Statements -> Lists, Parts (faces by material) -> one mesh per material
//! ```
//!
//! Groups, objects and smoothing are ignored. Tests: `tests/obj.rs`, `tests/broken_files.rs`,
//! `tests/growth.rs`.

mod batch;
mod blocks;
mod directives;
mod maps;
mod material;
mod mtl;
mod normals;
mod parts;
mod plain;
mod statements;

use std::io::Read;
use std::path::Path;

use statements::Statements;

use super::format::{Format, SceneWriter};
use super::save::obj as save;
use super::source::{self, Access};
use super::{Error, Loaded, Warnings};
use crate::scene::Scene;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "OBJ with MTL",
    extensions: &["obj"],
    notes: "polygons and vertex colours (linear, `v X Y Z R G B`)",
    read: Some(load),
    read_whole: true,
    says_up: false,
    write: Some(SceneWriter {
        save: save::save,
        companions: save::companion_files,
        has_materials: true,
        has_animations: false,
        has_strands: false,
        is_whole: true,
    }),
};

/// Loads an OBJ file and its libraries.
fn load(path: &Path, access: &Access) -> Result<Loaded, Error> {
    let (file, length) = source::open(path)?;
    access.budget.add_file(length);
    let mut warnings = Warnings::default();
    let Statements { lists, parts, library, origin, .. } =
        Statements::read(file.take(length), path, length, access, &mut warnings)?;

    let mut scene = Scene::new();
    let (materials, pictures) = material::add_all(&library, access, &mut scene, &mut warnings)?;
    let meshes = parts.into_meshes(&lists, &materials, &scene, (path, access.threads()), &mut warnings);
    drop(lists);
    let meshes: Vec<_> = meshes.into_iter().map(|mesh| scene.add_mesh(mesh)).collect();
    if !meshes.is_empty() {
        let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let object = scene.add_object_of(name, meshes);
        scene.instantiate(object, origin.file_from_mesh());
    }
    let mut files = vec![path.to_owned()];
    files.extend(library.read);
    files.extend(pictures);
    files[1..].sort_unstable();
    Ok(Loaded { scene, warnings, files })
}
