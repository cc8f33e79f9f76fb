// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask crates` and `cargo xtask wheel`: the packages for crates.io and PyPI, one command each.
//! Tests: `tests` here.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::command;
use crate::failure::Failure;
use crate::workspace::Workspace;

/// Packs every crate, in the order of their dependencies.
///
/// Without an option nothing is compiled and nothing is sent. `--verify` also compiles each crate from its package,
/// `--publish` sends them.
pub(crate) fn crates(arguments: &[String]) -> Result<(), Failure> {
    let options: &[&str] = match arguments {
        [] => &["--dry-run", "--no-verify", "--allow-dirty"],
        [option] if option == "--verify" => &["--dry-run", "--allow-dirty"],
        [option] if option == "--publish" => &[],
        [other, ..] => return Err(format!("crates: unknown '{other}'; [--verify | --publish]")),
    };
    let mut publish = command::cargo();
    publish.args(["publish", "--workspace"]).args(options);
    for name in kept(&Workspace::metadata()?) {
        publish.args(["--exclude", &name]);
    }
    command::run(&mut publish)
}

/// Names of the packages that are not published.
fn kept(metadata: &Value) -> Vec<String> {
    let packages = metadata["packages"].as_array().into_iter().flatten();
    let is_kept = |package: &&Value| package["publish"].as_array().is_some_and(Vec::is_empty);
    packages.filter(is_kept).filter_map(|package| Some(package["name"].as_str()?.to_owned())).collect()
}

/// Writes the wheel, with the ANARI device inside, to `target/wheels`.
pub(crate) fn wheel(arguments: &[String]) -> Result<(), Failure> {
    if let Some(argument) = arguments.first() {
        return Err(format!("wheel takes no arguments, not '{argument}'"));
    }
    command::run(command::cargo().args(["build", "--release", "-p", "gnurt-anari"]))?;
    let target = Workspace::load()?.target;
    let device = "libanari_library_gnurt.so";
    let (built, beside) = (
        target.join("release").join(device),
        command::root().join("bindings/python/python/gnurt").join(device),
    );
    std::fs::copy(&built, &beside).map_err(|error| format!("{}: {error}", built.display()))?;
    let wheel = build_wheel(&target.join("wheels"))?;
    let bytes = std::fs::metadata(&wheel).map_err(|error| format!("{}: {error}", wheel.display()))?.len();
    eprintln!("{}: {:.1} MB", wheel.display(), bytes as f64 / 1e6);
    Ok(())
}

/// Builds the wheel alone into an empty folder.
pub(crate) fn build_wheel(folder: &Path) -> Result<PathBuf, Failure> {
    let _ = std::fs::remove_dir_all(folder);
    command::run(
        Command::new("python3")
            .current_dir(command::root())
            .args(["-m", "pip", "wheel", "--no-deps", "--disable-pip-version-check", "-w"])
            .arg(folder)
            .arg("./bindings/python"),
    )?;
    let found = std::fs::read_dir(folder).ok().and_then(|mut all| all.find_map(Result::ok));
    found.map(|entry| entry.path()).ok_or_else(|| format!("{}: pip left no wheel", folder.display()))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn packages_that_stay_are_found() {
        let metadata = json!({ "packages": [
            { "name": "a", "publish": null }, { "name": "b", "publish": [] }, { "name": "c", "publish": ["x"] },
        ]});
        assert_eq!(kept(&metadata), ["b"]);
    }
}
