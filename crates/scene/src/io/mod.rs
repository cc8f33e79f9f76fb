// SPDX-License-Identifier: GPL-3.0-or-later
//! Scene files: the table of formats, and the readers and writers of OBJ with MTL, PLY, STL and 3MF.
//! See docs/reference/cli.md. Other crates read other formats by the parts in [`reader`].
//! No file makes a program panic, hang, or take memory out of proportion to the file's length.
//! Tests: `tests/{broken_files,mutations,benchmark_scenes}.rs`.

mod clean;
mod corner_numbers;
mod error;
mod format;
mod lines;
mod loaded;
mod obj;
mod options;
mod origin;
mod plain;
mod ply;
mod polygon;
pub mod reader;
mod save;
mod source;
mod stl;
mod textures;
mod threads;
mod threemf;
mod warnings;
pub mod writer;

use std::path::Path;

pub use error::{Error, ErrorKind};
pub use format::{BUILTIN_PREFIX, Format, Formats, ReadScene, SceneWriter};
pub use loaded::Loaded;
pub use options::{LoadOptions, UpAxis, VariantChoice};
pub use warnings::{Oddity, Warning, Warnings};

use crate::scene::Scene;

/// The formats of this crate. A program that reads the formats of other crates too has a table with them.
pub const FORMATS: Formats = Formats::new(&[&obj::FORMAT, &ply::FORMAT, &stl::FORMAT, &threemf::FORMAT]);

/// Loads a file of one of this crate's formats.
///
/// # Errors
/// As [`Formats::load`].
pub fn load(path: impl AsRef<Path>) -> Result<Loaded, Error> {
    FORMATS.load(path, &LoadOptions::default())
}

/// Writes a scene in one of this crate's formats.
///
/// # Errors
/// As [`Formats::save`].
pub fn save(scene: &Scene, path: impl AsRef<Path>) -> Result<Warnings, Error> {
    FORMATS.save(scene, path)
}
