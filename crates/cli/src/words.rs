// SPDX-License-Identifier: GPL-3.0-or-later
//! The words that the program was called with. They are not always those of the process, whose first ones may be an interpreter's.
//! State is global because a command line is.

use std::ffi::OsString;
use std::sync::OnceLock;

static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// Keeps the command line, the program's name first; later ones are not heard.
pub(crate) fn keep(words: Vec<OsString>) {
    let _earlier_ones_stay = WORDS.set(words);
}

/// The command line, the program's name first.
pub(crate) fn words() -> &'static [OsString] {
    WORDS.get().map_or(&[], Vec::as_slice)
}
