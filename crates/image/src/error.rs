// SPDX-License-Identifier: GPL-3.0-or-later
//! Errors of pictures; each message gives the fault and, where it helps, the remedy. Messages contain no file
//! name unless stated: the caller of `decode` has it, `read` and `write` add it.
//! Tests: `file::tests`, which read the messages.

use std::path::{Path, PathBuf};

/// A failure with a picture.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A name that is none of ours; the user's mistake.
    #[error("unknown {what} '{name}'; valid are: {valid}")]
    UnknownName {
        /// The kind of the named item.
        what: &'static str,
        /// The name.
        name: String,
        /// The valid names, separated by commas.
        valid: String,
    },
    /// A file name whose ending names no format that can be written; the user's mistake.
    #[error("{}: unknown picture format; the name must end in one of: {valid}", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
        /// The valid endings, separated by commas.
        valid: String,
    },
    /// Bytes that begin like no known picture file.
    #[error("not a picture file; known formats are: {0}")]
    UnknownFormat(String),
    /// A broken, truncated or unsupported file.
    #[error("bad {format} data: {what}")]
    Corrupt {
        /// The format's name.
        format: &'static str,
        /// The fault.
        what: String,
    },
    /// A picture too large to be read.
    #[error("a picture of {width} x {height} pixels is too large; at most {limit} pixels can be read")]
    TooLarge {
        /// Declared columns.
        width: u64,
        /// Declared rows.
        height: u64,
        /// The limit that it breaks.
        limit: u64,
    },
    /// A picture that takes more memory than its file's length or the caller allows.
    #[error(
        "a picture of {width} x {height} pixels takes {} MiB while it is read, but at most {} MiB may be taken; store it smaller or with fewer bits",
        needed.div_ceil(1 << 20), limit >> 20
    )]
    TooMuchMemory {
        /// Declared columns.
        width: u64,
        /// Declared rows.
        height: u64,
        /// Bytes that reading it takes.
        needed: u64,
        /// Bytes that may be taken.
        limit: u64,
    },
    /// The caller makes no further part of the picture.
    #[error("stopped before the picture was whole")]
    Stopped,
    /// A picture whose parts do not fit together; the calling program's mistake.
    #[error("inconsistent picture: {0}")]
    Shape(String),
    /// Two pictures that cannot be compared pixel by pixel.
    #[error("sizes differ: {} x {} and {} x {} pixels", a[0], a[1], b[0], b[1])]
    SizesDiffer {
        /// Columns and rows of the first.
        a: [u32; 2],
        /// Columns and rows of the second.
        b: [u32; 2],
    },
    /// The system rejected a file operation.
    #[error("{}: {what}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The failed operation and the reason.
        what: String,
    },
    /// One of the other errors, in a file.
    #[error("{}: {error}", path.display())]
    In {
        /// The file.
        path: PathBuf,
        /// The fault in the file.
        error: Box<Error>,
    },
}

impl Error {
    /// Bad data of a format.
    pub(crate) fn corrupt(format: &'static str, what: impl Into<String>) -> Self {
        Self::Corrupt { format, what: what.into() }
    }

    /// This error, with the file that it is about.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        match self {
            named @ (Self::File { .. } | Self::In { .. } | Self::UnknownExtension { .. }) => named,
            error => Self::In { path: path.into(), error: Box::new(error) },
        }
    }

    /// A rejected operation on a file.
    pub(crate) fn file(path: &Path, what: &str, error: &std::io::Error) -> Self {
        Self::File { path: path.into(), what: format!("{what}: {}", system_reason(error)) }
    }

    /// Bytes that could not be read.
    pub(crate) fn reading(error: std::io::Error) -> Self {
        let what = match error.kind() {
            std::io::ErrorKind::UnexpectedEof => "the file ends too early".into(),
            _ => format!("cannot be read: {}", system_reason(&error)),
        };
        Self::Corrupt { format: "picture", what }
    }
}

/// The system's message, in lower case, without its number.
#[must_use]
pub fn system_reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    let message = text.split(" (os error").next().unwrap_or_default();
    // Custom errors wrap the system's in more words, such as the name of a temporary file.
    let message = message.split(" at path").next().unwrap_or_default();
    let mut letters = message.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}
