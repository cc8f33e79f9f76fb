// SPDX-License-Identifier: GPL-3.0-or-later
//! Permissions and limits of a scene while it is loaded. Tests: `tests/confine.rs`, crates/usd/tests/composition.rs.

use std::path::PathBuf;

use gnurt_image::TileCache;

/// Permissions and limits of a scene while it is loaded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// The folder below which the files that the scene names (libraries, textures, buffers) must lie, links followed;
    /// `None` = anywhere. The scene's own file is the caller's choice.
    pub confine: Option<PathBuf>,
    /// The cache of files' textures, mostly on the disk; `None` = all in memory.
    pub tiles: Option<TileCache>,
    /// The moment in seconds at which a format is read that is read at a moment (USD); `None` = at rest.
    pub at: Option<f64>,
    /// Variants that take the place of those that the file chooses.
    pub variants: Vec<VariantChoice>,
    /// How often subdivision surfaces are refined; `None` = [`subdivision::LEVEL`](crate::subdivision::LEVEL).
    pub subdivision: Option<u32>,
    /// Whether the first warning is an error.
    pub strict: bool,
}

/// One variant of a set of variants, by names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VariantChoice {
    /// The path of what has the set: `/World/Chair`; empty where the variants are the whole file's (glTF).
    pub prim: String,
    /// The set; empty where the file has one.
    pub set: String,
    /// The variant.
    pub variant: String,
}
