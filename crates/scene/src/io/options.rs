// SPDX-License-Identifier: GPL-3.0-or-later
//! Permissions and limits of a scene while it is loaded. Tests: `tests/confine.rs`.

use std::path::PathBuf;

use gnurt_image::TileCache;

/// Permissions and limits of a scene while it is loaded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// The folder below which the files that the scene names (libraries, textures, buffers) must lie, links followed;
    /// `None` = anywhere. The scene's own file is the caller's choice.
    pub confine: Option<PathBuf>,
    /// The cache of files' textures, mostly on the disk; `None` = all in memory.
    pub tiles: Option<TileCache>,
}
