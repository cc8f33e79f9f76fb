// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask ci`: everything that must pass before a change is taken. Source: original.

use std::path::PathBuf;
use std::process::Command;

use crate::failure::Failure;
use crate::workspace::Workspace;
use crate::{command, install, readme, tidy};

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
    installed()?;
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

/// The most that installed files of the tests' build may take: 32.8 MB were measured, a static library left in the folder
/// adds 15.4 MB. With debug lines it would be 200 MB.
const MOST_INSTALLED: u64 = 64 << 20;

/// Installs what the tests have built (nothing is built anew), and builds a program with it as the README says.
fn installed() -> Result<(), Failure> {
    let target = Workspace::load()?.target;
    let to = target.join("installed");
    let _ = std::fs::remove_dir_all(&to);
    let words = ["--libdir=lib/multiarch".to_owned(), format!("--prefix={}", to.display())];
    let built = format!("--built={}", target.join("debug").display());
    install::run(&[words[0].clone(), words[1].clone(), built])?;
    let size = |path: &PathBuf| to.join(path).symlink_metadata().map_or(0, |file| file.len());
    let bytes: u64 = install::files::tree(&to)?.iter().map(size).sum();
    if bytes > MOST_INSTALLED {
        return Err(format!("installed files take {bytes} bytes, more than {MOST_INSTALLED}"));
    }
    let lib = to.join("lib/multiarch");
    let program = to.join("figure1");
    let line =
        "cc examples/c/figure1.c $(pkg-config --cflags --libs openrt) -lm -o \"$0\" && \"$0\" \"$0.ppm\"";
    command::run(
        Command::new("sh")
            .args(["-c", line])
            .arg(&program)
            .current_dir(command::root())
            .env("PKG_CONFIG_PATH", lib.join("pkgconfig"))
            .env("LD_LIBRARY_PATH", &lib),
    )
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
