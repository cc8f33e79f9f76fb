// SPDX-License-Identifier: GPL-3.0-or-later
//! Where installed files go: the arguments of `cargo xtask install`. Source: names after GNU's coding standards.

use std::path::{Path, PathBuf};

use super::files::relative;
use crate::failure::Failure;

/// The program, as it is built and installed.
pub(super) const PROGRAM: &str = "gnurt";
pub(super) const USAGE: &str = "usage: cargo xtask install --prefix DIR [--destdir DIR] [--bindir DIR] [--libdir DIR] \
     [--includedir DIR] [--mandir DIR] [--built DIR] [--static] [--no-strip]";

/// Folders of installed files. All folders but the destination are absolute, as programs see them later.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Locations {
    pub(crate) prefix: PathBuf,
    pub(crate) bin: PathBuf,
    /// Libraries; their pkg-config and CMake files go below it.
    pub(crate) lib: PathBuf,
    pub(crate) include: PathBuf,
    pub(crate) man: PathBuf,
    /// A staging folder, from which files are moved later.
    pub(crate) destdir: Option<PathBuf>,
    /// A folder of built files; without it cargo builds.
    pub(crate) built: Option<PathBuf>,
    /// Whether the static library is installed, which is a third of all files.
    pub(crate) has_static: bool,
    /// Whether symbols and debug lines are left out.
    pub(crate) strips: bool,
}

/// Reads the arguments. Folders that are not absolute lie below the prefix: `--libdir lib/x86_64-linux-gnu`.
pub(crate) fn parse(arguments: &[String]) -> Result<Locations, Failure> {
    const NAMES: [&str; 7] =
        ["--prefix", "--destdir", "--bindir", "--libdir", "--includedir", "--mandir", "--built"];
    let mut given: [Option<PathBuf>; NAMES.len()] = Default::default();
    let (mut strips, mut has_static) = (true, false);
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        if argument == "--no-strip" {
            strips = false;
            continue;
        }
        if argument == "--static" {
            has_static = true;
            continue;
        }
        let (name, value) = match argument.split_once('=') {
            Some((name, value)) => (name, Some(value.to_string())),
            None => (&argument[..], None),
        };
        let Some(location) = NAMES.iter().position(|known| *known == name) else {
            return Err(format!("unknown argument '{argument}'; {USAGE}"));
        };
        let value = value.or_else(|| rest.next().cloned()).filter(|value| !value.is_empty());
        given[location] =
            Some(PathBuf::from(value.ok_or_else(|| format!("'{name}' needs a folder; {USAGE}"))?));
    }
    let [prefix, destdir, bin, lib, include, man, built] = given;
    let prefix = prefix.ok_or_else(|| format!("where to? {USAGE}"))?;
    // The pkg-config file needs a path that holds wherever it is read.
    let prefix = std::path::absolute(&prefix).map_err(|error| format!("{}: {error}", prefix.display()))?;
    let below =
        |folder: Option<PathBuf>, default: &str| prefix.join(folder.unwrap_or_else(|| default.into()));
    Ok(Locations {
        bin: below(bin, "bin"),
        lib: below(lib, "lib"),
        include: below(include, "include"),
        man: below(man, "share/man"),
        destdir,
        built,
        has_static,
        strips,
        prefix,
    })
}

impl Locations {
    /// Where a file is copied to that will be seen at `path`.
    pub(crate) fn put(&self, path: &Path) -> PathBuf {
        match &self.destdir {
            // Joining an absolute path would replace the destination.
            Some(destdir) => destdir.join(path.strip_prefix("/").unwrap_or(path)),
            None => path.to_path_buf(),
        }
    }

