// SPDX-License-Identifier: GPL-3.0-or-later
//! Wavefront OBJ and MTL, read by `tobj`.
//! Source: Wavefront, Advanced Visualizer manual, appendix B1 (OBJ) and MTL 4.2.
//!
//! ```text
//! file -> LogicalLines -> Normalizer (checks, resolves, simplifies) -> tobj -> Assembler -> one mesh per material
//! ```
//!
//! `tobj` says neither where a mistake is nor goes on after one. So the [`Normalizer`] stands before it: it checks every
//! statement, knows its line, and hands on a plain dialect in which nothing is left to go wrong.
//! Proof: `tests/obj.rs`, `tests/broken_files.rs`.

mod assemble;
mod directives;
mod material;
mod mtl;
mod normalize;

use std::io::{BufReader, Read};
use std::path::Path;

use assemble::Assembler;
use normalize::Normalizer;

use super::lines::LogicalLines;
use super::{Error, Loaded, Warnings, source};
use crate::affine::Affine;
use crate::scene::Scene;

/// `tobj` neither cuts polygons (we look at their shape) nor keeps separate indices.
const OPTIONS: tobj::LoadOptions =
    tobj::LoadOptions { triangulate: false, single_index: true, ignore_lines: true, ignore_points: true };

/// Loads an OBJ file and its libraries.
pub(super) fn load(path: &Path) -> Result<Loaded, Error> {
    let (file, length) = source::open(path)?;
    let lines = LogicalLines::new(BufReader::with_capacity(1 << 16, file.take(length)), path);
    let mut warnings = Warnings::default();
    let mut normalizer = Normalizer::new(lines, path, &mut warnings);
    let parsed = tobj::load_obj_buf(&mut BufReader::new(&mut normalizer), &OPTIONS, |_| {
        Err(tobj::LoadError::ReadError)
    });
    let library = normalizer.finish()?;
    let (models, _) = parsed.map_err(|e| Error::data(path, None, e.to_string(), ""))?;

    let mut scene = Scene::new();
    let (materials, pictures) = material::add_all(&library, &mut scene, &mut warnings);
    let mut assembler = Assembler::new(materials.len());
    assembler.reserve(&models);
    for model in models {
        assembler.add(model);
    }
    let meshes: Vec<_> = assembler
        .finish(&materials, &scene, path, &mut warnings)
        .into_iter()
        .map(|m| scene.add_mesh(m))
        .collect();
    if !meshes.is_empty() {
        let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let object = scene.add_object_of(name, meshes);
        scene.instantiate(object, Affine::IDENTITY);
    }
    let mut files = vec![path.to_owned()];
    files.extend(library.read);
    files.extend(pictures);
    files[1..].sort_unstable();
    Ok(Loaded { scene, warnings, files })
}
