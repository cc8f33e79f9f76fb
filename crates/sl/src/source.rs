// SPDX-License-Identifier: GPL-3.0-or-later
//! Source files and positions in them.
//!
//! A position is a file's number in the [`Sources`] and a byte in that file; lines and columns are computed
//! when they are printed.

use std::sync::Arc;

/// A stretch of a source file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Loc {
    /// Number of the file; `u16::MAX` is no file.
    pub file: u16,
    /// Length in bytes.
    pub len: u16,
    /// First byte.
    pub start: u32,
    /// Line, from 1, after `#line`.
    pub line: u32,
}

impl Loc {
    /// No position.
    pub const NONE: Self = Self { file: u16::MAX, len: 0, start: 0, line: 0 };
}

/// One text.
#[derive(Clone, Debug)]
pub struct File {
    /// The name that messages show.
    pub name: Arc<str>,
    /// The whole text.
    pub text: Arc<str>,
    /// Whether the compiler brought it, not the user.
    pub system: bool,
}

/// All files of a compilation.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<File>,
}

impl Sources {
    /// Adds a file. None when there are too many of them.
    pub fn add(&mut self, name: &str, text: &str, system: bool) -> Option<u16> {
        let number = u16::try_from(self.files.len()).ok().filter(|&n| n < u16::MAX)?;
        self.files.push(File { name: name.into(), text: text.into(), system });
        Some(number)
    }

    /// Adds a name for a part of a file, as `#line` gives it.
    pub fn rename(&mut self, of: u16, name: &str) -> Option<u16> {
        let text = self.get(of)?.text.clone();
        let number = u16::try_from(self.files.len()).ok().filter(|&n| n < u16::MAX)?;
        self.files.push(File { name: name.into(), text, system: false });
        Some(number)
    }

    /// A file by number.
    #[must_use]
    pub fn get(&self, file: u16) -> Option<&File> {
        self.files.get(usize::from(file))
    }

    /// All files.
    #[must_use]
    pub fn files(&self) -> &[File] {
        &self.files
    }

    /// The name of a place's file; empty when there is none.
    #[must_use]
    pub fn name(&self, loc: Loc) -> &str {
        self.get(loc.file).map_or("", |f| &f.name)
    }

    /// The whole line of a position, and the byte it starts at.
    #[must_use]
    pub fn line_text(&self, loc: Loc) -> Option<(&str, usize)> {
        let text = &*self.get(loc.file)?.text;
        let at = (loc.start as usize).min(text.len());
        let first = text.as_bytes()[..at].iter().rposition(|&b| b == b'\n').map_or(0, |p| p + 1);
        let last = text.as_bytes()[at..].iter().position(|&b| b == b'\n').map_or(text.len(), |p| at + p);
        Some((text.get(first..last)?, first))
    }
}
