// SPDX-License-Identifier: GPL-3.0-or-later
//! The program `gnurt`. All that it does is in the library beside it.
//! Tests: `tests/program`, which runs the program itself.
#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    gnurt_cli::run(std::env::args_os()).into()
}
