// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask ci`: everything that must pass before a change is taken. Source: original.

use std::process::Command;

use crate::failure::Failure;
use crate::{command, installed, python, readme, tidy};

/// Runs all checks, the quick ones first; stops at the first that fails.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    if let Some(argument) = arguments.first() {
        return Err(format!("ci takes no arguments, not '{argument}'"));
    }
    command::run(command::cargo().args(["fmt", "--all", "--check"]))?;
    tidy::run(&[])?;
    command::run(command::cargo().args(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))?;
    let doc = ["doc", "--workspace", "--no-deps"];
    command::run(command::cargo().args(doc).env("RUSTDOCFLAGS", "-D warnings"))?;
    for target in OTHER_MACHINES {
        check_for(target)?;
    }

    let promises = readme::promises()?;
    run_words(&promises.test)?;
    installed::check(&[])?;
    python::run(&[])?;
    first_command(&promises)?;
    eprintln!("all checks passed");
    Ok(())
}

/// What the libraries must compile for, beside the machine that this runs on.
const OTHER_MACHINES: [&str; 2] = ["aarch64-unknown-linux-gnu", "wasm32-unknown-unknown"];

/// Checks the libraries for another machine, if its standard library is installed.
fn check_for(target: &str) -> Result<(), Failure> {
    if !command::has_target(target) {
        eprintln!("SKIPPED: the check for {target}; `rustup target add {target}` installs what it needs");
        return Ok(());
    }
    // Its dependencies are all the libraries that know no window, file lock or signal.
    command::run(command::cargo().args(["check", "-p", "gnurt", "--target", target]))
}

/// Runs the README's first command and looks for its picture.
fn first_command(promises: &readme::Promises) -> Result<(), Failure> {
    let picture = command::root().join(&promises.picture);
    // One left by an earlier run would prove nothing.
    if picture.exists() {
        std::fs::remove_file(&picture).map_err(|error| format!("{}: {error}", picture.display()))?;
    }
    run_words(&promises.first)?;
    match std::fs::metadata(&picture) {
        Ok(file) if file.len() > 0 => Ok(()),
        _ => Err(format!("'{}' made no picture {}", promises.first.join(" "), picture.display())),
    }
}

fn run_words(words: &[String]) -> Result<(), Failure> {
    match words.split_first() {
        Some((program, arguments)) if program == "cargo" => command::run(command::cargo().args(arguments)),
        Some((program, arguments)) => {
            command::run(Command::new(program).args(arguments).current_dir(command::root()))
        }
        None => Err("there is no command to run".into()),
    }
}
