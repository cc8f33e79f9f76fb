// SPDX-License-Identifier: GPL-3.0-or-later
//! The error of files: the place, the fault and the remedy, in one line. See docs/reference/cli.md. Lines
//! count from 1.
//! Tests: `tests::one_line_whatever_the_file_says`, and every row of `tests/broken_files.rs`.

use std::fmt;
use std::path::{Path, PathBuf};

/// Whose mistake an error is; programs choose their exit status by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The caller's: a `builtin:` name that does not exist, or the name or value of a change.
    UnknownName,
    /// The caller's or the file's: a file that is not there, may not be read or written, or is no regular file.
    Io,
    /// A file name whose extension names no scene format.
    UnknownFormat,
    /// A fault of the file: its contents violate the format.
    Data,
}

/// A failure with a file; `Display` is one line without a newline: `FILE:LINE: fault; remedy`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Error {
    /// Whose mistake it is.
    pub kind: ErrorKind,
    /// The file (or the `builtin:` name).
    pub path: PathBuf,
    /// Its line, if the format has lines and the fault has a position.
    pub line: Option<u64>,
    /// The fault.
    pub problem: String,
    /// The remedy; may be empty.
    pub remedy: String,
}

impl Error {
    /// Contents that the format does not allow.
    pub fn data(
        path: &Path,
        line: Option<u64>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        let (problem, remedy) = (problem.into(), remedy.into());
        Self { kind: ErrorKind::Data, path: path.to_owned(), line, problem, remedy }
    }

    /// A file that cannot be opened, read or written.
    pub fn io(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind: ErrorKind::Io, ..Self::data(path, None, problem, remedy) }
    }

    /// The operating system's answer, in words.
    pub(crate) fn system(path: &Path, error: &std::io::Error) -> Self {
        use std::io::ErrorKind as E;
        let (problem, remedy) = match error.kind() {
            E::NotFound => ("no such file".into(), "check the path"),
            E::PermissionDenied => ("permission denied".into(), "it must be readable by you"),
            E::UnexpectedEof => {
                ("the file ends too early".into(), "it may have been cut off while it was copied")
            }
            _ => (gnurt_image::system_reason(error), ""),
        };
        Self::io(path, problem, remedy)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", printable(&self.path.to_string_lossy()))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}", printable(&self.problem))?;
        if !self.remedy.is_empty() {
            write!(f, "; {}", printable(&self.remedy))?;
        }
        Ok(())
    }
}

/// `text` without control characters, because text from a file must not move a terminal's cursor.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// A token of a file in quotation marks, shortened so that a message stays one readable line.
pub fn quoted(token: &str) -> String {
    const LONGEST: usize = 40;
    let token = printable(token);
    if token.chars().count() <= LONGEST {
        return format!("`{token}`");
    }
    let head: String = token.chars().take(LONGEST).collect();
    format!("`{head}…`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_whatever_the_file_says() {
        let error = Error::data(
            Path::new("a\nb.obj"),
            Some(7),
            format!("bad number {}", quoted(&"x\u{1b}[2J".repeat(99))),
            "expected `v X Y Z`",
        );
        let line = error.to_string();
        assert!(line.starts_with("a\u{fffd}b.obj:7: bad number `x"), "file, line, problem: {line}");
        assert!(line.ends_with("; expected `v X Y Z`"), "then the remedy: {line}");
        assert!(!line.contains(char::is_control), "nothing that moves a cursor: {line:?}");
        assert!(line.len() < 200, "a token is shortened: {line}");
    }
}
