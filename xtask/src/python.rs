// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask python`: builds the Python package's compiled part into its source folder, and runs its tests.
//! `--free-threaded [INTERPRETER]`: with a free-threaded interpreter, in a folder of their own (`free_threads`).
//! The wheel itself is maturin's business (`pip install ./bindings/python`).

use std::path::Path;
use std::process::{Command, Stdio};

use crate::command;
use crate::failure::Failure;
use crate::free_threads;
use crate::workspace::Workspace;

/// Packages for the tests.
const PACKAGES: [&str; 2] = ["numpy", "pytest"];
/// Packages for the notebooks; without them these are not run.
const NOTEBOOKS: [&str; 3] = ["matplotlib", "nbclient", "ipykernel"];
/// Packages that call our rays; without them their tests are skipped. Not embreex: `gnurt.trimesh` must do
/// without it.
const ASKING: [&str; 1] = ["trimesh"];

/// The checker of licences; versions before 4 lack REUSE.toml.
const REUSE: &str = "reuse>=5";
const INSTALL: [&str; 5] = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];

/// Builds and tests. Without a supported Python, or without its packages, that is reported and skipped.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    match arguments {
        [] => {}
        [option] if option == "--free-threaded" => return free_threads::run(None),
        [option, interpreter] if option == "--free-threaded" => return free_threads::run(Some(interpreter)),
        _ => return Err("usage: python [--free-threaded [INTERPRETER]]".into()),
    }
    command::build_all()?;
    let target = Workspace::load()?.target;
    let source = command::root().join("bindings/python");
    let built = target.join("debug/lib_gnurt.so");
    let module = source.join("python/gnurt/_gnurt.abi3.so");
    std::fs::copy(&built, &module).map_err(|error| format!("{}: {error}", built.display()))?;
    let device = "libanari_library_gnurt.so";
    let (built, beside) = (target.join("debug").join(device), source.join("python/gnurt").join(device));
    std::fs::copy(&built, &beside).map_err(|error| format!("{}: {error}", built.display()))?;
    let environment = target.join("python");
    let Some(python) = environment_with_packages(&environment) else { return Ok(()) };
    let tests = || {
        let mut tests = Command::new(&python);
        tests.current_dir(&source).args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]);
        // Some tests start programs in other folders.
        tests.env("PYTHONPATH", source.join("python")).env("GNURT", target.join("debug/gnurt"));
        tests.env("PYTHONDONTWRITEBYTECODE", "1");
        tests
    };
    // Most tests keep one core busy: two processes take three quarters of the time of one.
    let half = every_other_test(&source.join("tests"))?;
    let (mut beside, mut others) = (tests(), tests());
    beside.args(&half);
    others.arg("tests").args(half.iter().map(|name| format!("--ignore={name}")));
    let beside = std::thread::spawn(move || beside.output());
    let others = command::run(&mut others);
    let beside = beside.join().map_err(|_| "the thread of half of the tests panicked")?;
    let beside = beside.map_err(|error| format!("{}: {error}", python.display()))?;
    eprint!("{}{}", String::from_utf8_lossy(&beside.stdout), String::from_utf8_lossy(&beside.stderr));
    others?;
    if beside.status.success() { Ok(()) } else { Err(format!("tests failed: {}", half.join(" "))) }
}

/// Every other file of tests, from the folder above theirs.
fn every_other_test(folder: &Path) -> Result<Vec<String>, Failure> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let mut files: Vec<String> =
        names.filter(|name| name.starts_with("test_") && name.ends_with(".py")).collect();
    files.sort();
    Ok(files.iter().step_by(2).map(|name| format!("tests/{name}")).collect())
}

/// Installs the packages for the tests; the tests do so as well.
pub(crate) fn prepare() -> Result<(), Failure> {
    environment_with_packages(&Workspace::load()?.target.join("python"));
    Ok(())
}

/// Checks the copyright and licence of every file by the tool `reuse`, by REUSE.toml. Where pip cannot
/// install it, that is reported and skipped.
pub(crate) fn lint_licences() -> Result<(), Failure> {
    let folder = Workspace::load()?.target.join("python");
    let python = folder.join("bin/python");
    let has_reuse = || succeeds(Command::new(&python).args(["-c", "import reuse"]).stderr(Stdio::null()));
    if !has_reuse() {
        let made = python.exists() || succeeds(Command::new("python3").args(["-m", "venv"]).arg(&folder));
        if !made || !succeeds(Command::new(&python).args(INSTALL).arg(REUSE)) {
            eprintln!("SKIPPED: licences of files; pip could not install {REUSE}");
            return Ok(());
        }
    }
    command::run(Command::new(&python).args(["-m", "reuse", "lint", "--lines"]).current_dir(command::root()))
}

/// The interpreter of an environment with the packages for the tests.
fn environment_with_packages(folder: &Path) -> Option<std::path::PathBuf> {
    let is_new = "import sys, ensurepip; sys.exit(sys.version_info < (3, 11))";
    if !succeeds(Command::new("python3").args(["-c", is_new])) {
        eprintln!("SKIPPED: tests of the Python package; they need Python 3.11 or later with venv");
        return None;
    }
    let python = folder.join("bin/python");
    let has = |packages: &[&str]| {
        let imports: Vec<String> = packages.iter().map(|package| format!("import {package}")).collect();
        succeeds(Command::new(&python).args(["-c", &imports.join("; ")]))
    };
    let can_have =
        |packages: &[&str]| has(packages) || succeeds(Command::new(&python).args(INSTALL).args(packages));
    let made = python.exists() || succeeds(Command::new("python3").args(["-m", "venv"]).arg(folder));
    if !made || !can_have(&PACKAGES) {
        eprintln!("SKIPPED: tests of the Python package; pip could not install {}", PACKAGES.join(" and "));
        return None;
    }
    for (what, packages) in [("the notebooks", &NOTEBOOKS[..]), ("rays of other packages", &ASKING)] {
        if !can_have(packages) {
            eprintln!("SKIPPED: {what}; pip could not install {}", packages.join(" and "));
        }
    }
    Some(python)
}

fn succeeds(command: &mut Command) -> bool {
    command.status().is_ok_and(|status| status.success())
}
