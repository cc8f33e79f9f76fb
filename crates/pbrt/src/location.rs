// SPDX-License-Identifier: GPL-3.0-or-later
//! Where something stands in a scene's files, for errors and warnings. Lines count from 1.

use std::path::Path;
use std::sync::Arc;

use gnurt_scene::io::reader::Excess;
use gnurt_scene::io::{Error, Oddity, Warnings};

/// A file and a line of it.
#[derive(Clone, Debug)]
pub(crate) struct Location {
    pub(crate) path: Arc<Path>,
    pub(crate) line: u64,
}

impl Location {
    /// An error there: the problem and its remedy.
    pub(crate) fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> Error {
        Error::data(&self.path, Some(self.line), problem, remedy)
    }

    /// More is asked for than files of this length may take.
    pub(crate) fn excess(&self, excess: Excess) -> Error {
        self.error(excess.to_string(), Excess::REMEDY)
    }

    /// Notes an oddity.
    pub(crate) fn warn(&self, warnings: &mut Warnings, oddity: Oddity, detail: impl Into<String>) {
        warnings.note(oddity, &self.path, Some(self.line), detail);
    }
}
