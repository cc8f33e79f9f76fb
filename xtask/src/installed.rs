// SPDX-License-Identifier: GPL-3.0-or-later
//! A part of `cargo xtask ci`: installs the files that the tests have built, and uses them as a new user
//! would.
//!
//! The tests' build has all but the copies under their last names; they and the static library take seconds.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::failure::Failure;
use crate::install::{self, files};
use crate::workspace::Workspace;
use crate::{command, readme};

/// The most bytes that installed files of the tests' build may take.
/// 135.3 MB were measured with motion and media, and with the calls of Embree in a library of their own. With 113.4 MB
/// 35.9 MB were the program, 31.7 MB the static library, 12.7 MB the
/// ANARI device. Windows and options without any optimiser are 3.6 MB of it; optimising
/// them a little takes 60 s more of a core. With debug lines it would be three times as much.
const MOST_INSTALLED: u64 = 144 << 20;

/// Below the prefix, as systems of several machines have it.
const LIB: &str = "lib/multiarch";

/// Installs into `target/installed`, and checks the files there.
pub(crate) fn check(arguments: &[String]) -> Result<(), Failure> {
    if let Some(argument) = arguments.first() {
        return Err(format!("installed takes no arguments, not '{argument}'"));
    }
    command::build_all()?;
    let target = Workspace::load()?.target;
    let built = target.join("debug");
    let to = target.join("installed");
    let _ = std::fs::remove_dir_all(&to);
    install::run(&[
        format!("--prefix={}", to.display()),
        format!("--libdir={LIB}"),
        "--static".to_owned(),
        format!("--built={}", built.display()),
    ])?;
    size(&to)?;
    let user = User { installed: &to, work: target.join("installed-user") };
    let _ = std::fs::remove_dir_all(&user.work);
    std::fs::create_dir_all(&user.work).map_err(|error| format!("{}: {error}", user.work.display()))?;
    user.run("gnurt --version", "gnurt --version")?;
    user.pages()?;
    user.run(
        "completions for bash",
        ". \"$installed/share/bash-completion/completions/gnurt\"; complete -p gnurt",
    )?;
    user.programs()?;
    user.cmake()
}

fn size(installed: &Path) -> Result<(), Failure> {
    let size = |path: &PathBuf| installed.join(path).symlink_metadata().map_or(0, |file| file.len());
    let bytes: u64 = files::tree(installed)?.iter().map(size).sum();
    eprintln!("installed files of the tests' build take {bytes} bytes");
    if bytes > MOST_INSTALLED {
        return Err(format!("that is more than {MOST_INSTALLED}"));
    }
    Ok(())
}

/// A user with only the installed files, and the examples.
struct User<'a> {
    installed: &'a Path,
    work: PathBuf,
}

