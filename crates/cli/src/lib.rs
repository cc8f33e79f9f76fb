// SPDX-License-Identifier: GPL-3.0-or-later
//! The program `gnurt` as a library of one function, for the binary of that name and for the Python package, which carries it.
//! It translates command lines into calls of the library `gnurt` and holds no logic of its own.
//! The hop path of a call: `program` -> `arguments` -> `commands::<the subcommand>`.
//! Contract: exit status 0 done, 1 bad data, 2 bad arguments, 130 stopped; one `error:` line, never a panic's text.
//! Tests: `tests/program`, which runs the program itself; `bindings/python/tests/test_program.py`.
#![forbid(unsafe_code)]

mod arguments;
mod checkpoint;
mod clips;
mod command_line;
mod commands;
mod display;
mod environment;
mod failure;
mod film_files;
mod heap;
mod messages;
mod nearest;
mod ocio;
#[cfg_attr(not(feature = "osl"), path = "absent_osl.rs")]
mod osl;
mod output;
mod picture_header;
mod program;
mod progress;
mod reference;
mod shaders;
mod signals;
mod source;
mod statistics;
mod view;
mod workers;

/// Runs the program and gives back its exit status: 0 done, 1 bad data, 2 bad arguments. `command_line` are the command line, the
/// program's name first. It is meant for a process of its own: it handles signals, reports panics in one
/// line, and a second Ctrl-C ends the process. Only the first call's words count.
pub fn run(command_line: impl IntoIterator<Item = std::ffi::OsString>) -> u8 {
    command_line::keep(command_line.into_iter().collect());
    program::run()
}