    /// Makes the folders, and reports unwritable ones and missing files.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        for folder in [&self.bin, &self.lib, &self.include, &self.man].map(|folder| self.put(folder)) {
            let failed = |error| format!("{} cannot be written: {error}", folder.display());
            std::fs::create_dir_all(&folder).map_err(failed)?;
            let probe = folder.join(format!(".gnurt-install-{}", std::process::id()));
            std::fs::write(&probe, "").and_then(|()| std::fs::remove_file(&probe)).map_err(failed)?;
        }
        match &self.built {
            Some(built) if !built.join(PROGRAM).exists() => Err(format!(
                "--built {}: there is no program {PROGRAM}; `cargo build --release --workspace` builds it in target/release",
                built.display()
            )),
            _ => Ok(()),
        }
    }

    /// Below the prefix's `share`.
    pub(crate) fn share(&self, path: &str) -> PathBuf {
        self.prefix.join("share").join(path)
    }

    /// The folder of a package that CMake searches.
    pub(crate) fn cmake(&self) -> PathBuf {
        self.lib.join("cmake")
    }

    /// Fills in the variables of a template.
    pub(crate) fn fill(&self, template: &str, version: &str) -> String {
        let of_prefix = |folder: &Path| match folder.strip_prefix(&self.prefix) {
            Ok(below) => format!("${{prefix}}/{}", below.display()),
            Err(_) => folder.display().to_string(),
        };
        let from_cmake =
            |folder: &Path| relative(&self.cmake().join("package"), folder).display().to_string();
        template
            .replace("@prefix@", &self.prefix.display().to_string())
            .replace("@libdir@", &of_prefix(&self.lib))
            .replace("@includedir@", &of_prefix(&self.include))
            .replace("@libdir_from_here@", &from_cmake(&self.lib))
            .replace("@includedir_from_here@", &from_cmake(&self.include))
            .replace("@version@", version)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(line: &str) -> Vec<String> {
        line.split_whitespace().map(String::from).collect()
    }

    #[test]
    fn arguments_are_read() {
        let locations =
            parse(&tokens("--prefix /usr --destdir=/tmp/x --libdir lib/x86_64-linux-gnu --mandir=/m"));
        let locations = locations.expect("folders are given");
        assert_eq!(
            locations.put(&locations.bin),
            Path::new("/tmp/x/usr/bin"),
            "files go below the destination"
        );
        assert_eq!(locations.lib, Path::new("/usr/lib/x86_64-linux-gnu"), "below the prefix");
        assert_eq!(locations.man, Path::new("/m"), "an absolute one stays");
        assert!(
            locations.strips && !parse(&tokens("--prefix a --no-strip")).expect("no folder").strips,
            "symbols"
        );
        let has_static = |line| parse(&tokens(line)).expect("no folder").has_static;
        assert!(has_static("--static --prefix a") && !has_static("--prefix a"), "the static library");
        for bad in ["", "--prefix", "--prefix=", "--prefx /usr", "/usr", "--prefix / --libdir"] {
            let failure = parse(&tokens(bad)).expect_err("this is no way to call it");
            assert!(failure.contains("usage: cargo xtask install"), "'{bad}' explains itself: {failure}");
        }
    }

    #[test]
    fn what_cannot_be_done_is_told_at_once() {
        let file = std::env::temp_dir().join(format!("gnurt-places-test-{}", std::process::id()));
        std::fs::write(&file, "no folder").expect("the temporary folder can be written");
        let locations =
            parse(&["--prefix".to_owned(), file.display().to_string()]).expect("a folder is given");
        let failure = locations.check().expect_err("it is a file");
        assert!(failure.contains("/bin cannot be written: "), "the folder is named: {failure}");
        std::fs::remove_file(&file).expect("it can be removed");

        let tokens = ["--prefix", &file.display().to_string(), "--built", "/nothing/here"].map(String::from);
        let failure = parse(&tokens).expect("folders").check().expect_err("nothing was built");
        assert!(
            failure.contains("--built /nothing/here: there is no program gnurt"),
            "it is told: {failure}"
        );
        std::fs::remove_dir_all(&file).expect("the test's folder can be removed");
    }

    #[test]
    fn templates_are_filled() {
        let locations =
            parse(&tokens("--prefix /opt/rt --libdir lib/multi --includedir /inc")).expect("folders");
        let filled = locations.fill("@prefix@ @libdir@ @includedir@ @version@ @libdir_from_here@", "1.2");
        assert_eq!(filled, "/opt/rt ${prefix}/lib/multi /inc 1.2 ../..", "each word");
    }
}
