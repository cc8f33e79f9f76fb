// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask dist`: what is given away, in target/dist: the source and the program with its libraries as tarballs, and
//! three Debian packages (gnurt, libopenrt0, libopenrt-dev). Source: original; the split after the Debian policy, chapter 8.
//! Needs git, tar and, for the packages, dpkg-deb; dpkg-shlibdeps says what the packages depend on, where it is installed.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command;
use crate::failure::Failure;
use crate::install::files::{copy, link, tree, write};
use crate::install::{Places, install_at, parse};
use crate::workspace::Workspace;

/// A Debian package, and how to know its files.
struct Package {
    name: &'static str,
    section: &'static str,
    about: &'static str,
    more: &'static str,
    /// What it needs beside the system's libraries.
    needs: &'static [&'static str],
    holds: fn(&str) -> bool,
}

/// The first package that wants a file has it.
const PACKAGES: [Package; 3] = [
    Package {
        name: "libopenrt-dev",
        section: "libdevel",
        about: "ray tracing in the manner of OpenGL - development files",
        more: "Headers, static library, pkg-config and CMake files of OpenRT and rtut.",
        needs: &["libopenrt0 (= @version@)"],
        holds: |path| {
            let below = |part: &str| path.contains(part);
            path.starts_with("usr/include/")
                || below("/pkgconfig/")
                || below("/cmake/")
                || path.starts_with("usr/lib/") && (path.ends_with(".a") || path.ends_with(".so"))
        },
    },
    Package {
        name: "libopenrt0",
        section: "libs",
        about: "ray tracing in the manner of OpenGL - shared libraries",
        more: "libOpenRT is the open implementation of OpenRT; librtut has shapes and a window for its programs.",
        needs: &[],
        holds: |path| path.starts_with("usr/lib/"),
    },
    Package {
        name: "gnurt",
        section: "graphics",
        about: "free ray tracing system",
        more: "Renders scenes (OBJ, PLY, glTF) to pictures, shows them in a window, compares and converts pictures.",
        needs: &[],
        holds: |_| true,
    },
];
const MAINTAINER: &str = "The GNU RT authors <maintainers@example.org>";

/// Makes everything; `--built DIR` takes what cargo has built there.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let workspace = Workspace::load()?;
    let version = &workspace.version;
    let dist = workspace.target.join("dist");
    let _ = std::fs::remove_dir_all(&dist);
    std::fs::create_dir_all(&dist).map_err(|error| format!("{}: {error}", dist.display()))?;

    source_tarball(&dist, version)?;

    let machine = format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS);
    let folder = format!("gnurt-{version}-{machine}");
    install_at(&places(arguments, &dist.join(&folder), "/usr/local", "lib")?)?;
    tarball(&dist, &folder)?;

    if Command::new("dpkg-deb").arg("--version").output().is_err() {
        eprintln!("note: no dpkg-deb here: the Debian packages are left out");
        return Ok(());
    }
    let multiarch = said("dpkg-architecture", &["-qDEB_HOST_MULTIARCH"])
        .unwrap_or_else(|_| format!("{}-linux-gnu", std::env::consts::ARCH));
    let staged = dist.join("debian");
    install_at(&places(arguments, &staged, "/usr", &format!("lib/{multiarch}"))?)?;
    debian(&dist, &staged, version)?;
    std::fs::remove_dir_all(&staged).map_err(|error| format!("{}: {error}", staged.display()))?;
    eprintln!("made {}", dist.display());
    Ok(())
}

fn places(arguments: &[String], destdir: &Path, prefix: &str, lib: &str) -> Result<Places, Failure> {
    let mut words = vec!["--prefix".to_owned(), prefix.to_owned(), "--libdir".to_owned(), lib.to_owned()];
    words.extend(["--destdir".to_owned(), destdir.display().to_string()]);
    words.extend_from_slice(arguments);
    parse(&words)
}

/// What is committed.
fn source_tarball(dist: &Path, version: &str) -> Result<(), Failure> {
    let name = format!("gnurt-{version}");
    let to = dist.join(format!("{name}.tar.gz"));
    let mut archive = Command::new("git");
    archive.current_dir(command::root()).args(["archive", "--format=tar.gz"]);
    command::run(archive.arg(format!("--prefix={name}/")).arg("-o").arg(to).arg("HEAD"))
}

/// A folder in `dist`, as a tarball that is the same for the same files.
fn tarball(dist: &Path, folder: &str) -> Result<(), Failure> {
    let mut tar = Command::new("tar");
    tar.current_dir(dist).args([
        "--sort=name",
        "--owner=0",
        "--group=0",
        "--numeric-owner",
        "--mtime",
        &time()?,
    ]);
    command::run(tar.args(["-czf", &format!("{folder}.tar.gz"), folder]))
}

/// When the last commit was made.
fn time() -> Result<String, Failure> {
    said("git", &["log", "-1", "--format=@%ct"])
}

