// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask install --prefix DIR ...`: builds and installs the program with its man pages and shell completions, the
//! libraries, their headers, and their pkg-config and CMake files, as GNU's coding standards lay them out.
//!
//! Files go to DESTDIR/PREFIX, but refer to PREFIX: packagers move them there later. A library's soname is
//! set where it is linked (`bindings/*/build.rs`) and equals the first link made here.

mod archive;
pub(crate) mod files;
mod locations;

use std::path::Path;
use std::process::Command;

use crate::command;
use crate::failure::Failure;
use crate::notices;
use crate::workspace::Workspace;
use files::{copy, files_in, link, read, write};
pub(crate) use locations::{Locations, parse};
use locations::{PROGRAM, USAGE};

/// A library with its run-time name, which rises when programs must be linked again, and its pkg-config
/// template.
struct Library {
    /// As cargo names it.
    built: &'static str,
    file: &'static str,
    soname: &'static str,
    headers: &'static str,
    /// Where headers go, below the folder for headers.
    folder: &'static str,
    template: &'static str,
    package: &'static str,
}

const LIBRARIES: [Library; 3] = [
    Library {
        built: "libOpenRT.so",
        file: "libOpenRT.so",
        soname: "libOpenRT.so.0",
        headers: "bindings/openrt/include/openrt",
        folder: "openrt",
        template: "bindings/openrt/openrt.pc.in",
        package: "openrt.pc",
    },
    Library {
        built: "librtut.so",
        file: "librtut.so",
        soname: "librtut.so.0",
        headers: "bindings/rtut/include/openrt",
        folder: "openrt",
        template: "bindings/rtut/rtut.pc.in",
        package: "rtut.pc",
    },
    Library {
        // The Rust API has the name without an ending.
        built: "libgnurt_rays.so",
        file: "libgnurt.so",
        soname: "libgnurt.so.0",
        headers: "bindings/rays/include/gnurt",
        folder: "gnurt",
        template: "bindings/rays/gnurt.pc.in",
        package: "gnurt.pc",
    },
];
/// The library of Embree's calls: as cargo names it, and as Embree's programs do. In a folder of its own, so that no program
/// takes it for Embree unasked.
const EMBREE: (&str, &str) = ("libgnurt_embree.so", "libembree4.so.4");
/// That folder, below the one for libraries.
const EMBREE_FOLDER: &str = "gnurt/embree";
/// Its header and its pkg-config template.
const EMBREE_HEADER: &str = "bindings/embree/include/gnurt/embree.h";
const EMBREE_PACKAGE: (&str, &str) = ("bindings/embree/gnurt-embree.pc.in", "gnurt-embree.pc");
/// The device that programs load by ANARI's loader: it has no headers, and is never linked.
const DEVICE: &str = "libanari_library_gnurt.so";
/// Its pkg-config template.
const DEVICE_PACKAGE: (&str, &str) = ("bindings/anari/gnurt-anari.pc.in", "gnurt-anari.pc");
/// Templates, and their names in CMake's folder.
const CMAKE: [(&str, &str); 6] = [
    ("bindings/openrt/OpenRTConfig.cmake.in", "OpenRT/OpenRTConfig.cmake"),
    ("bindings/openrt/OpenRTConfigVersion.cmake.in", "OpenRT/OpenRTConfigVersion.cmake"),
    ("bindings/rays/gnurtConfig.cmake.in", "gnurt/gnurtConfig.cmake"),
    ("bindings/openrt/OpenRTConfigVersion.cmake.in", "gnurt/gnurtConfigVersion.cmake"),
    ("bindings/anari/gnurt-anariConfig.cmake.in", "gnurt-anari/gnurt-anariConfig.cmake"),
    ("bindings/openrt/OpenRTConfigVersion.cmake.in", "gnurt-anari/gnurt-anariConfigVersion.cmake"),
];
const DOCUMENTS: [&str; 4] = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "COPYING"];

/// Builds in release mode and installs.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    if arguments == ["--help"] {
        eprintln!("{USAGE}");
        return Ok(());
    }
    let locations = parse(arguments)?;
    // Reported before minutes of building, not after.
    locations.check()?;
    install_at(&locations)?;
    eprintln!("installed in {}", locations.put(&locations.prefix).display());
    Ok(())
}

/// Builds, unless that was done, and installs.
pub(crate) fn install_at(locations: &Locations) -> Result<(), Failure> {
    let workspace = Workspace::load()?;
    let built = match &locations.built {
        Some(built) => built.clone(),
        None => {
            let packages = [
                "--package",
                "gnurt-cli",
                "--package",
                "openrt",
                "--package",
                "rtut",
                "--package",
                "gnurt-rays",
                "--package",
                "gnurt-embree",
                "--package",
                "gnurt-anari",
                "--features",
                "gnurt-cli/installed",
            ];
            command::run(command::cargo().args(["build", "--release"]).args(packages))?;
            workspace.target.join("release")
        }
    };
    if locations.has_static {
        archive::build(&built)?;
    }
    install(&built, &command::root(), &workspace.version, locations)?;
    // The program writes its own pages, from its own options.
    let manuals = workspace.target.join("manuals");
    let _ = std::fs::remove_dir_all(&manuals);
    command::run(Command::new(built.join(PROGRAM)).arg("manuals").arg(&manuals))?;
    install_manuals(&manuals, locations)
}

