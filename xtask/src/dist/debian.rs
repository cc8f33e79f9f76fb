// SPDX-License-Identifier: GPL-3.0-or-later
//! The Debian packages gnurt, libopenrt0 and libopenrt-dev, out of an installed tree. The split and the files that every package has after the Debian policy, chapters 8 and 12. `lintian` finds no error in them.
//! dpkg-shlibdeps finds their dependencies, if it is installed.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{self, output_of};
use crate::failure::Failure;
use crate::install::files::{copy, link, tree, write};
use crate::notices;

/// A Debian package, and a test for its files.
struct Package {
    name: &'static str,
    section: &'static str,
    about: &'static str,
    more: &'static str,
    /// Further dependencies in addition to the system's libraries.
    needs: &'static [&'static str],
    /// Libraries that it opens only with a window.
    window: bool,
    holds: fn(&str) -> bool,
}

/// The first package that claims a file has it.
const PACKAGES: [Package; 3] = [
    Package {
        name: "libopenrt-dev",
        section: "libdevel",
        about: "ray tracing in the manner of OpenGL - development files",
        more: "Headers, static library, pkg-config and CMake files of OpenRT and rtut.",
        needs: &["libopenrt0 (= @version@)"],
        window: false,
        holds: |path| {
            let below = |part: &str| path.contains(part);
            path.starts_with("usr/include/")
                || below("/pkgconfig/")
                || below("/cmake/")
                // Programs load the ANARI device by this name.
                || path.starts_with("usr/lib/")
                    && (path.ends_with(".a") || path.ends_with(".so") && !below("libanari_library_"))
        },
    },
    Package {
        name: "libopenrt0",
        section: "libs",
        about: "ray tracing in the manner of OpenGL - shared libraries",
        more: "libOpenRT is the open implementation of OpenRT; librtut has shapes and a\n window for its programs.",
        needs: &[],
        window: true,
        holds: |path| path.starts_with("usr/lib/"),
    },
    Package {
        name: "gnurt",
        section: "graphics",
        about: "free ray tracing system",
        more: "Renders scenes (OBJ, PLY, glTF) to pictures, shows them in a window,\n compares and converts pictures.",
        needs: &[],
        window: true,
        holds: |_| true,
    },
];
/// Debian's names of the libraries that a window opens; without one nothing of them is needed.
const WINDOW: &str =
    "libwayland-client0, libx11-6, libx11-xcb1, libxcursor1, libxi6, libxkbcommon0, libxkbcommon-x11-0";
const MAINTAINER: &str = "The GNU RT authors <maintainers@example.org>";

/// Shares out the files below `staged`, and packs them.
pub(super) fn pack(dist: &Path, staged: &Path, version: &str) -> Result<(), Failure> {
    let machine = output_of("dpkg", &["--print-architecture"])?;
    let all = tree(staged)?;
    for (k, package) in PACKAGES.iter().enumerate() {
        let root = dist.join(package.name);
        let mine = all.iter().filter(|path| owner(path) == Some(k));
        let binaries = fill(&root, staged, mine)?;
        documents(&root.join("usr/share/doc").join(package.name), version)?;
        let mut needs = depends(&dist.join("shlibdeps"), &binaries, staged);
        needs.extend(package.needs.iter().map(|need| need.replace("@version@", version)));
        let control = control(package, version, &machine, kilobytes(&root)?, &needs);
        write(&root.join("DEBIAN/control"), &control)?;
        if package.name == "libopenrt0" {
            // The program's linker finds the libraries from then on.
            write(&root.join("DEBIAN/triggers"), "activate-noawait ldconfig\n")?;
            write(
                &root.join("DEBIAN/shlibs"),
                "libOpenRT 0 libopenrt0\nlibgnurt 0 libopenrt0\nlibrtut 0 libopenrt0\n",
            )?;
        }
        let to = dist.join(format!("{}_{version}_{machine}.deb", package.name));
        let mut deb = Command::new("dpkg-deb");
        // No file is younger than the last commit: the same files make the same package.
        deb.env("SOURCE_DATE_EPOCH", output_of("git", &["log", "-1", "--format=%ct"])?);
        command::run(deb.args(["--root-owner-group", "--build"]).arg(&root).arg(to))?;
        std::fs::remove_dir_all(&root).map_err(|error| format!("{}: {error}", root.display()))?;
    }
    Ok(())
}

/// Copies a package's files to `root`, in the form that the policy requires. Returns its programs and
/// libraries.
fn fill<'a>(
    root: &Path,
    staged: &Path,
    files: impl Iterator<Item = &'a PathBuf>,
) -> Result<Vec<PathBuf>, Failure> {
    let mut binaries = Vec::new();
    for path in files {
        let (from, to) = (staged.join(path), root.join(path));
        if let Ok(target) = std::fs::read_link(&from) {
            link(&target.display().to_string(), &to)?;
            continue;
        }
        copy(&from, &to)?;
        let is_library = path.to_string_lossy().contains(".so.");
        if is_library {
            // It is loaded, not run.
            set_mode(&to, 0o644)?;
        }
        if is_library || path.starts_with("usr/bin") {
            binaries.push(to);
        } else if path.starts_with("usr/share/man") {
            gzip(&to)?;
        }
    }
    Ok(binaries)
}

