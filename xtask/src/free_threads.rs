// SPDX-License-Identifier: GPL-3.0-or-later
//! The tests of the Python package with a free-threaded interpreter, one without a global lock.
//!
//! They run twice: as such interpreters start, with the lock off, and the tests of threads with `PYTHON_GIL=1`. Without an
//! interpreter of 3.14 or later, or without its numpy, that is reported and skipped.
//! Tests: `tests` here.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::command;
use crate::failure::Failure;
use crate::workspace::Workspace;

/// Names of interpreters, the oldest first; `PyO3` takes none before 3.14.
const NAMES: [&str; 2] = ["python3.14t", "python3.15t"];
const PACKAGES: [&str; 2] = ["numpy", "pytest"];
/// Prints the ending of extensions if the interpreter has no global lock and is new enough.
const ENDING: &str = "import sys, sysconfig
is_free = sysconfig.get_config_var('Py_GIL_DISABLED') and sys.version_info >= (3, 14)
print(sysconfig.get_config_var('EXT_SUFFIX') if is_free else '')";

/// Builds the extension for the interpreter, by default the first that is found, and runs the tests.
pub(crate) fn run(interpreter: Option<&String>) -> Result<(), Failure> {
    let names: Vec<&str> = interpreter.map_or_else(|| NAMES.to_vec(), |name| vec![name]);
    let found = names.iter().find_map(|name| Some((*name, ending(Path::new(name))?)));
    let Some((name, ending)) = found else {
        let names = names.join(", ");
        if interpreter.is_some() {
            return Err(format!("{names}: no free-threaded interpreter of 3.14 or later"));
        }
        eprintln!("SKIPPED: tests with a free-threaded Python; none of {names} is here");
        return Ok(());
    };
    let target = Workspace::load()?.target;
    let folder = target.join("free-threaded");
    let Some(python) = environment(&folder.join("python"), name) else { return Ok(()) };
    command::run(command::cargo().args(["build", "--package", "gnurt-python"]).env("PYO3_PYTHON", &python))?;
    let source = command::root().join("bindings/python");
    let package = folder.join("package");
    copy_package(&source.join("python/gnurt"), &package.join("gnurt"))?;
    let module = package.join(format!("gnurt/_gnurt{ending}"));
    let built = target.join("debug/lib_gnurt.so");
    std::fs::copy(&built, &module).map_err(|error| format!("{}: {error}", built.display()))?;
    let tests = |lock: &str, tests: &str| {
        let options = ["-m", "pytest", "-q", "-p", "no:cacheprovider", tests];
        let mut tests = Command::new(&python);
        tests.current_dir(&source).args(options).env("PYTHONPATH", &package);
        command::run(tests.env("PYTHONDONTWRITEBYTECODE", "1").env("PYTHON_GIL", lock))
    };
    tests("0", "tests")?;
    tests("1", "tests/test_free_threads.py")
}

/// The ending of an interpreter's extensions; `None` if it has a global lock, is too old or is not there.
fn ending(interpreter: &Path) -> Option<String> {
    let printed = Command::new(interpreter).args(["-c", ENDING]).stderr(Stdio::null()).output().ok()?;
    let ending = String::from_utf8(printed.stdout).ok()?.trim().to_owned();
    (printed.status.success() && ending.ends_with(".so")).then_some(ending)
}

/// The interpreter of an environment with the packages for the tests.
fn environment(folder: &Path, interpreter: &str) -> Option<PathBuf> {
    let python = folder.join("bin/python");
    let succeeds = |command: &mut Command| command.status().is_ok_and(|status| status.success());
    let made = python.exists() || succeeds(Command::new(interpreter).args(["-m", "venv"]).arg(folder));
    // Not from sources: numpy takes an hour.
    let install =
        ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:"];
    if made && succeeds(Command::new(&python).args(install).args(PACKAGES)) {
        return Some(python);
    }
    eprintln!("SKIPPED: tests with {interpreter}; pip could not install {}", PACKAGES.join(" and "));
    None
}

/// Copies the package's sources without compiled parts, which are for other interpreters.
fn copy_package(from: &Path, to: &Path) -> Result<(), Failure> {
    let fault = |error: std::io::Error| format!("{}: {error}", from.display());
    std::fs::create_dir_all(to).map_err(fault)?;
    for entry in std::fs::read_dir(from).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        let (Some(name), ending) = (path.file_name(), path.extension()) else { continue };
        if path.is_dir() {
            copy_package(&path, &to.join(name))?;
        } else if ending.is_none_or(|ending| ending != "so") || name.to_string_lossy().starts_with("lib") {
            std::fs::copy(&path, to.join(name)).map_err(fault)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An empty folder.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("gnurt-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder");
        folder
    }

    #[test]
    fn other_interpreters_have_no_ending() {
        assert_eq!(ending(Path::new("no-such-python")), None);
        let folder = folder("interpreters");
        for (name, printed, expected) in
            [("free", ".cpython-314t.so", Some(".cpython-314t.so")), ("locked", "", None)]
        {
            let file = folder.join(name);
            std::fs::write(&file, format!("#!/bin/sh\necho {printed}\n")).expect("a file");
            let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
            std::fs::set_permissions(&file, mode).expect("it runs");
            assert_eq!(ending(&file).as_deref(), expected, "{name}");
        }
        std::fs::remove_dir_all(folder).expect("it goes");
        let missing = "no-such-python".to_owned();
        let why = run(Some(&missing)).expect_err("there is none");
        assert!(why.contains("no free-threaded interpreter"), "{why}");
    }

    #[test]
    fn compiled_parts_stay_behind() {
        let folder = folder("package");
        let [from, to] = ["from", "to"].map(|name| folder.join(name));
        std::fs::create_dir_all(from.join("compat")).expect("a folder");
        for name in ["__init__.py", "_gnurt.abi3.so", "libanari_library_gnurt.so", "compat/a.py"] {
            std::fs::write(from.join(name), "").expect("a file");
        }
        copy_package(&from, &to).expect("a copy");
        let is_there = |name: &str| to.join(name).exists();
        assert!(is_there("__init__.py") && is_there("compat/a.py") && is_there("libanari_library_gnurt.so"));
        assert!(!is_there("_gnurt.abi3.so"));
        std::fs::remove_dir_all(folder).expect("it goes");
    }
}
