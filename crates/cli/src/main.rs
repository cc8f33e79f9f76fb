// SPDX-License-Identifier: GPL-3.0-or-later
//! The program `gnurt`. All of its code is in the library of the same package.
//! Tests: `tests/program`, which runs the program itself.
#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    gnurt_cli::run(std::env::args_os()).into()
}
