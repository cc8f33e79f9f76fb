// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask ci`: everything that must pass before a change is taken. Source: original.

use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, Command};

use crate::failure::Failure;
use crate::workspace::Workspace;
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
    let mut first = FirstCommand::start(&promises)?;
    let checked =
        run_words(&promises.test).and_then(|()| installed::check(&[])).and_then(|()| python::run(&[]));
    if checked.is_err() {
        first.give_up();
    }
    checked?;
    first.finish()?;
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

/// The README's first command, which runs beside the tests: its build for release has a folder of its own, and cores that wait
/// for the last crate of one build work on the other.
struct FirstCommand {
    line: String,
    process: Child,
    /// What it says, kept until it is done.
    said: PathBuf,
    picture: PathBuf,
}

impl FirstCommand {
    fn start(promises: &readme::Promises) -> Result<Self, Failure> {
        let picture = command::root().join(&promises.picture);
        // One left by an earlier run would prove nothing.
        if picture.exists() {
            std::fs::remove_file(&picture).map_err(|error| format!("{}: {error}", picture.display()))?;
        }
        let said = Workspace::load()?.target.join("first-command.txt");
        let told = |error: std::io::Error| format!("{}: {error}", said.display());
        let output = File::create(&said).map_err(told)?;
        let errors = output.try_clone().map_err(told)?;
        let line = promises.first.join(" ");
        eprintln!("+ {line} (beside what follows)");
        let process = command_of(&promises.first)?
            .stdout(output)
            .stderr(errors)
            .spawn()
            .map_err(|error| format!("'{line}' cannot be run: {error}"))?;
        Ok(Self { line, process, said, picture })
    }

    /// Waits for it, shows what it said and looks for its picture.
    fn finish(mut self) -> Result<(), Failure> {
        let status = self.process.wait().map_err(|error| format!("'{}': {error}", self.line))?;
        eprintln!("'{}' said:", self.line);
        eprint!("{}", std::fs::read_to_string(&self.said).unwrap_or_default());
        if !status.success() {
            return Err(format!("'{}' failed: {status}", self.line));
        }
        match std::fs::metadata(&self.picture) {
            Ok(file) if file.len() > 0 => Ok(()),
            _ => Err(format!("'{}' made no picture {}", self.line, self.picture.display())),
        }
    }

    /// Ends it: another check has failed.
    fn give_up(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn run_words(words: &[String]) -> Result<(), Failure> {
    command::run(&mut command_of(words)?)
}

/// The command of a line, in the workspace's root.
fn command_of(words: &[String]) -> Result<Command, Failure> {
    let (program, arguments) = words.split_first().ok_or("there is no command to run")?;
    let mut command = if program == "cargo" { command::cargo() } else { Command::new(program) };
    command.args(arguments).current_dir(command::root());
    Ok(command)
}
