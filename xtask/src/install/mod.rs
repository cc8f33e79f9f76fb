// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask install --prefix DIR [--destdir DIR]`: builds and installs the program, the libraries, their headers
//! and pkg-config files, as GNU's coding standards lay them out. Source: original.
//!
//! Files go to DESTDIR/PREFIX, but speak of PREFIX: packagers move them there later. A library's soname is set where
//! it is linked (`bindings/*/build.rs`) and equals the first link made here.

use std::path::{Path, PathBuf};

use crate::command;
use crate::failure::Failure;
use crate::workspace::Workspace;

const PROGRAM: &str = "gnurt";

/// A library with its run-time name, which rises when programs must be linked anew, and its pkg-config template.
struct Library {
    file: &'static str,
    soname: &'static str,
    headers: &'static str,
    template: &'static str,
    package: &'static str,
}

const LIBRARIES: [Library; 2] = [
    Library {
        file: "libOpenRT.so",
        soname: "libOpenRT.so.0",
        headers: "bindings/openrt/include/openrt",
        template: "bindings/openrt/openrt.pc.in",
        package: "lib/pkgconfig/openrt.pc",
    },
    Library {
        file: "librtut.so",
        soname: "librtut.so.0",
        headers: "bindings/rtut/include/openrt",
        template: "bindings/rtut/rtut.pc.in",
        package: "lib/pkgconfig/rtut.pc",
    },
];
const DOCUMENTS: [&str; 4] = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "COPYING"];

/// Where things go.
#[derive(Debug, PartialEq)]
struct Places {
    prefix: PathBuf,
    destdir: Option<PathBuf>,
}

/// Builds in release mode and installs.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let places = parse(arguments)?;
    command::run(command::cargo().args([
        "build",
        "--release",
        "--package",
        "gnurt-cli",
        "--package",
        "openrt",
        "--package",
        "rtut",
    ]))?;
    let workspace = Workspace::load()?;
    let to = places.installed();
    install(&workspace.target.join("release"), &command::root(), &workspace.version, &places)?;
    eprintln!("installed in {}", to.display());
    Ok(())
}

fn parse(arguments: &[String]) -> Result<Places, Failure> {
    let usage = "usage: cargo xtask install --prefix DIR [--destdir DIR]";
    let mut prefix = None;
    let mut destdir = None;
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        let (name, value) = match argument.split_once('=') {
            Some((name, value)) => (name, Some(value.to_string())),
            None => (&argument[..], rest.next().cloned()),
        };
        let slot = match name {
            "--prefix" => &mut prefix,
            "--destdir" => &mut destdir,
            _ => return Err(format!("unknown argument '{argument}'; {usage}")),
        };
        let value = value.filter(|value| !value.is_empty());
        *slot = Some(PathBuf::from(value.ok_or_else(|| format!("'{name}' needs a folder; {usage}"))?));
    }
    let prefix = prefix.ok_or_else(|| format!("where to? {usage}"))?;
    // The pkg-config file needs a path that holds wherever it is read.
    let prefix = std::path::absolute(&prefix).map_err(|error| format!("{}: {error}", prefix.display()))?;
    Ok(Places { prefix, destdir })
}

impl Places {
    /// The folder that files are copied into.
    fn installed(&self) -> PathBuf {
        match &self.destdir {
            // Joining an absolute path would replace the destination.
            Some(destdir) => destdir.join(self.prefix.strip_prefix("/").unwrap_or(&self.prefix)),
            None => self.prefix.clone(),
        }
    }
}

fn install(built: &Path, source: &Path, version: &str, places: &Places) -> Result<(), Failure> {
    let to = places.installed();
    copy(&built.join(PROGRAM), &to.join("bin").join(PROGRAM))?;

    for library in &LIBRARIES {
        let lib = to.join("lib");
        let real = format!("{}.{version}", library.file);
        copy(&built.join(library.file), &lib.join(&real))?;
        link(&real, &lib.join(library.soname))?;
        link(library.soname, &lib.join(library.file))?;
        let headers = files_in(&source.join(library.headers))?;
        for header in headers.iter().filter(|path| path.extension().is_some_and(|e| e == "h")) {
            copy(header, &to.join("include/openrt").join(header.file_name().unwrap_or_default()))?;
        }
        let template = source.join(library.template);
        let template =
            std::fs::read_to_string(&template).map_err(|error| format!("{}: {error}", template.display()))?;
        write(&to.join(library.package), &pkg_config(&template, &places.prefix, version))?;
    }
    for document in DOCUMENTS.iter().map(|name| source.join(name)).filter(|path| path.exists()) {
        copy(&document, &to.join("share/doc/gnurt").join(document.file_name().unwrap_or_default()))?;
    }
    Ok(())
}

