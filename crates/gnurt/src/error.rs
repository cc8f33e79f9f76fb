// SPDX-License-Identifier: GPL-3.0-or-later
//! One error for programs that call several parts of the system and need one `?`. Messages are one line; the
//! kind of each names the cause.

use crate::size::format_bytes;
use crate::{image, render, scene};

/// Errors between a file and a picture.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene could not be read or written.
    #[error(transparent)]
    Scene(#[from] scene::io::Error),
    /// A scene does not hold together: the mistake of the program that made it.
    #[error(transparent)]
    Commit(#[from] render::CommitError),
    /// Options that leave nothing to render.
    #[error(transparent)]
    Render(#[from] render::RenderError),
    /// A picture could not be read, written or compared.
    #[error(transparent)]
    Image(#[from] image::Error),
    /// A sky in the shading language could not be read or compiled.
    #[error("{0}")]
    Surroundings(String),
    /// A volume could not be shown.
    #[error("{0}")]
    Volume(String),
    /// The picture needs more memory than the machine has free.
    #[error(
        "the picture takes {} of memory and {} are free; use a smaller one than {}x{}",
        format_bytes(*needed), format_bytes(*free), size[0], size[1]
    )]
    Memory {
        /// Columns and rows.
        size: [u32; 2],
        /// Bytes that it takes.
        needed: u64,
        /// Bytes that are left.
        free: u64,
    },
    /// The system did not start the requested threads.
    #[error("cannot start {threads} threads: {why}")]
    Threads {
        /// The requested number.
        threads: usize,
        /// The system's message.
        why: String,
    },
}
