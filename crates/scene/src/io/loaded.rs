// SPDX-License-Identifier: GPL-3.0-or-later
//! The result of loading.

use std::path::PathBuf;

use super::warnings::Warnings;
use crate::scene::Scene;

/// A scene and the oddities of its file.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// Warnings about its file.
    pub warnings: Warnings,
    /// All files that it was read from, those included that are missing; empty for built-in scenes.
    pub files: Vec<PathBuf>,
}
