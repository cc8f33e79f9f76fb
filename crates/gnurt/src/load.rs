// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes by name: a file, or one that the program carries with it.
//! Source: original. Proof: `tests::builtin_and_files`.

use std::ffi::OsStr;

use crate::scene::io;

pub use io::Loaded;

/// What the names of built-in scenes begin with.
pub const BUILTIN: &str = "builtin:";

/// Loads a scene: `builtin:NAME`, or a path whose extension says the format.
///
/// # Errors
/// [`io::Error`] says which file and line, what is wrong and what would be right; an unknown `builtin:` name is
/// [`io::ErrorKind::UnknownName`].
pub fn load_scene(source: impl AsRef<OsStr>) -> Result<Loaded, io::Error> {
    io::load(source.as_ref())
}