/// What a tool prints.
fn said(tool: &str, arguments: &[&str]) -> Result<String, Failure> {
    let output = Command::new(tool).current_dir(command::root()).args(arguments).output();
    let output = output.map_err(|error| format!("{tool} cannot be run: {error}"))?;
    if !output.status.success() {
        return Err(format!("{tool} failed: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Shares out the files below `staged`, and packs them.
fn debian(dist: &Path, staged: &Path, version: &str) -> Result<(), Failure> {
    let machine = said("dpkg", &["--print-architecture"])?;
    let all = tree(staged)?;
    for (k, package) in PACKAGES.iter().enumerate() {
        let root = dist.join(package.name);
        let mine: Vec<&PathBuf> = all.iter().filter(|path| owner(path) == Some(k)).collect();
        let mut binaries = Vec::new();
        for path in &mine {
            let (from, to) = (staged.join(path), root.join(path));
            match std::fs::read_link(&from) {
                Ok(target) => link(&target.display().to_string(), &to)?,
                Err(_) => copy(&from, &to)?,
            }
            let is_binary = path.starts_with("usr/bin") || path.to_string_lossy().contains(".so.");
            if is_binary && !to.is_symlink() {
                binaries.push(to);
            }
        }
        let copyright = root.join(format!("usr/share/doc/{}/copyright", package.name));
        write(&copyright, COPYRIGHT)?;
        let bytes: u64 = mine
            .iter()
            .filter_map(|path| root.join(path).symlink_metadata().ok())
            .map(|file| file.len())
            .sum();
        let mut needs = depends(&dist.join("shlibdeps"), &binaries, staged);
        needs.extend(package.needs.iter().map(|need| need.replace("@version@", version)));
        write(
            &root.join("DEBIAN/control"),
            &control(package, version, &machine, bytes.div_ceil(1024), &needs),
        )?;
        if package.name == "libopenrt0" {
            // The program's linker finds the libraries from then on.
            write(&root.join("DEBIAN/triggers"), "activate-noawait ldconfig\n")?;
            write(&root.join("DEBIAN/shlibs"), "libOpenRT 0 libopenrt0\nlibrtut 0 libopenrt0\n")?;
        }
        let to = dist.join(format!("{}_{version}_{machine}.deb", package.name));
        command::run(Command::new("dpkg-deb").args(["--root-owner-group", "--build"]).arg(&root).arg(to))?;
        std::fs::remove_dir_all(&root).map_err(|error| format!("{}: {error}", root.display()))?;
    }
    Ok(())
}

/// The number of the package that holds a file.
fn owner(path: &Path) -> Option<usize> {
    let path = path.to_string_lossy();
    PACKAGES.iter().position(|package| (package.holds)(&path))
}

fn control(package: &Package, version: &str, machine: &str, kilobytes: u64, needs: &[String]) -> String {
    let depends = if needs.is_empty() { String::new() } else { format!("Depends: {}\n", needs.join(", ")) };
    let same = if package.section.starts_with("lib") { "Multi-Arch: same\n" } else { "" };
    format!(
        "Package: {}\nVersion: {version}\nArchitecture: {machine}\n{same}Maintainer: {MAINTAINER}\n\
         Installed-Size: {kilobytes}\nSection: {}\nPriority: optional\n{depends}Description: {}\n {}\n",
        package.name, package.section, package.about, package.more
    )
}

const COPYRIGHT: &str =
    "GNU RT, copyright the GNU RT authors.\n\nGPL-3.0-or-later: see /usr/share/common-licenses/GPL-3.\n";

/// The packages that have the libraries which `binaries` are linked with.
fn depends(work: &Path, binaries: &[PathBuf], staged: &Path) -> Vec<String> {
    if binaries.is_empty() {
        return vec![];
    }
    let guess = || vec!["libc6".to_owned(), "libgcc-s1".to_owned()];
    // The tool looks for the control file of a source package.
    if write(&work.join("debian/control"), "Source: gnurt\n\nPackage: gnurt\nArchitecture: any\n").is_err() {
        return guess();
    }
    let mut tool = Command::new("dpkg-shlibdeps");
    tool.current_dir(work).args(["-O", "--ignore-missing-info"]).arg(format!("-l{}", staged.display()));
    let output = tool.args(binaries.iter().map(|file| format!("-e{}", file.display()))).output();
    let _ = std::fs::remove_dir_all(work);
    match output {
        Ok(output) if output.status.success() => {
            let said = String::from_utf8_lossy(&output.stdout).into_owned();
            let list = said.trim().strip_prefix("shlibs:Depends=").unwrap_or_default().to_owned();
            list.split(',').map(|need| need.trim().to_owned()).filter(|need| !need.is_empty()).collect()
        }
        _ => {
            eprintln!("note: dpkg-shlibdeps of dpkg-dev cannot be used here: dependencies without versions");
            guess()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_shared_out() {
        for (path, package) in [
            ("usr/bin/gnurt", "gnurt"),
            ("usr/share/man/man1/gnurt.1", "gnurt"),
            ("usr/lib/x86_64-linux-gnu/libOpenRT.so.0.1.0", "libopenrt0"),
            ("usr/lib/x86_64-linux-gnu/libOpenRT.so.0", "libopenrt0"),
            ("usr/lib/x86_64-linux-gnu/librtut.so", "libopenrt-dev"),
            ("usr/lib/x86_64-linux-gnu/libOpenRT.a", "libopenrt-dev"),
            ("usr/lib/x86_64-linux-gnu/pkgconfig/openrt.pc", "libopenrt-dev"),
            ("usr/lib/x86_64-linux-gnu/cmake/OpenRT/OpenRTConfig.cmake", "libopenrt-dev"),
            ("usr/include/openrt/rt.h", "libopenrt-dev"),
        ] {
            let found = owner(path.as_ref()).map(|k| PACKAGES[k].name);
            assert_eq!(found, Some(package), "{path}");
        }
    }

    #[test]
    fn controls_are_whole() {
        let text = control(&PACKAGES[0], "1.2.3", "amd64", 7, &["libopenrt0 (= 1.2.3)".to_owned()]);
        for line in [
            "Package: libopenrt-dev",
            "Version: 1.2.3",
            "Architecture: amd64",
            "Depends: libopenrt0 (= 1.2.3)",
        ] {
            assert!(text.lines().any(|other| other == line), "'{line}' in\n{text}");
        }
        assert!(
            !control(&PACKAGES[1], "1", "amd64", 7, &[]).contains("Depends"),
            "an empty list is left out"
        );
    }
}
