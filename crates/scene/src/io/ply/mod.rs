// SPDX-License-Identifier: GPL-3.0-or-later
//! Stanford PLY: text, little and big endian.
//! Source: G. Turk, The PLY polygon file format, 1994; names of properties as written by common programs.
//!
//! ```text
//! file -> header (elements, properties) -> Numbers (one after the other, in any encoding) -> Body -> one mesh
//! ```
//!
//! Declared counts are compared with the file's length before memory is taken for them.
//! Vertex colours: integers are sRGB-encoded, floats are linear. The mesh gets one grey matte material.
//! Tests: `tests/ply.rs`, `tests/{broken_files,mutations,benchmark_scenes}.rs`.

mod body;
mod columns;
mod header;
mod numbers;
mod rows;

use std::io::BufReader;
use std::path::Path;

use super::clean::clean_by;
use super::format::{Format, SceneWriter};
use super::origin::Origin;
use super::save::ply as save;
use super::source::{self, Access};
use super::{Error, Loaded, Oddity, Warnings};
use crate::material::{DEFAULT_ALBEDO, Material};
use crate::mesh::Mesh;
use crate::scene::Scene;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "PLY",
    extensions: &["ply"],
    notes: "one mesh; colours, normals, texture coordinates",
    read: Some(load),
    read_whole: true,
    says_up: false,
    write: Some(SceneWriter {
        save: save::save,
        companions: |_, _| Vec::new(),
        has_materials: false,
        has_animations: false,
        has_strands: false,
        is_whole: true,
    }),
};

/// Reads the mesh of a PLY file that another file names; its material is not set.
///
/// # Errors
/// If the file cannot be read.
pub fn read_mesh(path: &Path, access: &Access, warnings: &mut Warnings) -> Result<Mesh, Error> {
    let (file, length) = access.open(path)?;
    mesh_of(file, length, path, (access, &mut Origin::FIXED.clone()), warnings)
}

/// The same of a PLY file in memory; `path` is for messages.
///
/// # Errors
/// If it cannot be read.
pub fn read_mesh_from(
    bytes: &[u8],
    path: &Path,
    access: &Access,
    warnings: &mut Warnings,
) -> Result<Mesh, Error> {
    mesh_of(bytes, bytes.len() as u64, path, (access, &mut Origin::FIXED.clone()), warnings)
}

fn mesh_of(
    file: impl std::io::Read,
    length: u64,
    path: &Path,
    (access, origin): (&Access, &mut Origin),
    warnings: &mut Warnings,
) -> Result<Mesh, Error> {
    access.budget.add_file(length);
    let mut input = BufReader::with_capacity(1 << 16, std::io::Read::take(file, length));
    let header = header::read(&mut input, length, path, warnings)?;
    header.check_length(path)?;
    let mut mesh = body::read(&mut input, &header, path, (&access.budget, origin), warnings)?;
    mesh.name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    clean_by(&mut mesh, path, warnings, access.threads());
    Ok(mesh)
}

/// Loads a PLY file as one mesh.
fn load(path: &Path, access: &Access) -> Result<Loaded, Error> {
    let (file, length) = source::open(path)?;
    let mut warnings = Warnings::default();
    let mut origin = Origin::default();
    let mut mesh = mesh_of(file, length, path, (access, &mut origin), &mut warnings)?;
    let name = mesh.name.clone();

    let mut scene = Scene::new();
    mesh.material = scene.add_material(Material::matte(name.clone(), [DEFAULT_ALBEDO; 3]));
    if mesh.indices.is_empty() {
        if !mesh.positions.is_empty() {
            warnings.note(Oddity::PointsOrLines, path, None, format!("{} points", mesh.positions.len()));
        }
    } else {
        let mesh = scene.add_mesh(mesh);
        let object = scene.add_object_of(name, vec![mesh]);
        scene.instantiate(object, origin.file_from_mesh());
    }
    Ok(Loaded { scene, warnings, files: vec![path.to_owned()] })
}
