// SPDX-License-Identifier: GPL-3.0-or-later
//! Errors of shaders and groups.

use std::path::PathBuf;

/// Why a shader or a group cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is no shader; each message has its file, line and column, and ends with a line end. Folders of `include` that do
    /// not exist follow.
    #[error("{}", .0.concat().trim_end())]
    Compile(Vec<String>),
    /// A file cannot be read.
    #[error("{}: {why}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's words.
        why: String,
    },
    /// A compiled shader (`.oso`) is damaged or of another version.
    #[error("{name}: {why}")]
    Compiled {
        /// Its name.
        name: String,
        /// The fault, with its line.
        why: String,
    },
    /// A layer, parameter, connection or output of a group is wrong.
    #[error("group '{group}': {why}")]
    Group {
        /// The group's name.
        group: String,
        /// The fault.
        why: String,
    },
}
