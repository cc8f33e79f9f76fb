// SPDX-License-Identifier: GPL-3.0-or-later
//! Lines for people, on the standard error output. If that is closed, output is dropped: no error, no panic.
//! Tests: bindings/openrt/tests/c_programs.rs (`a_closed_error_output_ends_nothing`).

use std::fmt::Display;
use std::io::Write;

/// Prints a line in one piece.
pub fn print_line(message: impl Display) {
    let _ = std::io::stderr().write_all(format!("libOpenRT: {message}\n").as_bytes());
}
