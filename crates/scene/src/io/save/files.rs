// SPDX-License-Identifier: GPL-3.0-or-later
//! The files of a saved scene. Each appears whole or not at all. Tests: `tests/save.rs`.

use std::path::{Path, PathBuf};

use crate::io::{Error, Oddity, Warnings};

/// Whether files can be written, as far as that can be known before the first of them is.
///
/// # Errors
/// The first that cannot.
pub fn check_writable(paths: &[PathBuf]) -> Result<(), Error> {
    paths.iter().try_for_each(|path| gnurt_image::check_writable(path).map_err(|e| unwritable(path, &e)))
}

/// Writes one file whole.
///
/// # Errors
/// If the system does not let it.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    gnurt_image::replace_file(path, bytes).map_err(|e| unwritable(path, &e))
}

fn unwritable(path: &Path, error: &gnurt_image::Error) -> Error {
    match error {
        gnurt_image::Error::File { what, .. } => Error::io(path, what.clone(), ""),
        other => Error::io(path, format!("cannot be written: {other}"), ""),
    }
}

/// Notes what the format cannot hold.
pub fn leave_out(count: usize, what: &str, path: &Path, warnings: &mut Warnings) {
    warnings.note_many(Oddity::NotShown, count as u64, path, None, what);
}
