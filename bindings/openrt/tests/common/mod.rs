// SPDX-License-Identifier: GPL-3.0-or-later
//! Building and running C programs against the libOpenRT that cargo has just built.
#![allow(dead_code, reason = "each test program uses its part")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder with the library under its link name and its run-time name, where programs are built.
pub(crate) struct Workshop {
    folder: tempfile::TempDir,
    libraries: &'static [&'static str],
}

/// Where the crate's sources are.
pub(crate) fn source(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The shared library of this build: cargo puts it beside the test program or one folder above.
pub(crate) fn library() -> PathBuf {
    built("libOpenRT.so")
}

/// A library of this build.
pub(crate) fn built(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a running test has a path");
    let mut neighbours = test.ancestors().skip(1).take(2).map(|folder| folder.join(name));
    neighbours.find(|path| path.exists()).unwrap_or_else(|| panic!("cargo builds {name} with the tests"))
}

impl Workshop {
    /// An empty workshop.
    pub(crate) fn new() -> Self {
        Self::with(&["OpenRT"])
    }

    /// A workshop with these libraries, in the order in which programs are linked with them.
    pub(crate) fn with(libraries: &'static [&'static str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder for programs");
        for library in libraries {
            let name = format!("lib{library}.so");
            for link in [name.clone(), format!("{name}.0")] {
                let link = folder.path().join(link);
                std::os::unix::fs::symlink(built(&name), link).expect("a link to the library");
            }
        }
        Self { folder, libraries }
    }

    /// A path in it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Compiles and links a program, with warnings as errors.
    pub(crate) fn build(&self, compiler: &str, standard: &str, program: &Path) -> PathBuf {
        let binary = self.path(&program.file_stem().expect("a file name").to_string_lossy());
        let output = self.compile(compiler, standard, program, &binary, &[]);
        assert!(output.status.success(), "{} builds:\n{}", program.display(), shown(&output));
        binary
    }

    /// As [`build`](Self::build), with one of the compiler's sanitizers; `None` if it lacks that one.
    pub(crate) fn build_with_sanitizer(
        &self,
        compiler: &str,
        standard: &str,
        program: &Path,
        sanitizer: &str,
    ) -> Option<PathBuf> {
        let stem = program.file_stem().expect("a file name").to_string_lossy();
        let binary = self.path(&format!("{stem}-{sanitizer}"));
        let option = format!("-fsanitize={sanitizer}");
        let output = self.compile(compiler, standard, program, &binary, &["-g", &option]);
        output.status.success().then_some(binary)
    }

    fn compile(
        &self,
        compiler: &str,
        standard: &str,
        program: &Path,
        binary: &Path,
        more: &[&str],
    ) -> Output {
        let folder = self.folder.path().display();
        Command::new(compiler)
            .arg(format!("-std={standard}"))
            .args(["-pedantic", "-Wall", "-Wextra", "-Werror", "-O1"])
            .args(more)
            .arg("-I")
            .arg(source("../openrt/include"))
            .arg("-I")
            .arg(source("../rtut/include"))
            .arg(program)
            .args([format!("-L{folder}"), format!("-Wl,-rpath,{folder}")])
            .args(self.libraries.iter().map(|library| format!("-l{library}")))
            .args(["-lm", "-pthread", "-o"])
            .arg(binary)
            // `cargo xtask sanitize` asks for sanitizers.
            .args(std::env::var("GNURT_C_FLAGS").unwrap_or_default().split_whitespace())
            .output()
            .unwrap_or_else(|error| panic!("{compiler} must be there to build C programs: {error}"))
    }

    /// Runs a program of this workshop; it must end with status 0.
    pub(crate) fn run(&self, binary: &Path, arguments: &[&str]) -> String {
        let output = Command::new(binary).args(arguments).output().expect("a program that was built runs");
        assert!(output.status.success(), "{} {arguments:?}:\n{}", binary.display(), shown(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }
}

fn shown(output: &Output) -> String {
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    format!("{}\n{}{}", output.status, text(&output.stdout), text(&output.stderr))
}
