// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask ci`: everything that must pass before a change is taken.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use crate::failure::Failure;
use crate::workspace::Workspace;
use crate::{arm, command, installed, notices, publish, python, python_upload, readme, tidy};

/// The argument of the second process, which works beside the tests.
const BESIDE_TESTS: &str = "--beside-tests";

/// Runs all checks, the quick ones first; stops at the first that fails.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    match arguments {
        [] => run_all(),
        [argument] if argument == BESIDE_TESTS => run_beside_tests(),
        [argument, ..] => Err(format!("ci takes no arguments, not '{argument}'")),
    }
}

fn run_all() -> Result<(), Failure> {
    let mut steps = Steps::default();
    steps.run("formatting", || command::run(command::cargo().args(["fmt", "--all", "--check"])))?;
    steps.run("tidy", || {
        tidy::run(&[])?;
        notices::check()?;
        python::lint_licences()
    })?;
    let warnings = ["--", "-D", "warnings"];
    // The program of the README's first command, too: it lacks what the features compile.
    let bare = ["clippy", "-p", "gnurt-cli", "--no-default-features"];
    // Beside the linter: pip has one core, and waits for others.
    let packages = std::thread::spawn(|| {
        python::prepare()?;
        python_upload::prepare()
    });
    steps.run("clippy", || {
        command::run(command::cargo().arg("clippy").args(command::TESTED).args(warnings))?;
        command::run(command::cargo().args(bare).args(warnings))
    })?;
    let doc = ["doc", "--workspace", "--no-deps"];
    steps.run("documentation", || {
        let mut doc_command = command::cargo();
        doc_command.args(doc).env("RUSTDOCFLAGS", "-D warnings");
        command::run(as_linted(&mut doc_command)?)
    })?;
    steps.run("other machines", check_for_other_machines)?;
    steps.run("packages for Python", || packages.join().map_err(|_| "their thread panicked")?)?;

    let test = readme::readme_commands()?.test;
    // With the parts that later steps add: built after the tests, these would leave a core idle.
    steps.run("build", command::build_all)?;
    steps.run("tests", || {
        let beside = Beside::start(&Workspace::load()?.target)?;
        let tests = run_words(&test);
        let beside = beside.finish();
        tests.and(beside)
    })?;
    steps.report();
    eprintln!("all checks passed");
    Ok(())
}

/// The steps that need the build and leave cores idle, as some of the tests do.
fn run_beside_tests() -> Result<(), Failure> {
    let mut steps = Steps::default();
    steps.run("ARM", arm::shaders)?;
    steps.run("publishing", || {
        publish::crates(&[])?;
        python_upload::check()
    })?;
    steps.run("installed library", || installed::check(&[]))?;
    let readme_commands = readme::readme_commands()?;
    steps.run("first picture", || first_picture(&readme_commands))?;
    steps.run("Python", || {
        python::run(&[])?;
        python::run(&["--free-threaded".to_owned()])
    })?;
    steps.report();
    Ok(())
}

/// The second process. Its output goes to a file, and is shown when the tests are done.
struct Beside {
    process: Child,
    log: PathBuf,
}

impl Beside {
    fn start(target: &Path) -> Result<Self, Failure> {
        let log = target.join("beside-tests.log");
        let failed = |error: std::io::Error| format!("{}: {error}", log.display());
        let (out, err) = File::create(&log).and_then(|file| Ok((file.try_clone()?, file))).map_err(failed)?;
        // The build may have replaced the file of this process.
        let mut command = Command::new(target.join("debug/xtask"));
        command.args(["ci", BESIDE_TESTS]).stdout(out).stderr(err);
        let process = command.spawn().map_err(|error| format!("the checks beside the tests: {error}"))?;
        Ok(Self { process, log })
    }

