// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask wheel`: the Python package's wheel with the ANARI device inside, for this machine or for any Linux.
//!
//! Without options the wheel is for this machine's C library. With `--machine x86_64` or `--machine aarch64` it is for every Linux of
//! that kind from [`GLIBC`] on (a manylinux wheel): Zig's compiler links against the old library, pip brings it. With `--python
//! NAME` the wheel is for one interpreter, which a free-threaded one needs; others share one wheel.
//! Tests: `tests` here.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command;
use crate::failure::Failure;
use crate::python_upload;
use crate::workspace::Workspace;

/// The oldest C library that portable wheels run with: of Debian 10, Ubuntu 18.10, RHEL 8.
const GLIBC: &str = "2.28";
/// Tools for portable wheels.
const TOOLS: [&str; 3] = ["maturin>=1.14,<2", "cargo-zigbuild>=0.20,<1", "ziglang>=0.13,<1"];
const DEVICE: &str = "libanari_library_gnurt.so";

/// The requested kind of wheel.
#[derive(Debug, Default, PartialEq)]
struct Request {
    /// The kind of processor, of a portable wheel.
    machine: Option<String>,
    /// The interpreter, by name or path, if the wheel is for one.
    python: Option<String>,
}

impl Request {
    fn of(arguments: &[String]) -> Result<Self, Failure> {
        let mut request = Self::default();
        let mut rest = arguments.iter();
        while let Some(option) = rest.next() {
            let value = rest.next().cloned();
            match (option.as_str(), value) {
                ("--machine", Some(machine)) if machine == "x86_64" || machine == "aarch64" => {
                    request.machine = Some(machine);
                }
                ("--machine", machine) => {
                    let given =
                        machine.map_or_else(|| "nothing".to_owned(), |machine| format!("'{machine}'"));
                    return Err(format!("wheel: --machine takes x86_64 or aarch64, not {given}"));
                }
                ("--python", Some(python)) => request.python = Some(python),
                ("--python", None) => return Err("wheel: --python takes the name of an interpreter".into()),
                (other, _) => {
                    return Err(format!(
                        "wheel: unknown '{other}'; [--machine x86_64|aarch64] [--python INTERPRETER] | --check | --publish"
                    ));
                }
            }
        }
        Ok(request)
    }
}

/// Writes the wheel to `target/wheels`.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    match arguments {
        [option] if option == "--check" => return python_upload::check(),
        [option] if option == "--publish" => return python_upload::publish(),
        _ => {}
    }
    let Request { machine, python } = Request::of(arguments)?;
    let target = Workspace::load()?.target;
    let wheels = target.join("wheels");
    let wheel = match machine {
        Some(machine) => portable(&target, &wheels, &machine, python.as_deref())?,
        None => {
            command::run(command::cargo().args(["build", "--release", "-p", "gnurt-anari"]))?;
            carry(&target.join("release"))?;
            build(&wheels, python.as_deref().unwrap_or("python3"))?
        }
    };
    let bytes = std::fs::metadata(&wheel).map_err(|error| format!("{}: {error}", wheel.display()))?.len();
    eprintln!("{}: {:.1} MB", wheel.display(), bytes as f64 / 1e6);
    Ok(())
}

/// Copies the ANARI device from a folder of built libraries into the package.
fn carry(from: &Path) -> Result<(), Failure> {
    let (built, beside) =
        (from.join(DEVICE), command::root().join("bindings/python/python/gnurt").join(DEVICE));
    std::fs::copy(&built, &beside).map_err(|error| format!("{}: {error}", built.display()))?;
    Ok(())
}

/// Builds the wheel for this machine, without a new device, into an emptied folder; by pip of an interpreter.
pub(crate) fn build(folder: &Path, python: &str) -> Result<PathBuf, Failure> {
    let _ = std::fs::remove_dir_all(folder);
    command::run(
        Command::new(python)
            .current_dir(command::root())
            .args(["-m", "pip", "wheel", "--no-deps", "--disable-pip-version-check", "-w"])
            .arg(folder)
            .arg("./bindings/python"),
    )?;
    only_file(folder)
}

/// Builds the device and the wheel for any Linux of a kind of processor, into an emptied folder.
fn portable(target: &Path, folder: &Path, machine: &str, python: Option<&str>) -> Result<PathBuf, Failure> {
    let triple = format!("{machine}-unknown-linux-gnu");
    if !command::has_target(&triple) {
        return Err(format!(
            "wheel: the standard library for {machine} is missing: rustup target add {triple}"
        ));
    }
    let tools = target.join("wheel-tools");
    if !tools.join("bin/maturin").exists() {
        command::run(Command::new("python3").args(["-m", "venv"]).arg(&tools))?;
        command::run(
            Command::new(tools.join("bin/python"))
                .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
                .args(TOOLS),
        )?;
    }
    let path = std::env::join_paths(
        [tools.join("bin")]
            .into_iter()
            .chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    )
    .map_err(|error| format!("PATH: {error}"))?;
    let tool = |name: &str| {
        let mut tool = Command::new(tools.join("bin").join(name));
        // Zig is started by this environment's Python.
        tool.current_dir(command::root())
            .env("PATH", &path)
            .env("CARGO_ZIGBUILD_PYTHON_PATH", tools.join("bin/python"));
        tool
    };
    let old = format!("{triple}.{GLIBC}");
    command::run(tool("cargo-zigbuild").args([
        "zigbuild",
        "--release",
        "-p",
        "gnurt-anari",
        "--target",
        &old,
    ]))?;
    carry(&target.join(&triple).join("release"))?;
    let _ = std::fs::remove_dir_all(folder);
    let manylinux = format!("manylinux_{}", GLIBC.replace('.', "_"));
    let mut build = tool("maturin");
    build.args(["build", "--release", "--zig", "--target", &triple, "--compatibility", &manylinux]);
    build.args(["--manifest-path", "bindings/python/Cargo.toml", "--out"]).arg(folder);
    if let Some(python) = python {
        build.args(["--interpreter", python]);
    }
    command::run(&mut build)?;
    only_file(folder)
}

fn only_file(folder: &Path) -> Result<PathBuf, Failure> {
    let found = std::fs::read_dir(folder).ok().and_then(|mut all| all.find_map(Result::ok));
    found.map(|entry| entry.path()).ok_or_else(|| format!("{}: no wheel was written", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(text: &str) -> Result<Request, Failure> {
        Request::of(&text.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn options_are_read() {
        let of = |machine: Option<&str>, python: Option<&str>| Request {
            machine: machine.map(str::to_owned),
            python: python.map(str::to_owned),
        };
        assert_eq!(request("").unwrap(), of(None, None));
        assert_eq!(request("--machine aarch64").unwrap(), of(Some("aarch64"), None));
        assert_eq!(
            request("--python python3.14t --machine x86_64").unwrap(),
            of(Some("x86_64"), Some("python3.14t"))
        );
        for (wrong, named) in [
            ("--machine", "nothing"),
            ("--machine arm", "'arm'"),
            ("--python", "interpreter"),
            ("now", "'now'"),
        ] {
            let why = request(wrong).unwrap_err();
            assert!(why.contains(named), "{wrong}: {why}");
        }
    }
}
