// SPDX-License-Identifier: GPL-3.0-or-later
//! The program `gnurt` in the package, so that one installation brings both.
//! Tests: `tests/test_program.py`.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program and gives back its exit status. `words` are the command line, the program's name first.
#[pyfunction]
pub(crate) fn program(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| gnurt_cli::run(words))
}
