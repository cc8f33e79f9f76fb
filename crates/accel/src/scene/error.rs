// SPDX-License-Identifier: GPL-3.0-or-later
//! Why there is no scene: an instance that cannot be placed, or a build that was stopped.
//! Tests: `tests/nested.rs`.

use std::fmt;

use super::types::DEEPEST_SCENE;
use crate::BuildError;

/// The fault; `inst_id` is an instance's index in the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneError {
    /// Its transform has no inverse in floats, or a value that is not finite.
    NoInverse {
        /// The instance.
        inst_id: u32,
    },
    /// More than [`DEEPEST_SCENE`](crate::DEEPEST_SCENE) levels of scenes.
    TooDeep {
        /// The instance.
        inst_id: u32,
    },
    /// The scene would show more than 2^32 - 2 objects, those of nested scenes counted as often as they are seen.
    TooManyObjects {
        /// The instance.
        inst_id: u32,
    },
    /// The build was stopped, or there are too many instances.
    Build(BuildError),
}

impl From<BuildError> for SceneError {
    fn from(error: BuildError) -> Self {
        Self::Build(error)
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoInverse { inst_id } => {
                write!(f, "the transform of instance {inst_id} cannot be inverted")
            }
            Self::TooDeep { inst_id } => {
                write!(f, "instance {inst_id}: scenes are nested more than {DEEPEST_SCENE} levels deep")
            }
            Self::TooManyObjects { inst_id } => {
                write!(f, "with instance {inst_id} the scene shows more than 2^32 - 2 objects")
            }
            Self::Build(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SceneError {}