    fn finish(mut self) -> Result<(), Failure> {
        let status = self.process.wait().map_err(|error| format!("the checks beside the tests: {error}"))?;
        let log = fs::read(&self.log).map_err(|error| format!("{}: {error}", self.log.display()))?;
        eprintln!("the checks beside the tests:\n{}", String::from_utf8_lossy(&log));
        if status.success() { Ok(()) } else { Err(format!("a check beside the tests failed: {status}")) }
    }
}

/// How long each step took: the whole has a limit.
#[derive(Default)]
struct Steps(Vec<(&'static str, Duration)>);

impl Steps {
    fn run(&mut self, name: &'static str, step: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
        let start = Instant::now();
        let result = step();
        self.0.push((name, start.elapsed()));
        if result.is_err() {
            self.report();
        }
        result
    }

    fn report(&self) {
        for (name, time) in &self.0 {
            eprintln!("{:>5} s  {name}", time.as_secs());
        }
    }
}

/// A command of cargo that takes the metadata of our crates which clippy's step has left; otherwise cargo would check all of
/// them again.
fn as_linted(cargo: &mut Command) -> Result<&mut Command, Failure> {
    let driver = command::output_of("rustc", &["--print", "sysroot"])? + "/bin/clippy-driver";
    if std::path::Path::new(&driver).exists() {
        // As `cargo clippy -- -D warnings` calls it.
        cargo.env("RUSTC_WORKSPACE_WRAPPER", driver);
        cargo.env("CLIPPY_ARGS", "-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__");
    }
    Ok(cargo)
}

/// Further targets, each with the packages that must compile for it.
const OTHER_MACHINES: [(&str, &[&str]); 2] = [
    // All code for its processors, and all that uses lanes.
    ("aarch64-unknown-linux-gnu", &["gnurt-render", "gnurt-jit", "gnurt-plugins", "gnurt-rays"]),
    // Their dependencies are all the libraries that use no window, file lock or signal.
    ("wasm32-unknown-unknown", &["gnurt", "gnurt-osl"]),
];

/// Checks libraries for other machines, those whose standard libraries are installed.
fn check_for_other_machines() -> Result<(), Failure> {
    for (target, packages) in OTHER_MACHINES {
        if !command::has_target(target) {
            eprintln!("SKIPPED: the check for {target}; `rustup target add {target}` installs what it needs");
            continue;
        }
        let mut check = command::cargo();
        check.args(["check", "--target", target]).args(packages.iter().flat_map(|package| ["-p", package]));
        command::run(&mut check)?;
    }
    Ok(())
}

/// Options of a small picture.
const SMALL: [&str; 2] = ["--resolution", "320x180"];

/// Renders the picture of the README's first command, by the program that the tests have built. A second build of everything,
/// for release, would take a quarter of the time of all checks; a picture of full size without it takes a minute.
fn first_picture(readme_commands: &readme::ReadmeCommands) -> Result<(), Failure> {
    let picture = command::root().join(&readme_commands.picture);
    // One left by an earlier run would prove nothing.
    if picture.exists() {
        fs::remove_file(&picture).map_err(|error| format!("{}: {error}", picture.display()))?;
    }
    let program = Workspace::load()?.target.join("debug/gnurt");
    let tokens = readme_commands.first.iter().skip_while(|token| *token != "--").skip(1);
    let mut render = Command::new(program);
    command::run(render.args(tokens).args(SMALL).current_dir(command::root()))?;
    match fs::metadata(&picture) {
        Ok(file) if file.len() > 0 => Ok(()),
        _ => Err(format!("'{}' made no picture {}", readme_commands.first.join(" "), picture.display())),
    }
}

fn run_words(tokens: &[String]) -> Result<(), Failure> {
    command::run(&mut command_of(tokens)?)
}

/// The command of a line, in the workspace's root.
fn command_of(tokens: &[String]) -> Result<Command, Failure> {
    let (program, arguments) = tokens.split_first().ok_or("there is no command to run")?;
    let mut command = if program == "cargo" { command::cargo() } else { Command::new(program) };
    command.args(arguments).current_dir(command::root());
    Ok(command)
}
