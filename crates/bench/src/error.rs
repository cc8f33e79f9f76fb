// SPDX-License-Identifier: GPL-3.0-or-later
//! Errors that end a benchmark early.

/// Why there are no numbers.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The options leave nothing to do: the user's mistake.
    #[error("no mode matches; valid are: {}", .valid.join(", "))]
    NothingToDo {
        /// Names of all valid modes.
        valid: Vec<String>,
    },
    /// A library that is not there, not Embree 4, or that failed.
    #[error("{library}: {why}")]
    Embree {
        /// The file that was named.
        library: String,
        /// The fault.
        why: String,
    },
    /// A scene that no ray can be sent into.
    #[error("{scene}: {why}")]
    Scene {
        /// Its name.
        scene: String,
        /// The missing part.
        why: String,
    },
    /// A structure that is not compiled in.
    #[error("this program has no {structure}: build it with --features research")]
    NoResearch {
        /// Its name.
        structure: String,
    },
    /// Two engines answered the same rays differently: fast and wrong is not fast.
    #[error("answers differ: {0}")]
    Differ(String),
}
