// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask wheel --check | --publish`: what PyPI asks of the Python package, and the upload of its files.
//! Tests: `.ci/run` checks the source package.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command;
use crate::failure::Failure;
use crate::workspace::Workspace;

const TOOLS: [&str; 2] = ["maturin>=1.14,<2", "twine>=6,<8"];

/// Installs the tools; [`check`] does so as well.
pub(crate) fn prepare() -> Result<(), Failure> {
    tools(&Workspace::load()?.target);
    Ok(())
}

/// Packs the sources, compiles nothing, and checks them and the wheels that are there as PyPI does. Where pip cannot install the tools, that is
/// reported and skipped.
pub(crate) fn check() -> Result<(), Failure> {
    let target = Workspace::load()?.target;
    let Some(tools) = tools(&target) else {
        eprintln!(
            "SKIPPED: the Python package as PyPI checks it; pip could not install {}",
            TOOLS.join(" and ")
        );
        return Ok(());
    };
    let folder = target.join("python-sources");
    let _ = std::fs::remove_dir_all(&folder);
    let mut pack = Command::new(tools.join("maturin"));
    pack.current_dir(command::root()).args([
        "sdist",
        "--manifest-path",
        "bindings/python/Cargo.toml",
        "--out",
    ]);
    command::run(pack.arg(&folder))?;
    let mut check = Command::new(tools.join("twine"));
    command::run(check.args(["check", "--strict"]).args(files(&folder)).args(files(&target.join("wheels"))))
}

/// Sends the sources and the wheels of `target/wheels`, with the account that twine asks for or finds.
pub(crate) fn publish() -> Result<(), Failure> {
    check()?;
    let target = Workspace::load()?.target;
    let tools =
        tools(&target).ok_or_else(|| format!("wheel: pip could not install {}", TOOLS.join(" and ")))?;
    let wheels = files(&target.join("wheels"));
    if wheels.is_empty() {
        return Err("wheel: target/wheels is empty; build wheels first".into());
    }
    let mut upload = Command::new(tools.join("twine"));
    command::run(upload.arg("upload").args(files(&target.join("python-sources"))).args(wheels))
}

/// The folder of the tools' programs; `None` where they cannot be had.
fn tools(target: &Path) -> Option<PathBuf> {
    let folder = target.join("upload-tools");
    let programs = folder.join("bin");
    let succeeds = |command: &mut Command| command.status().is_ok_and(|status| status.success());
    let are_there = || ["maturin", "twine"].iter().all(|tool| programs.join(tool).exists());
    let made = are_there()
        || (succeeds(Command::new("python3").args(["-m", "venv"]).arg(&folder))
            && succeeds(
                Command::new(programs.join("python"))
                    .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
                    .args(TOOLS),
            ));
    (made && are_there()).then_some(programs)
}

/// Files of a folder, by name; none where there is no folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.sort();
    files
}
