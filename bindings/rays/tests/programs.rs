// SPDX-License-Identifier: GPL-3.0-or-later
//! C and C++ programs, built by the system's compilers against the library that cargo has just built, and run; each checks itself
//! and ends with status 0. Also the exported symbols of the library.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Where the crate's sources are.
fn source(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The shared library of this build: cargo puts it beside the test program or one folder above.
fn library() -> PathBuf {
    let test = std::env::current_exe().expect("a running test has a path");
    let mut beside = test.ancestors().skip(1).take(2).map(|folder| folder.join("libgnurt_rays.so"));
    beside.find(|path| path.exists()).expect("cargo builds the library with the tests")
}

fn shown(output: &Output) -> String {
    let [reported, said] = [&output.stderr, &output.stdout].map(|text| String::from_utf8_lossy(text));
    format!("{}\n{said}{reported}", output.status)
}

/// A folder with the library under the names that programs know.
struct Workshop(tempfile::TempDir);

impl Workshop {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder for programs");
        for name in ["libgnurt.so", "libgnurt.so.0", "libembree4.so.4"] {
            std::os::unix::fs::symlink(library(), folder.path().join(name)).expect("a link to the library");
        }
        Self(folder)
    }

    /// Compiles and links a program, with warnings as errors.
    fn build(&self, compiler: &str, standard: &str, program: &str) -> PathBuf {
        let program = source(program);
        let binary = self.0.path().join(program.file_stem().expect("a file name"));
        let output = Command::new(compiler)
            .args([
                &format!("-std={standard}"),
                "-O1",
                "-Wall",
                "-Wextra",
                "-Wpedantic",
                "-Werror",
                "-D_GNU_SOURCE",
            ])
            .arg("-I")
            .arg(source("include"))
            .arg("-o")
            .args([&binary, &program])
            .arg("-L")
            .arg(self.0.path())
            .args(["-lgnurt", "-lm", "-lpthread"])
            // `cargo xtask sanitize` asks for sanitizers.
            .args(std::env::var("GNURT_C_FLAGS").unwrap_or_default().split_whitespace())
            .output();
        let output = output.unwrap_or_else(|error| panic!("{compiler} must be there: {error}"));
        assert!(output.status.success(), "{} builds:\n{}", program.display(), shown(&output));
        binary
    }

    fn run(&self, binary: &Path, arguments: &[&str]) -> String {
        // For example `valgrind -q --error-exitcode=9`: the library reads memory of programs, and frees
        // objects at their request.
        let under = std::env::var("GNURT_RUN_UNDER").unwrap_or_default();
        let mut wrapper = under.split_whitespace().map(PathBuf::from).chain([binary.to_owned()]);
        let mut command = Command::new(wrapper.next().expect("the program, if nothing else"));
        let output = command.args(wrapper).args(arguments).env("LD_LIBRARY_PATH", self.0.path()).output();
        let output = output.expect("it runs");
        assert!(output.status.success(), "{} {arguments:?}: {}", binary.display(), shown(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }
}

#[test]
fn calls_of_embree() {
    let workshop = Workshop::new();
    let binary = workshop.build("cc", "c11", "tests/c/embree.c");
    workshop.run(&binary, &[]);
    // The program's expectations are Embree's results.
    match std::env::var_os("EMBREE4_LIB") {
        Some(embree) => {
            let output = Command::new(&binary)
                .arg("queries")
                .envs([
                    ("LD_PRELOAD", embree.as_os_str()),
                    ("LD_LIBRARY_PATH", workshop.0.path().as_os_str()),
                ])
                .output();
            let output = output.expect("it runs");
            assert!(output.status.success(), "on Embree's library: {}", shown(&output));
        }
        None => eprintln!("SKIPPED: the same on Embree's library; EMBREE4_LIB names none"),
    }
}

#[test]
fn calls_of_our_own() {
    let workshop = Workshop::new();
    let binary = workshop.build("cc", "c11", "tests/c/rays.c");
    workshop.run(&binary, &[]);
}

#[test]
fn arrays_threads_and_processes() {
    let workshop = Workshop::new();
    workshop.run(&workshop.build("cc", "c11", "tests/c/edits.c"), &[]);
}

#[test]
fn double_precision() {
    let workshop = Workshop::new();
    workshop.run(&workshop.build("cc", "c11", "tests/c/doubles.c"), &[]);
}

#[test]
fn commits() {
    let workshop = Workshop::new();
    let binary = workshop.build("cc", "c11", "tests/c/joined.c");
    workshop.run(&binary, &[]);
    // A standard error that cannot be written ends no program.
    let full = std::fs::File::options().write(true).open("/dev/full").expect("a device that is full");
    let mut command = Command::new(&binary);
    let status = command.arg("verbose").env("LD_LIBRARY_PATH", workshop.0.path()).stderr(full).status();
    let status = status.expect("it runs");
    assert!(status.success(), "a mistake is told nobody: {status}");
}

#[test]
fn callbacks_get_whole_packets() {
    let workshop = Workshop::new();
    workshop.run(&workshop.build("cc", "c11", "tests/c/frames.c"), &[]);
}

#[test]
fn arrays_of_a_scene_that_is_shown() {
    let workshop = Workshop::new();
    workshop.run(&workshop.build("cc", "c11", "tests/c/stale.c"), &[]);
}

#[test]
fn exceptions() {
    let workshop = Workshop::new();
    workshop.run(&workshop.build("c++", "c++17", "tests/c/throws.cpp"), &[]);
}

/// Examples run, and print their expected output.
#[test]
fn examples() {
    let workshop = Workshop::new();
    let picture = workshop.run(&workshop.build("cc", "c11", "../../examples/rays/shade.c"), &[]);
    let lit = picture.chars().filter(|letter| "-+*%#@".contains(*letter)).count();
    let dark = picture.chars().filter(|&letter| letter == '.').count();
    assert!(
        lit > 100 && dark > 20,
        "a torus, {lit} letters in the light and {dark} in the shadow:\n{picture}"
    );
    let walls = workshop.run(&workshop.build("c++", "c++17", "../../examples/rays/hollow.cpp"), &[]);
    // Up the ball within begins 1 from its middle, and the outer one ends at 2: 1.75 - 1; down 2.25 - 1.
    assert!(walls.contains("  0 degrees: 0.750\n") && walls.contains("180 degrees: 1.250\n"), "{walls}");
}

/// Functions that a header declares: names before a parenthesis that begin with `prefix`.
fn declared(header: &str, prefix: &str) -> BTreeSet<String> {
    let text = std::fs::read_to_string(source(header)).unwrap_or_else(|error| panic!("{header}: {error}"));
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let parts: Vec<&str> = text.split('(').collect();
    let names = parts[..parts.len() - 1].iter();
    let names = names.map(|part| part.rsplit(|c| !is_part(c)).next().unwrap_or_default().to_owned());
    names
        .filter(|name| name.starts_with(prefix) && !name.starts_with("rtcInitR") && !is_inline(name))
        .collect()
}

/// Written out in the header.
fn is_inline(name: &str) -> bool {
    ["rtcInitIntersectArguments", "rtcInitOccludedArguments", "rtcInitPointQueryContext"].contains(&name)
}

#[test]
fn exports_are_the_headers() {
    let output = Command::new("nm").args(["-D", "--defined-only"]).arg(library()).output();
    let output = output.expect("nm of binutils must be there");
    let symbols = String::from_utf8_lossy(&output.stdout).into_owned();
    let exported: BTreeSet<String> =
        symbols.lines().filter_map(|line| line.split_whitespace().nth(2)).map(str::to_owned).collect();
    let embree = declared("include/gnurt/embree.h", "rtc");
    let missing: Vec<_> = embree.difference(&exported).collect();
    assert!(embree.len() > 80, "the header was read: {} functions", embree.len());
    assert!(missing.is_empty(), "declared but not exported: {missing:?}");
    let ours = declared("include/gnurt/rays.h", "gnurt_");
    let shown: BTreeSet<String> =
        exported.iter().filter(|name| name.starts_with("gnurt_")).cloned().collect();
    assert_eq!(ours, shown, "what gnurt/rays.h declares is what there is");
    let extra: Vec<_> =
        exported.iter().filter(|name| !name.starts_with("rtc") && !name.starts_with("gnurt_")).collect();
    assert!(extra.is_empty(), "exported by nobody's wish: {extra:?}");
    let output = Command::new("readelf").arg("-d").arg(library()).output().expect("readelf of binutils");
    let dynamic = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(dynamic.contains("libgnurt.so.0"), "the soname is libgnurt.so.0:\n{dynamic}");
}
