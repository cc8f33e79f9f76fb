// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask blender`: the extension for Blender as a zip file with the Python package's wheel inside.
//! `--judge` renders scenes and nodes beside Cycles instead, by the package `bpy`; without it that is told and skipped.
//! Tests: `tests` here for the manifest, `bindings/blender/tests` for the pictures.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::command;
use crate::failure::Failure;
use crate::wheel;
use crate::workspace::Workspace;

/// The version of Blender that the judge compares with, and its Python.
const BPY: &str = "bpy==5.0.1";
const PYTHON: &str = "python3.11";
/// Scripts of the judge.
const JUDGES: [&str; 3] = ["checks.py", "judge.py", "judge_nodes.py"];

/// Packs the extension, or judges it.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    match arguments {
        [] => pack(None),
        [option, wheel] if option == "--wheel" => pack(Some(wheel.into())),
        [option] if option == "--judge" => judge(),
        [other, ..] => Err(format!("blender: unknown '{other}'; [--judge | --wheel FILE]")),
    }
}

/// Writes `target/blender/gnurt_blender-VERSION.zip`.
fn pack(wheel: Option<PathBuf>) -> Result<(), Failure> {
    let workspace = Workspace::load()?;
    let folder = workspace.target.join("blender");
    let wheel = match wheel {
        Some(wheel) => wheel,
        None => wheel::build(&folder.join("wheels"), "python3")?,
    };
    let name = wheel.file_name().map(|name| name.to_string_lossy().into_owned());
    let name = name.ok_or_else(|| format!("{}: no file", wheel.display()))?;
    let source = command::root().join("bindings/blender/gnurt_blender");
    let staged = folder.join("gnurt_blender");
    if staged.exists() {
        std::fs::remove_dir_all(&staged).map_err(|error| format!("{}: {error}", staged.display()))?;
    }
    copy(&source, &staged)?;
    let wheels = staged.join("wheels");
    std::fs::create_dir_all(&wheels).map_err(|error| format!("{}: {error}", wheels.display()))?;
    std::fs::copy(&wheel, wheels.join(&name)).map_err(|error| format!("{}: {error}", wheel.display()))?;
    let manifest = staged.join("blender_manifest.toml");
    let text = read(&manifest)?;
    write(&manifest, &filled(&text, &workspace.version, &name)?)?;
    let license = command::root().join("COPYING");
    std::fs::copy(&license, staged.join("COPYING"))
        .map_err(|error| format!("{}: {error}", license.display()))?;
    let zip = folder.join(format!("gnurt_blender-{}.zip", workspace.version));
    let _ = std::fs::remove_file(&zip);
    let mut entries: Vec<_> = std::fs::read_dir(&staged)
        .map_err(|error| format!("{}: {error}", staged.display()))?
        .filter_map(|entry| Some(entry.ok()?.file_name()))
        .collect();
    entries.sort();
    command::run(
        Command::new("python3").current_dir(&staged).args(["-m", "zipfile", "-c"]).arg(&zip).args(entries),
    )?;
    eprintln!("wrote {}", zip.display());
    Ok(())
}

/// The manifest with this version and wheel.
fn filled(text: &str, version: &str, wheel: &str) -> Result<String, Failure> {
    let platform = if wheel.contains("aarch64") { "linux-arm64" } else { "linux-x64" };
    let mut missing = vec!["version", "wheels", "platforms"];
    let lines = text.lines().map(|line| {
        let key = line.split(" = ").next().unwrap_or_default();
        let value = match key {
            "version" => format!("\"{version}\""),
            "wheels" => format!("[\"./wheels/{wheel}\"]"),
            "platforms" => format!("[\"{platform}\"]"),
            _ => return line.to_owned(),
        };
        missing.retain(|known| *known != key);
        format!("{key} = {value}")
    });
    let made = lines.collect::<Vec<_>>().join("\n") + "\n";
    match missing.first() {
        None => Ok(made),
        Some(key) => Err(format!("blender_manifest.toml: missing '{key} = ...'")),
    }
}

/// Copies a folder without what interpreters leave behind.
fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(to).map_err(|error| format!("{}: {error}", to.display()))?;
    let entries = std::fs::read_dir(from).map_err(|error| format!("{}: {error}", from.display()))?;
    for entry in entries.filter_map(Result::ok).filter(|entry| entry.file_name() != "__pycache__") {
        let (source, target) = (entry.path(), to.join(entry.file_name()));
        if source.is_dir() {
            copy(&source, &target)?;
        } else {
            std::fs::copy(&source, &target).map_err(|error| format!("{}: {error}", source.display()))?;
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Renders scenes and nodes beside Cycles.
fn judge() -> Result<(), Failure> {
    command::build_all()?;
    let target = Workspace::load()?.target;
    let built = target.join("debug/lib_gnurt.so");
    let module = command::root().join("bindings/python/python/gnurt/_gnurt.abi3.so");
    std::fs::copy(&built, &module).map_err(|error| format!("{}: {error}", built.display()))?;
    let folder = target.join("blender/python");
    let python = folder.join("bin/python");
    let succeeds =
        |command: &mut Command| command.stderr(Stdio::null()).status().is_ok_and(|status| status.success());
    if !python.exists() && !succeeds(Command::new(PYTHON).args(["-m", "venv"]).arg(&folder)) {
        eprintln!("SKIPPED: the judge of Blender; it needs {PYTHON} with venv");
        return Ok(());
    }
    let has_bpy = succeeds(Command::new(&python).args(["-c", "import bpy, numpy"]));
    if !has_bpy && !succeeds(Command::new(&python).args(["-m", "pip", "install", "--quiet", BPY, "numpy"])) {
        eprintln!("SKIPPED: the judge of Blender; pip could not install {BPY}");
        return Ok(());
    }
    let tests = command::root().join("bindings/blender/tests");
    for script in JUDGES {
        command::run(
            Command::new(&python).current_dir(&tests).arg(script).env("PYTHONDONTWRITEBYTECODE", "1"),
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_manifest_gets_version_and_wheel() {
        let text =
            read(&command::root().join("bindings/blender/gnurt_blender/blender_manifest.toml")).unwrap();
        let made = filled(&text, "1.2.3", "gnurt-1.2.3-cp311-abi3-linux_x86_64.whl").unwrap();
        for line in [
            "version = \"1.2.3\"",
            "wheels = [\"./wheels/gnurt-1.2.3-cp311-abi3-linux_x86_64.whl\"]",
            "platforms = [\"linux-x64\"]",
            "id = \"gnurt_blender\"",
            "license = [\"SPDX:GPL-3.0-or-later\"]",
        ] {
            assert!(made.lines().any(|found| found == line), "{line} is not in\n{made}");
        }
        let why = filled("version = \"0\"\n", "1", "a.whl").unwrap_err();
        assert!(why.contains("wheels"), "{why}");
    }
}
