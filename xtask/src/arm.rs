// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask arm`: tests on 64-bit ARM, under QEMU's emulation if this machine is another one.
//!
//! Programs are static, with the C library musl, and linked by Rust's own linker: neither a C compiler nor a library
//! for ARM is needed. Without options there are the machine code of shaders and a part of the ray kernels, for minutes. With
//! `--whole`, once a week, all tests of the kernels and the scripts of shaders; `GNURT_PROGRAMS=10000` makes more random shaders.
//! Tests: `tests` here.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command;
use crate::failure::Failure;

const TARGET: &str = "aarch64-unknown-linux-musl";
/// Debian's package `qemu-user-static` has the first, `qemu-user` the second.
const EMULATORS: [&str; 2] = ["qemu-aarch64-static", "qemu-aarch64"];

/// Machine code of shaders against the interpreter, and the layer of SIMD below the kernels.
const SHADERS: &[&str] = &["-p", "gnurt-simd", "-p", "gnurt-jit", "--lib", "--tests"];
/// Tests of the kernels that take a second or less on a usual machine: every kind of primitive and query.
const SOME_KERNELS: &[&str] = &[
    "-p",
    "gnurt-accel",
    "--test",
    "suite",
    "--",
    "packets::",
    "pencils::",
    "masks::",
    "filters::",
    "mixed::",
    "discs::",
    "far_away::",
    "compact::",
    "moving::",
];
const ALL: [&[&str]; 2] = [
    &[
        "-p",
        "gnurt-accel-core",
        "-p",
        "gnurt-accel-bvh",
        "-p",
        "gnurt-accel-kd",
        "-p",
        "gnurt-accel",
        "--lib",
        "--tests",
    ],
    &["-p", "gnurt-sl-shading", "--test", "scripts"],
];

/// Runs the tests.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let whole = match arguments {
        [] => false,
        [option] if option == "--whole" => true,
        [other, ..] => return Err(format!("arm: unknown '{other}'; [--whole]")),
    };
    let machine = Machine::find()?;
    machine.test(SHADERS)?;
    if !whole {
        return machine.test(SOME_KERNELS);
    }
    ALL.iter().try_for_each(|tests| machine.test(tests))
}

/// The machine code of shaders, as a part of all checks; without an emulator they are skipped, and it says so.
pub(crate) fn shaders() -> Result<(), Failure> {
    match Machine::find() {
        Ok(machine) => machine.test(SHADERS),
        Err(missing) => {
            eprintln!("SKIPPED: the machine code of shaders on ARM; {missing}");
            Ok(())
        }
    }
}

/// A way to run programs for ARM.
struct Machine {
    /// Not on ARM.
    emulator: Option<PathBuf>,
}

impl Machine {
    /// Looks for the compiler's parts and the emulator.
    ///
    /// # Errors
    /// The missing one, and how to install it.
    fn find() -> Result<Self, Failure> {
        if !command::has_target(TARGET) {
            return Err(format!(
                "the standard library for ARM is missing: `rustup target add {TARGET}` installs it"
            ));
        }
        let sysroot = command::output_of("rustc", &["--print", "sysroot"])?;
        if !has_linker(Path::new(&sysroot)) {
            return Err(format!(
                "the linker rust-lld is missing below {sysroot}: Rust's own toolchain (rustup) has it"
            ));
        }
        if cfg!(all(target_arch = "aarch64", target_os = "linux")) {
            return Ok(Self { emulator: None });
        }
        let path = std::env::var_os("PATH").unwrap_or_default();
        match emulator(&path) {
            Some(found) => Ok(Self { emulator: Some(found) }),
            None => Err(format!(
                "QEMU's emulation of ARM ({}) is missing: `apt install qemu-user-static` installs it",
                EMULATORS.join(" or ")
            )),
        }
    }

    fn test(&self, tests: &[&str]) -> Result<(), Failure> {
        let mut test = command::cargo();
        test.args(["test", "--target", TARGET]).args(tests);
        command::run(self.equip(&mut test))
    }

    fn equip<'c>(&self, cargo: &'c mut Command) -> &'c mut Command {
        cargo.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_LINKER", "rust-lld");
        if let Some(emulator) = &self.emulator {
            cargo.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_RUNNER", emulator);
        }
        cargo
    }
}

/// Whether a toolchain has Rust's linker, for any machine that compiles.
fn has_linker(sysroot: &Path) -> bool {
    let machines = std::fs::read_dir(sysroot.join("lib/rustlib"));
    let mut machines = machines.into_iter().flatten().flatten();
    machines.any(|machine| machine.path().join("bin/rust-lld").exists())
}

/// The first emulator in the folders of a search path.
fn emulator(path: &OsStr) -> Option<PathBuf> {
    let folders: Vec<_> = std::env::split_paths(path).collect();
    let mut places = EMULATORS.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    places.find(|place| place.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_options_are_named() {
        let why = run(&["--all".to_owned()]).expect_err("there is no such option");
        assert!(why.contains("'--all'") && why.contains("--whole"), "{why}");
    }

    #[test]
    fn emulators_are_found_by_either_name() {
        let folder = std::env::temp_dir().join(format!("gnurt-emulators-{}", std::process::id()));
        let [empty, full] = [folder.join("empty"), folder.join("full")];
        for place in [&empty, &full] {
            std::fs::create_dir_all(place).expect("a folder");
        }
        let path = std::env::join_paths([&empty, &full]).expect("a path");
        assert_eq!(emulator(&path), None, "there is none yet");
        for name in ["qemu-aarch64", "qemu-aarch64-static"] {
            std::fs::write(full.join(name), "").expect("a file");
            assert_eq!(emulator(&path), Some(full.join(name)), "the static one is preferred");
        }
        std::fs::remove_dir_all(&folder).expect("it is removed");
    }
}
