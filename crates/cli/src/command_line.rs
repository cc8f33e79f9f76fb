// SPDX-License-Identifier: GPL-3.0-or-later
//! The words that the program was called with. They are not always those of the process, whose first ones may be an interpreter's.
//! State is global because a command line is.

use std::ffi::OsString;
use std::sync::OnceLock;

static NAMES: OnceLock<Vec<OsString>> = OnceLock::new();

/// Stores the command line, the program's name first; later ones are ignored.
pub(crate) fn keep(command_line: Vec<OsString>) {
    let _earlier_ones_stay = NAMES.set(command_line);
}

/// The command line, the program's name first.
pub(crate) fn command_line() -> &'static [OsString] {
    NAMES.get().map_or(&[], Vec::as_slice)
}
