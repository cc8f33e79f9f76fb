// SPDX-License-Identifier: GPL-3.0-or-later
//! C and C++ programs, built by the system's compilers against the libraries that cargo has just built, and run. For the tests of
//! libgnurt and of Embree's calls, which are two crates.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder with libraries under the names that programs know.
pub(crate) struct Workshop {
    pub(crate) folder: tempfile::TempDir,
    /// What it is linked with.
    libraries: Vec<&'static str>,
}

/// A file of a crate beside this one.
pub(crate) fn source(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// A shared library of this build: cargo puts it beside the test program or one folder above.
pub(crate) fn library(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a running test has a path");
    let mut beside = test.ancestors().skip(1).take(2).map(|folder| folder.join(name));
    beside.find(|path| path.exists()).expect("cargo builds the library with the tests")
}

pub(crate) fn shown(output: &Output) -> String {
    let [reported, said] = [&output.stderr, &output.stdout].map(|text| String::from_utf8_lossy(text));
    format!("{}\n{said}{reported}", output.status)
}

impl Workshop {
    /// With links of these names to libraries, and programs that are linked with these.
    pub(crate) fn new(links: &[(&str, &str)], libraries: &[&'static str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder for programs");
        for (name, built) in links {
            std::os::unix::fs::symlink(library(built), folder.path().join(name))
                .expect("a link to the library");
        }
        Self { folder, libraries: libraries.to_vec() }
    }

    /// Compiles and links a program, with warnings as errors.
    pub(crate) fn build(&self, compiler: &str, standard: &str, program: &str) -> PathBuf {
        let program = source(program);
        let binary = self.folder.path().join(program.file_stem().expect("a file name"));
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
            .args(["rays/include", "embree/include", "rays/tests/c"].map(|path| {
                let mut option = std::ffi::OsString::from("-I");
                option.push(source(path));
                option
            }))
            .arg("-o")
            .args([&binary, &program])
            .arg("-L")
            .arg(self.folder.path())
            .args(&self.libraries)
            .args(["-lm", "-lpthread"])
            // `cargo xtask sanitize` asks for sanitizers.
            .args(std::env::var("GNURT_C_FLAGS").unwrap_or_default().split_whitespace())
            .output();
        let output = output.unwrap_or_else(|error| panic!("{compiler} must be there: {error}"));
        assert!(output.status.success(), "{} builds:\n{}", program.display(), shown(&output));
        binary
    }

    pub(crate) fn run(&self, binary: &Path, arguments: &[&str]) -> String {
        // For example `valgrind -q --error-exitcode=9`: the library reads memory of programs, and frees
        // objects at their request.
        let under = std::env::var("GNURT_RUN_UNDER").unwrap_or_default();
        let mut wrapper = under.split_whitespace().map(PathBuf::from).chain([binary.to_owned()]);
        let mut command = Command::new(wrapper.next().expect("the program, if nothing else"));
        let folder = self.folder.path();
        let output = command.args(wrapper).args(arguments).env("LD_LIBRARY_PATH", folder).output();
        let output = output.expect("it runs");
        assert!(output.status.success(), "{} {arguments:?}: {}", binary.display(), shown(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }
}

/// Functions that a header declares: names before a parenthesis that begin with `prefix`.
pub(crate) fn declared(header: &str, prefix: &str) -> BTreeSet<String> {
    let text = std::fs::read_to_string(source(header)).unwrap_or_else(|error| panic!("{header}: {error}"));
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let parts: Vec<&str> = text.split('(').collect();
    let names = parts[..parts.len() - 1].iter();
    let names = names.map(|part| part.rsplit(|c| !is_part(c)).next().unwrap_or_default().to_owned());
    names.filter(|name| name.starts_with(prefix)).collect()
}

/// Functions that a library exports, and that its run-time name is this.
pub(crate) fn exported(library: &Path, soname: &str) -> BTreeSet<String> {
    let output = Command::new("nm").args(["-D", "--defined-only"]).arg(library).output();
    let output = output.expect("nm of binutils must be there");
    let symbols = String::from_utf8_lossy(&output.stdout).into_owned();
    let output = Command::new("readelf").arg("-d").arg(library).output().expect("readelf of binutils");
    let dynamic = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(dynamic.contains(soname), "the soname is {soname}:\n{dynamic}");
    symbols.lines().filter_map(|line| line.split_whitespace().nth(2)).map(str::to_owned).collect()
}
