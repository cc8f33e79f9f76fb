// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask miri` and `cargo xtask sanitize address|thread`: checks of unsafe code while it runs. Miri
//! needs a nightly compiler, which nothing else does; both take long: they are run by hand once a week, with
//! the outcome in `bench/record/`. Each has its own build folders below `target/`.

use std::process::Command;

use crate::command;
use crate::failure::Failure;
use crate::workspace::Workspace;

/// The crates for Miri: no machine code, no other programs, no threads of a pool that outlive the test.
const INTERPRETED: [&[&str]; 4] = [
    &["-p", "gnurt-simd"],
    &["-p", "gnurt-rays", "--lib"],
    &["-p", "gnurt-embree", "--lib"],
    // Not the lock: Miri does not support `membarrier`.
    &["-p", "openrt", "--lib", "--", "state::"],
];

/// The tests that build C programs and run them.
const C_TESTS: [&[&str]; 3] = [
    &["-p", "gnurt-rays", "--test", "programs"],
    &["-p", "gnurt-embree", "--test", "programs"],
    &["-p", "openrt", "--test", "c_programs", "--test", "submission"],
];

const TARGET: &str = "x86_64-unknown-linux-gnu";

/// Interprets unit tests.
pub(crate) fn miri(arguments: &[String]) -> Result<(), Failure> {
    if let Some(argument) = arguments.first() {
        return Err(format!("miri takes no arguments, not '{argument}'"));
    }
    let folder = Workspace::load()?.target.join("miri");
    for tests in INTERPRETED {
        let mut miri = nightly(&["miri", "test"])?;
        // Time and files are the machine's; arrays of C come as addresses.
        let flags = "-Zmiri-disable-isolation -Zmiri-permissive-provenance";
        command::run(miri.args(tests).env("CARGO_TARGET_DIR", &folder).env("MIRIFLAGS", flags))?;
    }
    Ok(())
}

/// Runs the tests of the C APIs, the library and the programs under a sanitizer.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let [sanitizer] = arguments else {
        return Err("which sanitizer? 'address' or 'thread'".into());
    };
    // Races are found only if the standard library is instrumented, too; and the lock of the C API relies on
    // operations unknown there.
    let (library, flags): (&[&str], &str) = match &sanitizer[..] {
        "address" => (&[], "-Zsanitizer=address"),
        "thread" => (&["-Zbuild-std"], "-Zsanitizer=thread --cfg gnurt_plain_lock"),
        other => return Err(format!("unknown sanitizer '{other}'; there are: address, thread")),
    };
    let folder = Workspace::load()?.target.join(format!("sanitize-{sanitizer}"));
    for tests in C_TESTS {
        // The compiler of the workspace has sanitizers, too, with a flag; the nightly one writes libraries
        // where tests do not search them.
        let mut test = command::cargo();
        test.args(["test", "--target", TARGET]).args(library).args(tests);
        test.env("CARGO_TARGET_DIR", &folder)
            .env("RUSTC_BOOTSTRAP", "1")
            .env("RUSTFLAGS", flags)
            .env("GNURT_C_FLAGS", format!("-g -fsanitize={sanitizer}"));
        command::run(&mut test)?;
    }
    Ok(())
}

/// Cargo of the nightly compiler, which rustup finds.
fn nightly(arguments: &[&str]) -> Result<Command, Failure> {
    command::output_of("rustup", &["run", "nightly", "rustc", "--version"]).map_err(|failure| {
        format!(
            "{failure}; `rustup toolchain install nightly --component miri,rust-src` installs what this needs"
        )
    })?;
    let mut command = Command::new("rustup");
    command.args(["run", "nightly", "cargo"]).args(arguments).current_dir(command::root());
    // The Cargo that runs this names its compiler.
    for variable in ["CARGO", "RUSTC", "RUSTDOC", "RUSTUP_TOOLCHAIN"] {
        command.env_remove(variable);
    }
    Ok(command)
}
