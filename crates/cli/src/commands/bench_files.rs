// SPDX-License-Identifier: GPL-3.0-or-later
//! The files that measurements go to. Tests: `tests/program/bench.rs`.

use std::path::{Path, PathBuf};

use gnurt::image;

use crate::failure::{Failure, Outcome};

/// Whether they can be written, before anything is measured.
pub(super) fn check_outputs(files: &[&Option<PathBuf>]) -> Outcome {
    files
        .iter()
        .filter_map(|file| file.as_deref())
        .try_for_each(|file| image::check_writable(file).map_err(Failure::data))
}

/// Writes one, if it is requested.
pub(super) fn write(file: Option<&Path>, text: impl FnOnce() -> String) -> Outcome {
    file.map_or(Ok(()), |file| image::replace_file(file, text().as_bytes()).map_err(Failure::data))
}