/// Fills in what the template leaves open.
fn pkg_config(template: &str, prefix: &Path, version: &str) -> String {
    let prefix = prefix.display().to_string();
    template
        .replace("@prefix@", &prefix)
        .replace("@libdir@", "${prefix}/lib")
        .replace("@includedir@", "${prefix}/include")
        .replace("@version@", version)
}

fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    make_folder(to)?;
    // A running program's file cannot be written, but it can be replaced.
    let _ = std::fs::remove_file(to);
    std::fs::copy(from, to).map_err(|error| format!("{} to {}: {error}", from.display(), to.display()))?;
    Ok(())
}

fn write(to: &Path, text: &str) -> Result<(), Failure> {
    make_folder(to)?;
    std::fs::write(to, text).map_err(|error| format!("{}: {error}", to.display()))
}

fn link(target: &str, to: &Path) -> Result<(), Failure> {
    make_folder(to)?;
    let _ = std::fs::remove_file(to);
    #[cfg(unix)]
    let linked = std::os::unix::fs::symlink(target, to);
    #[cfg(not(unix))]
    let linked = std::fs::copy(to.with_file_name(target), to).map(drop);
    linked.map_err(|error| format!("{}: {error}", to.display()))
}

fn make_folder(file: &Path) -> Result<(), Failure> {
    let folder = file.parent().unwrap_or(file);
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))
}

fn files_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<String> {
        line.split_whitespace().map(String::from).collect()
    }

    #[test]
    fn arguments_are_read() {
        let places = parse(&words("--prefix /usr --destdir=/tmp/x")).expect("both folders are given");
        assert_eq!(places.installed(), Path::new("/tmp/x/usr"), "files go below the destination");
        for bad in ["", "--prefix", "--prefix=", "--prefx /usr", "/usr"] {
            let failure = parse(&words(bad)).expect_err("this is no way to call it");
            assert!(failure.contains("usage: cargo xtask install"), "'{bad}' explains itself: {failure}");
        }
    }

    #[test]
    fn files_find_their_places() {
        let root = std::env::temp_dir().join(format!("gnurt-install-test-{}", std::process::id()));
        let [built, source] = ["built", "source"].map(|name| root.join(name));
        for (path, text) in [
            (built.join("gnurt"), "program"),
            (built.join("libOpenRT.so"), "library"),
            (built.join("librtut.so"), "shapes"),
            (source.join("COPYING"), "licence"),
            (source.join(LIBRARIES[0].template), "prefix=@prefix@\nlibdir=@libdir@\nVersion: @version@\n"),
            (source.join(LIBRARIES[1].template), "prefix=@prefix@\nRequires: openrt\n"),
            (source.join("bindings/openrt/include/openrt/rt.h"), "header"),
            (source.join("bindings/rtut/include/openrt/rtut.h"), "shapes' header"),
        ] {
            write(&path, text).expect("the temporary folder can be written");
        }
        let places = Places { prefix: "/opt/rt".into(), destdir: Some(root.join("to")) };
        // Twice: what is there must be replaced.
        for _ in 0..2 {
            install(&built, &source, "1.2.3", &places).expect("all files are there");
        }
        let read =
            |path: &str| std::fs::read_to_string(root.join("to/opt/rt").join(path)).unwrap_or_default();
        for (path, text) in [
            ("bin/gnurt", "program"),
            ("lib/libOpenRT.so.1.2.3", "library"),
            ("lib/libOpenRT.so.0", "library"),
            ("lib/libOpenRT.so", "library"),
            ("lib/librtut.so.1.2.3", "shapes"),
            ("lib/librtut.so.0", "shapes"),
            ("include/openrt/rt.h", "header"),
            ("include/openrt/rtut.h", "shapes' header"),
            ("lib/pkgconfig/rtut.pc", "prefix=/opt/rt\nRequires: openrt\n"),
            ("share/doc/gnurt/COPYING", "licence"),
        ] {
            assert_eq!(read(path), text, "{path} is in its place");
        }
        assert!(
            read("lib/pkgconfig/openrt.pc").starts_with("prefix=/opt/rt\n"),
            "it speaks of the prefix alone"
        );
        let missing = install(&root.join("none"), &source, "1.2.3", &places).expect_err("nothing was built");
        assert!(missing.contains("none/gnurt"), "the missing file is named: {missing}");
        std::fs::remove_dir_all(&root).expect("the test's folder can be removed");
    }
}
