// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes by name: a file, or one that the program carries with it.
//! Tests: `tests::builtin_and_files`.

use std::ffi::OsStr;

use crate::scene::io;

pub use io::{LoadOptions, Loaded};

/// The scene formats: those of [`scene::io`](crate::scene::io), and those of other crates, one line each.
pub const FORMATS: io::Formats = io::FORMATS.with(&[
    #[cfg(feature = "usd")]
    &gnurt_usd::FORMAT,
]);

/// What the names of built-in scenes begin with.
pub const BUILTIN: &str = io::BUILTIN_PREFIX;

/// Names of the built-in scenes, and what each shows.
pub fn builtin_scenes() -> impl Iterator<Item = (&'static str, &'static str)> {
    crate::scene::builtin::ALL.iter().map(|builtin| (builtin.name, builtin.description))
}

/// Names of the built-in scenes, without `builtin:`.
#[must_use]
pub fn builtin_names() -> Vec<&'static str> {
    builtin_scenes().map(|(name, _)| name).collect()
}

/// Loads a scene: `builtin:NAME`, or a path whose extension says the format.
///
/// # Errors
/// [`io::Error`] says which file and line, what is wrong and what would be right; an unknown `builtin:` name is
/// [`io::ErrorKind::UnknownName`].
pub fn load_scene(source: impl AsRef<OsStr>) -> Result<Loaded, io::Error> {
    FORMATS.load_source(source, &LoadOptions::default())
}

/// As [`load_scene`], but the scene may only do what `options` allow.
///
/// ```
/// let options = gnurt::LoadOptions { confine: Some(".".into()), ..Default::default() };
/// let loaded = gnurt::load_scene_with("builtin:cornell", &options)?;
/// assert!(loaded.files.is_empty(), "it names no files");
/// # Ok::<(), gnurt::scene::io::Error>(())
/// ```
///
/// # Errors
/// As [`load_scene`]. A file that the scene names but may not read is an error for buffers, and a warning for material
/// libraries and textures, as one that is not there is.
pub fn load_scene_with(source: impl AsRef<OsStr>, options: &LoadOptions) -> Result<Loaded, io::Error> {
    FORMATS.load_source(source, options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builtin_and_files() {
        assert!(builtin_names().contains(&"cornell"), "the box is built in");
        assert!(
            !load_scene("builtin:cornell").expect("it can be made").scene.meshes().is_empty(),
            "it has meshes"
        );
        let unknown = load_scene("builtin:cornel").expect_err("no such scene");
        assert_eq!(unknown.kind, io::ErrorKind::UnknownName, "{unknown}");
        let missing = load_scene("no/such/file.obj").expect_err("no such file");
        assert_eq!(missing.kind, io::ErrorKind::Io, "{missing}");
    }
}
