// SPDX-License-Identifier: GPL-3.0-or-later
//! Why a file is not taken for a tree. Tests: `tests/saved.rs`.

use std::fmt;
use std::io;

/// Why [`ObjectTree::load`](crate::ObjectTree::load) has no tree to give. All but the first are the file's fault.
#[derive(Debug)]
#[non_exhaustive]
pub enum LoadError {
    /// The source could not be read.
    Io(io::Error),
    /// It does not start as a tree does.
    NotATree,
    /// A version that this crate does not support: the tree must be built again.
    Version(u32),
    /// It ends too early.
    Truncated,
    /// Its checksum does not match its contents.
    Checksum,
    /// Its contents are no tree that could have been built; the text names the fault.
    Damaged(&'static str),
    /// The crate was built without the feature of this name, which its structure needs.
    MissingFeature(&'static str),
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(error) => write!(f, "a saved tree cannot be read: {error}"),
            Self::NotATree => f.write_str("not a saved tree"),
            Self::Version(version) => {
                write!(f, "unsupported version {version} of a saved tree; valid is {}", super::data::VERSION)
            }
            Self::Truncated => f.write_str("a saved tree ends too early"),
            Self::Checksum => f.write_str("a saved tree does not have the checksum that it should have"),
            Self::Damaged(what) => write!(f, "a saved tree is damaged: {what}"),
            Self::MissingFeature(name) => {
                write!(f, "a saved tree needs the feature `{name}`, which this program lacks")
            }
        }
    }
}

impl std::error::Error for LoadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io(error) => Some(error),
            _ => None,
        }
    }
}

impl From<io::Error> for LoadError {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Self::Truncated,
            _ => Self::Io(error),
        }
    }
}
