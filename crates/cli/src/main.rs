// SPDX-License-Identifier: GPL-3.0-or-later
//! The program `gnurt`: translates command lines into calls of the library `gnurt` and holds no logic of its own.
//! Source: original. The hop path of a call: `program` -> `arguments` -> `commands::<the subcommand>`.
//! Contract: exit status 0 done, 1 bad data, 2 bad arguments, 130 stopped; one `error:` line, never a panic's text.
//! Proof: `tests/program`, which runs the program itself.
#![forbid(unsafe_code)]

mod arguments;
mod checkpoint;
mod clips;
mod commands;
mod display;
mod environment;
mod failure;
mod messages;
mod nearest;
mod osl;
mod output;
mod picture_header;
mod program;
mod progress;
mod shaders;
mod signals;
mod source;
mod statistics;
mod view;
mod workers;

fn main() -> std::process::ExitCode {
    program::run()
}