fn install(built: &Path, source: &Path, version: &str, locations: &Locations) -> Result<(), Failure> {
    copy_binary(&built.join(PROGRAM), &locations.put(&locations.bin.join(PROGRAM)), locations.strips)?;
    let lib = locations.put(&locations.lib);
    for library in &LIBRARIES {
        let real = format!("{}.{version}", library.file);
        copy_binary(&built.join(library.built), &lib.join(&real), locations.strips)?;
        link(&real, &lib.join(library.soname))?;
        link(library.soname, &lib.join(library.file))?;
        let headers = files_in(&source.join(library.headers))?;
        for header in headers.iter().filter(|path| path.extension().is_some_and(|e| e == "h")) {
            let to = locations.include.join(library.folder).join(header.file_name().unwrap_or_default());
            copy(header, &locations.put(&to))?;
        }
        let template = read(&source.join(library.template))?;
        write(&lib.join("pkgconfig").join(library.package), &locations.fill(&template, version))?;
    }
    let (name, soname) = EMBREE;
    let embree = lib.join(EMBREE_FOLDER);
    copy_binary(&built.join(name), &embree.join(soname), locations.strips)?;
    link(soname, &embree.join("libembree4.so"))?;
    copy(&source.join(EMBREE_HEADER), &locations.put(&locations.include.join("gnurt/embree.h")))?;
    copy_binary(&built.join(DEVICE), &lib.join(DEVICE), locations.strips)?;
    for (template, package) in [DEVICE_PACKAGE, EMBREE_PACKAGE] {
        let template = read(&source.join(template))?;
        write(&lib.join("pkgconfig").join(package), &locations.fill(&template, version))?;
    }
    for (template, file) in CMAKE {
        let template = read(&source.join(template))?;
        write(&locations.put(&locations.cmake().join(file)), &locations.fill(&template, version))?;
    }
    if locations.has_static {
        copy(&built.join(archive::NAME), &lib.join("libOpenRT.a"))?;
    }
    for document in DOCUMENTS.iter().map(|name| source.join(name)).filter(|path| path.exists()) {
        let to = locations.share("doc/gnurt").join(document.file_name().unwrap_or_default());
        copy(&document, &locations.put(&to))?;
    }
    write(&locations.put(&locations.share("doc/gnurt/LICENSE-THIRD-PARTY.txt")), &notices::retained(source)?)
}

/// Man pages, completions and the reference of the command line, by their endings.
fn install_manuals(manuals: &Path, locations: &Locations) -> Result<(), Failure> {
    for file in files_in(manuals)? {
        let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let to = match name.rsplit_once('.') {
            Some((_, "md")) => locations.share("doc/gnurt").join(name),
            Some((_, "1")) => locations.man.join("man1").join(name),
            Some((stem, "bash")) => locations.share("bash-completion/completions").join(stem),
            Some((_, "fish")) => locations.share("fish/vendor_completions.d").join(name),
            None if name.starts_with('_') => locations.share("zsh/site-functions").join(name),
            _ => return Err(format!("{}: unknown kind of manual", file.display())),
        };
        copy(&file, &locations.put(&to))?;
    }
    Ok(())
}

fn copy_binary(from: &Path, to: &Path, strips: bool) -> Result<(), Failure> {
    copy(from, to)?;
    if strips {
        strip(to)?;
    }
    Ok(())
}

