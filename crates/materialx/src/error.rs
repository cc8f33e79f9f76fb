// SPDX-License-Identifier: GPL-3.0-or-later
//! Faults of documents, by file and line.

use std::fmt;
use std::path::{Path, PathBuf};

/// A fault of a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    file: PathBuf,
    line: u32,
    message: String,
}

impl Error {
    /// A fault; line 0 is the whole file.
    pub(crate) fn new(file: &Path, line: u32, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line, message: message.into() }
    }

    /// The line, from 1; 0 if it is about the whole file.
    #[must_use]
    pub fn line(&self) -> u32 {
        self.line
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => write!(f, "{}: {}", self.file.display(), self.message),
            line => write!(f, "{}:{line}: {}", self.file.display(), self.message),
        }
    }
}

impl std::error::Error for Error {}
