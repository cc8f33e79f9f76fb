// SPDX-License-Identifier: GPL-3.0-or-later
//! Where installed files go: the arguments of `cargo xtask install`. Source: names after GNU's coding standards.

use std::path::{Path, PathBuf};

use super::files::relative;
use crate::failure::Failure;

pub(crate) const USAGE: &str = "usage: cargo xtask install --prefix DIR [--destdir DIR] [--bindir DIR] [--libdir DIR] \
     [--includedir DIR] [--mandir DIR] [--built DIR] [--no-strip]";

/// Where things go. All folders but the destination are absolute, as programs see them later.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Places {
    pub(crate) prefix: PathBuf,
    pub(crate) bin: PathBuf,
    /// Libraries; their pkg-config and CMake files go below it.
    pub(crate) lib: PathBuf,
    pub(crate) include: PathBuf,
    pub(crate) man: PathBuf,
    /// Where files go instead, until somebody moves them.
    pub(crate) destdir: Option<PathBuf>,
    /// What cargo has built already; else it builds.
    pub(crate) built: Option<PathBuf>,
    /// Whether symbols and debug lines are left out.
    pub(crate) strips: bool,
}

/// Reads the arguments. Folders that are not absolute lie below the prefix: `--libdir lib/x86_64-linux-gnu`.
pub(crate) fn parse(arguments: &[String]) -> Result<Places, Failure> {
    const NAMES: [&str; 7] =
        ["--prefix", "--destdir", "--bindir", "--libdir", "--includedir", "--mandir", "--built"];
    let mut given: [Option<PathBuf>; NAMES.len()] = Default::default();
    let mut strips = true;
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        if argument == "--no-strip" {
            strips = false;
            continue;
        }
        let (name, value) = match argument.split_once('=') {
            Some((name, value)) => (name, Some(value.to_string())),
            None => (&argument[..], None),
        };
        let Some(place) = NAMES.iter().position(|known| *known == name) else {
            return Err(format!("unknown argument '{argument}'; {USAGE}"));
        };
        let value = value.or_else(|| rest.next().cloned()).filter(|value| !value.is_empty());
        given[place] = Some(PathBuf::from(value.ok_or_else(|| format!("'{name}' needs a folder; {USAGE}"))?));
    }
    let [prefix, destdir, bin, lib, include, man, built] = given;
    let prefix = prefix.ok_or_else(|| format!("where to? {USAGE}"))?;
    // The pkg-config file needs a path that holds wherever it is read.
    let prefix = std::path::absolute(&prefix).map_err(|error| format!("{}: {error}", prefix.display()))?;
    let below =
        |folder: Option<PathBuf>, default: &str| prefix.join(folder.unwrap_or_else(|| default.into()));
    Ok(Places {
        bin: below(bin, "bin"),
        lib: below(lib, "lib"),
        include: below(include, "include"),
        man: below(man, "share/man"),
        destdir,
        built,
        strips,
        prefix,
    })
}

impl Places {
    /// Where a file is copied to that will be seen at `path`.
    pub(crate) fn put(&self, path: &Path) -> PathBuf {
        match &self.destdir {
            // Joining an absolute path would replace the destination.
            Some(destdir) => destdir.join(path.strip_prefix("/").unwrap_or(path)),
            None => path.to_path_buf(),
        }
    }

    /// Below the prefix's `share`.
    pub(crate) fn share(&self, path: &str) -> PathBuf {
        self.prefix.join("share").join(path)
    }

    /// Where CMake looks.
    pub(crate) fn cmake(&self) -> PathBuf {
        self.lib.join("cmake/OpenRT")
    }

    /// Fills in what a template leaves open.
    pub(crate) fn fill(&self, template: &str, version: &str) -> String {
        let of_prefix = |folder: &Path| match folder.strip_prefix(&self.prefix) {
            Ok(below) => format!("${{prefix}}/{}", below.display()),
            Err(_) => folder.display().to_string(),
        };
        let from_cmake = |folder: &Path| relative(&self.cmake(), folder).display().to_string();
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

    fn words(line: &str) -> Vec<String> {
        line.split_whitespace().map(String::from).collect()
    }

    #[test]
    fn arguments_are_read() {
        let places =
            parse(&words("--prefix /usr --destdir=/tmp/x --libdir lib/x86_64-linux-gnu --mandir=/m"));
        let places = places.expect("folders are given");
        assert_eq!(places.put(&places.bin), Path::new("/tmp/x/usr/bin"), "files go below the destination");
        assert_eq!(places.lib, Path::new("/usr/lib/x86_64-linux-gnu"), "below the prefix");
        assert_eq!(places.man, Path::new("/m"), "an absolute one stays");
        assert!(
            places.strips && !parse(&words("--prefix a --no-strip")).expect("no folder").strips,
            "symbols"
        );
        for bad in ["", "--prefix", "--prefix=", "--prefx /usr", "/usr", "--prefix / --libdir"] {
            let failure = parse(&words(bad)).expect_err("this is no way to call it");
            assert!(failure.contains("usage: cargo xtask install"), "'{bad}' explains itself: {failure}");
        }
    }

    #[test]
    fn templates_are_filled() {
        let places = parse(&words("--prefix /opt/rt --libdir lib/multi --includedir /inc")).expect("folders");
        let filled = places.fill("@prefix@ @libdir@ @includedir@ @version@ @libdir_from_here@", "1.2");
        assert_eq!(filled, "/opt/rt ${prefix}/lib/multi /inc 1.2 ../..", "each word");
    }
}
