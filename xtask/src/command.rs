// SPDX-License-Identifier: GPL-3.0-or-later
//! Running other programs, in the workspace's root.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::failure::Failure;

/// The workspace's root: the folder above this package. Cargo reports its current path; the path at compile
/// time may be out of date.
pub(crate) fn root() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    let package = Path::new(&package);
    package.parent().unwrap_or(package).to_path_buf()
}

/// The calling Cargo, or the one in the path.
pub(crate) fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    command
}

/// All packages, with their tests. `--all-targets` adds libraries as benchmarks: there are none, and cargo would compile
/// each library without unit tests once more.
pub(crate) const TESTED: [&str; 5] = ["--workspace", "--lib", "--bins", "--tests", "--examples"];

/// Builds what tests and checks run, with one choice of features: with another, half of the crates would be compiled again.
pub(crate) fn build_all() -> Result<(), Failure> {
    run(cargo().arg("build").args(TESTED))
}

/// Shows a command and runs it.
pub(crate) fn run(command: &mut Command) -> Result<(), Failure> {
    let tokens: Vec<_> = [command.get_program()].into_iter().chain(command.get_args()).collect();
    let line = tokens.iter().map(|token| token.to_string_lossy()).collect::<Vec<_>>().join(" ");
    eprintln!("+ {line}");
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("'{line}' failed: {status}")),
        Err(error) => Err(format!("'{line}' cannot be run: {error}")),
    }
}

/// The output of a tool.
pub(crate) fn output_of(tool: &str, arguments: &[&str]) -> Result<String, Failure> {
    let output = Command::new(tool).current_dir(root()).args(arguments).output();
    let output = output.map_err(|error| format!("{tool} cannot be run: {error}"))?;
    if !output.status.success() {
        return Err(format!("{tool} failed: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Whether the standard library of another machine is installed.
pub(crate) fn has_target(target: &str) -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).args(["--print", "target-libdir", "--target", target]).output();
    output.is_ok_and(|output| Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir())
}
