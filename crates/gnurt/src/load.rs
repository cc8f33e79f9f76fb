// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes by name: a file, or one that the program contains.
//! Tests: `tests::builtin_and_files`.

use std::ffi::OsStr;

#[cfg(not(all(feature = "gltf", feature = "pbrt", feature = "usd")))]
use crate::absent;
use crate::scene::io;

pub use io::{LoadOptions, Loaded};

/// The scene formats: those of [`scene::io`](crate::scene::io), and those of other crates, one line each.
/// Formats that were not compiled into this build are there, too: files of them are errors that tell how to get it.
pub const FORMATS: io::Formats = io::FORMATS.with(&[
    #[cfg(feature = "gltf")]
    &gnurt_gltf::TEXT,
    #[cfg(feature = "gltf")]
    &gnurt_gltf::BINARY,
    #[cfg(not(feature = "gltf"))]
    &absent::GLTF_TEXT,
    #[cfg(not(feature = "gltf"))]
    &absent::GLTF_BINARY,
    #[cfg(feature = "pbrt")]
    &gnurt_pbrt::FORMAT,
    #[cfg(not(feature = "pbrt"))]
    &absent::PBRT,
    #[cfg(feature = "usd")]
    &gnurt_usd::FORMAT,
    #[cfg(not(feature = "usd"))]
    &absent::USD,
]);

/// The prefix of built-in scenes' names.
pub const BUILTIN: &str = io::BUILTIN_PREFIX;

/// Names and descriptions of the built-in scenes.
pub fn builtin_scenes() -> impl Iterator<Item = (&'static str, &'static str)> {
    crate::scene::builtin::ALL.iter().map(|builtin| (builtin.name, builtin.description))
}

/// Names of the built-in scenes, without `builtin:`.
#[must_use]
pub fn builtin_names() -> Vec<&'static str> {
    builtin_scenes().map(|(name, _)| name).collect()
}

/// Loads a scene: `builtin:NAME`, or a path whose extension determines the format.
///
/// # Errors
/// [`io::Error`] gives file, line, fault and remedy; an unknown `builtin:` name is
/// [`io::ErrorKind::UnknownName`].
pub fn load_scene(source: impl AsRef<OsStr>) -> Result<Loaded, io::Error> {
    FORMATS.load_source(source, &LoadOptions::default())
}

/// As [`load_scene`], within the permissions and limits of `options`.
///
/// ```
/// let options = gnurt::LoadOptions { confine: Some(".".into()), ..Default::default() };
/// let loaded = gnurt::load_scene_with("builtin:cornell", &options)?;
/// assert!(loaded.files.is_empty(), "it names no files");
/// # Ok::<(), gnurt::scene::io::Error>(())
/// ```
///
/// # Errors
/// As [`load_scene`]. A forbidden file is an error for buffers, and a warning for material libraries and
/// textures, as a missing one is.
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