/// Leaves out symbols and debug lines, which are nine tenths of a file.
fn strip(file: &Path) -> Result<(), Failure> {
    let tool = std::env::var_os("STRIP").unwrap_or_else(|| "strip".into());
    let output = Command::new(&tool).arg("--strip-unneeded").arg(file).output();
    match output {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => {
            Err(format!("strip {}: {}", file.display(), String::from_utf8_lossy(&output.stderr).trim()))
        }
        Err(error) => Err(format!(
            "{} cannot be run: {error}; install binutils, or ask for --no-strip",
            Path::new(&tool).display()
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_find_their_places() {
        let root = std::env::temp_dir().join(format!("gnurt-install-test-{}", std::process::id()));
        let notices_of_all = "Copyright A\n".repeat(2000);
        let [built, source] = ["built", "source"].map(|name| root.join(name));
        for (path, text) in [
            (built.join("gnurt"), "program"),
            (built.join("libOpenRT.so"), "library"),
            (built.join("librtut.so"), "shapes"),
            (built.join("libgnurt_rays.so"), "rays"),
            (built.join(EMBREE.0), "embree"),
            (source.join(EMBREE_PACKAGE.0), "libdir=@libdir@\n"),
            (built.join(DEVICE), "device"),
            (source.join(DEVICE_PACKAGE.0), "libdir=@libdir@\n"),
            (source.join("bindings/anari/gnurt-anariConfig.cmake.in"), "@libdir_from_here@"),
            (built.join(archive::NAME), "archive"),
            (source.join("COPYING"), "licence"),
            (source.join(notices::FILE), &notices_of_all[..]),
            (source.join(LIBRARIES[0].template), "prefix=@prefix@\nlibdir=@libdir@\nVersion: @version@\n"),
            (source.join(LIBRARIES[1].template), "prefix=@prefix@\nRequires: openrt\n"),
            (source.join(LIBRARIES[2].template), "Libs: -lgnurt\n"),
            (source.join("bindings/rays/gnurtConfig.cmake.in"), "@libdir_from_here@"),
            (source.join("bindings/rays/include/gnurt/rays.h"), "queries"),
            (source.join(EMBREE_HEADER), "calls"),
            (source.join("bindings/openrt/OpenRTConfig.cmake.in"), "@includedir_from_here@"),
            (source.join("bindings/openrt/OpenRTConfigVersion.cmake.in"), "@version@"),
            (source.join("bindings/openrt/include/openrt/rt.h"), "header"),
            (source.join("bindings/rtut/include/openrt/rtut.h"), "shapes' header"),
            (root.join("manuals/gnurt-render.1"), "page"),
            (root.join("manuals/gnurt.bash"), "bash"),
            (root.join("manuals/gnurt.fish"), "fish"),
            (root.join("manuals/_gnurt"), "zsh"),
        ] {
            write(&path, text).expect("the temporary folder can be written");
        }
        let to = root.join("to").display().to_string();
        let tokens = ["--prefix=/opt/rt", "--no-strip", "--static", "--libdir=lib/multi", "--destdir", &to];
        let locations = parse(&tokens.map(String::from)).expect("these are folders");
        // Twice: existing files must be replaced.
        for _ in 0..2 {
            install(&built, &source, "1.2.3", &locations).expect("all files are there");
            install_manuals(&root.join("manuals"), &locations).expect("all are known");
        }
        let read =
            |path: &str| std::fs::read_to_string(root.join("to/opt/rt").join(path)).unwrap_or_default();
        for (path, text) in [
            ("bin/gnurt", "program"),
            ("lib/multi/libOpenRT.so.1.2.3", "library"),
            ("lib/multi/libOpenRT.so.0", "library"),
            ("lib/multi/libOpenRT.so", "library"),
            ("lib/multi/libOpenRT.a", "archive"),
            ("lib/multi/librtut.so.1.2.3", "shapes"),
            ("lib/multi/librtut.so.0", "shapes"),
            ("lib/multi/libgnurt.so.1.2.3", "rays"),
            ("lib/multi/libgnurt.so", "rays"),
            ("lib/multi/gnurt/embree/libembree4.so.4", "embree"),
            ("lib/multi/gnurt/embree/libembree4.so", "embree"),
            ("lib/multi/libanari_library_gnurt.so", "device"),
            ("lib/multi/pkgconfig/gnurt-anari.pc", "libdir=${prefix}/lib/multi\n"),
            ("lib/multi/cmake/gnurt-anari/gnurt-anariConfig.cmake", "../.."),
            ("lib/multi/cmake/gnurt/gnurtConfig.cmake", "../.."),
            ("lib/multi/cmake/gnurt/gnurtConfigVersion.cmake", "1.2.3"),
            ("lib/multi/pkgconfig/gnurt.pc", "Libs: -lgnurt\n"),
            ("include/gnurt/embree.h", "calls"),
            ("lib/multi/cmake/OpenRT/OpenRTConfig.cmake", "../../../../include"),
            ("lib/multi/cmake/OpenRT/OpenRTConfigVersion.cmake", "1.2.3"),
            ("lib/multi/pkgconfig/rtut.pc", "prefix=/opt/rt\nRequires: openrt\n"),
            ("include/openrt/rt.h", "header"),
            ("include/openrt/rtut.h", "shapes' header"),
            ("share/doc/gnurt/COPYING", "licence"),
            ("share/doc/gnurt/LICENSE-THIRD-PARTY.txt", &notices_of_all[..]),
            ("share/man/man1/gnurt-render.1", "page"),
            ("share/bash-completion/completions/gnurt", "bash"),
            ("share/fish/vendor_completions.d/gnurt.fish", "fish"),
            ("share/zsh/site-functions/_gnurt", "zsh"),
        ] {
            assert_eq!(read(path), text, "{path} is in its place");
        }
        assert!(
            read("lib/multi/pkgconfig/openrt.pc").starts_with("prefix=/opt/rt\nlibdir=${prefix}/lib/multi\n"),
            "it speaks of the prefix alone"
        );
        let missing =
            install(&root.join("none"), &source, "1.2.3", &locations).expect_err("nothing was built");
        assert!(missing.contains("none/gnurt"), "the missing file is named: {missing}");
        write(&source.join(notices::FILE), "").expect("it can be written again");
        let empty = install(&built, &source, "1.2.3", &locations).expect_err("no notices");
        assert!(empty.contains(notices::FILE), "{empty}");
        std::fs::remove_dir_all(&root).expect("the test's folder can be removed");
    }
}