impl User<'_> {
    /// Every page can be shown, and the program that shows them has no complaint.
    fn pages(&self) -> Result<(), Failure> {
        if !exists("man") {
            return skipped("the man pages are not shown", "man-db");
        }
        let show = "for page in \"$installed\"/share/man/man1/gnurt*.1; do
            said=$(MANWIDTH=80 LC_ALL=C.UTF-8 man --warnings -l \"$page\" 2>&1 > shown) || exit 1
            if [ -n \"$said\" ] || ! grep -q '^SYNOPSIS' shown; then echo \"$page: $said\" >&2; exit 1; fi
        done
        man -w gnurt-render > shown && grep -qF \"$installed\" shown";
        self.run("man pages", show)
    }

    /// The README's program, by the shared library, by the static one, and with everything static: all make the same picture.
    fn programs(&self) -> Result<(), Failure> {
        self.run(
            "pkg-config",
            "pkg-config --validate openrt rtut gnurt && pkg-config --exists 'openrt >= 0.1' rtut 'gnurt >= 0.1'",
        )?;
        let examples = self.work.join("examples/c");
        for file in files::files_in(&command::root().join("examples/c"))? {
            files::copy(&file, &examples.join(file.file_name().unwrap_or_default()))?;
        }
        self.run("the README's program in C", &readme::readme_commands()?.compile)?;
        let source = "examples/c/figure1.c";
        self.run(
            "the static library",
            &format!(
                "cc {source} $(pkg-config --cflags openrt) $(pkg-config --variable=libdir openrt)/libOpenRT.a -lm -o one
                env -u LD_LIBRARY_PATH ./one one.ppm && cmp figure1.ppm one.ppm"
            ),
        )?;
        self.run(
            "a static program",
            &format!(
                "cc -static {source} $(pkg-config --static --cflags --libs openrt) -o all 2> said || {{ cat said >&2; exit 1; }}
                env -u LD_LIBRARY_PATH ./all all.ppm && cmp figure1.ppm all.ppm"
            ),
        )
    }

    /// The same by CMake, and a program in C++ that needs librtut.
    fn cmake(&self) -> Result<(), Failure> {
        if !exists("cmake") {
            return skipped("no program is built by CMake", "cmake");
        }
        files::write(&self.work.join("CMakeLists.txt"), CMAKE)?;
        files::write(&self.work.join("shapes.cpp"), SHAPES)?;
        let lines = "cmake -S . -B cmake -DOpenRT_DIR=\"$lib/cmake/OpenRT\" -Dgnurt_DIR=\"$lib/cmake/gnurt\" > said && cmake --build cmake > said || { cat said >&2; exit 1; }
            unset LD_LIBRARY_PATH
            ./cmake/shared shared.ppm && ./cmake/static static.ppm && ./cmake/shapes
            cmp figure1.ppm shared.ppm && cmp figure1.ppm static.ppm";
        self.run("CMake", lines)
    }

    /// Runs lines of bash in the user's folder, where the installed program, libraries and pages are found; the first that
    /// fails is the last.
    fn run(&self, what: &str, lines: &str) -> Result<(), Failure> {
        eprintln!("+ installed: {what}");
        let lib = self.installed.join(LIB);
        let mut path = std::ffi::OsString::from(self.installed.join("bin"));
        if let Some(others) = std::env::var_os("PATH") {
            path.push(":");
            path.push(others);
        }
        let mut bash = Command::new("bash");
        bash.args(["-euo", "pipefail", "-c", lines]).current_dir(&self.work).env("PATH", path);
        bash.env("installed", self.installed)
            .env("lib", &lib)
            .env("MANPATH", self.installed.join("share/man"));
        bash.env("PKG_CONFIG_PATH", lib.join("pkgconfig")).env("LD_LIBRARY_PATH", &lib);
        match bash.status() {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => {
                Err(format!("{what} failed, as installed in {}: {status}", self.installed.display()))
            }
            Err(error) => Err(format!("bash cannot be run: {error}")),
        }
    }
}

const CMAKE: &str = "cmake_minimum_required(VERSION 3.16)
project(stranger C CXX)
find_package(OpenRT 0.1 REQUIRED)
find_package(gnurt 0.1 REQUIRED)
add_executable(shared examples/c/figure1.c)
target_link_libraries(shared PRIVATE OpenRT::OpenRT m)
add_executable(static examples/c/figure1.c)
target_link_libraries(static PRIVATE OpenRT::static)
add_executable(shapes shapes.cpp)
target_link_libraries(shapes PRIVATE OpenRT::rtut)
";

const SHAPES: &str = "#include <openrt/rt.h>
#include <openrt/rtut.h>
int main(int count, char **words)
{
    rtInit(&count, words);
    rtGenNewShaderClass(\"DiffuseShader\", nullptr);
    rtGenNewShader();
    const RTuint object = rtNewObject(RT_COMPILE);
    rtutTeapot(1);
    rtEndObject();
    const bool good = object != RT_INVALID && rtGetError() == RT_NO_ERROR;
    rtExit();
    return good ? 0 : 1;
}
";

fn exists(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

fn skipped(what: &str, package: &str) -> Result<(), Failure> {
    eprintln!("SKIPPED: {what}; Debian's package {package} has what it needs");
    Ok(())
}
