// SPDX-License-Identifier: GPL-3.0-or-later
//! Why an instance cannot be placed in a scene.
//! Source: original. Proof: `tests/nested.rs`.

use std::fmt;

use super::types::DEEPEST_SCENE;

/// What is wrong with an instance; `inst_id` is its place in the list. All are the caller's to mend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneError {
    /// Its transform has no inverse in floats, or a value that is not finite.
    NoInverse {
        /// The instance.
        inst_id: u32,
    },
    /// More than [`DEEPEST_SCENE`](crate::DEEPEST_SCENE) scenes would lie in one another.
    TooDeep {
        /// The instance.
        inst_id: u32,
    },
    /// The scene would show more than 2^32 - 2 objects, those of nested scenes counted as often as they are seen.
    TooManyObjects {
        /// The instance.
        inst_id: u32,
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoInverse { inst_id } => {
                write!(f, "the transform of instance {inst_id} cannot be inverted")
            }
            Self::TooDeep { inst_id } => {
                write!(f, "with instance {inst_id} more than {DEEPEST_SCENE} scenes lie in one another")
            }
            Self::TooManyObjects { inst_id } => {
                write!(f, "with instance {inst_id} the scene shows more than 2^32 - 2 objects")
            }
        }
    }
}

impl std::error::Error for SceneError {}