/// The two documents that every package has, in its folder of documents. Its copyright file holds the notices
/// of all parts, which the policy (12.5) requires in full; as free text, since the parts' own texts fit no
/// other form.
fn documents(folder: &Path, version: &str) -> Result<(), Failure> {
    let year = output_of("git", &["log", "-1", "--format=%cd", "--date=format:%Y"])?;
    let notices = notices::retained(&command::root())?;
    write(&folder.join("copyright"), &(COPYRIGHT.replace("@year@", &year) + &notices))?;
    let date = output_of("git", &["log", "-1", "--format=%cD"])?;
    let changelog = folder.join("changelog");
    let text =
        format!("gnurt ({version}) unstable; urgency=medium\n\n  * {CHANGES}\n\n -- {MAINTAINER}  {date}\n");
    write(&changelog, &text)?;
    gzip(&changelog)
}

/// Compresses a file, with no name and time inside: the same for the same file.
fn gzip(file: &Path) -> Result<(), Failure> {
    let status = Command::new("gzip").arg("-9nf").arg(file).status();
    let status = status.map_err(|error| format!("gzip cannot be run: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("gzip {} failed: {status}", file.display())) }
}

fn set_mode(file: &Path, mode: u32) -> Result<(), Failure> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let set = std::fs::set_permissions(file, std::fs::Permissions::from_mode(mode));
        set.map_err(|error| format!("{}: {error}", file.display()))?;
    }
    let _ = (file, mode);
    Ok(())
}

/// Size of the files below a folder.
fn kilobytes(root: &Path) -> Result<u64, Failure> {
    let size = |path: PathBuf| root.join(path).symlink_metadata().map_or(0, |file| file.len());
    Ok(tree(root)?.into_iter().map(size).sum::<u64>().div_ceil(1024))
}

/// The number of the package that holds a file.
fn owner(path: &Path) -> Option<usize> {
    let path = path.to_string_lossy();
    PACKAGES.iter().position(|package| (package.holds)(&path))
}

fn control(package: &Package, version: &str, machine: &str, kilobytes: u64, needs: &[String]) -> String {
    let depends = if needs.is_empty() { String::new() } else { format!("Depends: {}\n", needs.join(", ")) };
    let window = if package.window { format!("Recommends: {WINDOW}\n") } else { String::new() };
    let same = if package.section.starts_with("lib") { "Multi-Arch: same\n" } else { "" };
    format!(
        "Package: {}\nVersion: {version}\nArchitecture: {machine}\n{same}Maintainer: {MAINTAINER}\n\
         Installed-Size: {kilobytes}\nSection: {}\nPriority: optional\n{depends}{window}Description: {}\n {}\n",
        package.name, package.section, package.about, package.more
    )
}

const COPYRIGHT: &str = "GNU RT

Copyright: @year@ The GNU RT authors

GNU RT is free software: you can redistribute it and/or modify it under the
terms of the GNU General Public License as published by the Free Software
Foundation, either version 3 of the License, or (at your option) any later
version. It is distributed in the hope that it will be useful, but WITHOUT
ANY WARRANTY; without even the implied warranty of MERCHANTABILITY or FITNESS
FOR A PARTICULAR PURPOSE.

On Debian systems the whole license is in /usr/share/common-licenses/GPL-3.

";

/// The changelog: the project keeps its own.
const CHANGES: &str = "See CHANGELOG.md, which the package gnurt has in its folder of documents.";

/// The packages that have the libraries which `binaries` are linked with.
fn depends(work: &Path, binaries: &[PathBuf], staged: &Path) -> Vec<String> {
    if binaries.is_empty() {
        return vec![];
    }
    let guess = || vec!["libc6".to_owned(), "libgcc-s1".to_owned()];
    // The tool requires the control file of a source package.
    if write(&work.join("debian/control"), "Source: gnurt\n\nPackage: gnurt\nArchitecture: any\n").is_err() {
        return guess();
    }
    let mut tool = Command::new("dpkg-shlibdeps");
    tool.current_dir(work).args(["-O", "--ignore-missing-info"]).arg(format!("-l{}", staged.display()));
    let output = tool.args(binaries.iter().map(|file| format!("-e{}", file.display()))).output();
    let _ = std::fs::remove_dir_all(work);
    match output {
        Ok(output) if output.status.success() => {
            let output_of = String::from_utf8_lossy(&output.stdout).into_owned();
            let list = output_of.trim().strip_prefix("shlibs:Depends=").unwrap_or_default().to_owned();
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
        let recommends = |k: usize| control(&PACKAGES[k], "1", "amd64", 7, &[]).contains("\nRecommends: ");
        assert!(!recommends(0) && recommends(1) && recommends(2), "windows open libraries");
        for package in &PACKAGES {
            let all_short = package.more.lines().all(|line| line.len() < 80);
            assert!(all_short, "{}: readers of packages have 80 columns", package.name);
        }
        assert!(
            !control(&PACKAGES[1], "1", "amd64", 7, &[]).contains("Depends"),
            "an empty list is left out"
        );
    }
}
