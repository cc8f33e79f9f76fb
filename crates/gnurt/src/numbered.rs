// SPDX-License-Identifier: GPL-3.0-or-later
//! Files with numbers: `frame.####.png` means `frame.0001.png` and all the others.
//! Source: after the custom of film. The last run of `#` in a file's name is the number, with zeros before it up to the run's
//! length; larger numbers have more digits. Tests: `tests`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A name with a placeholder for a number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbered {
    path: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Numbered {
    /// The name, if its last part has a `#`.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        // Names that are no text have no placeholder.
        let name = path.file_name()?.to_str()?;
        let end = name.rfind('#')? + 1;
        let start = name[..end].trim_end_matches('#').len();
        let (before, after) = (name[..start].to_owned(), name[end..].to_owned());
        Some(Self { path: path.to_owned(), before, digits: end - start, after })
    }

    /// As it was given.
    #[must_use]
    pub fn pattern(&self) -> &Path {
        &self.path
    }

    /// The file of a number.
    #[must_use]
    pub fn at(&self, number: u32) -> PathBuf {
        let (before, after, digits) = (&self.before, &self.after, self.digits);
        self.path.with_file_name(format!("{before}{number:0digits$}{after}"))
    }

    /// The least number whose file is there.
    ///
    /// # Errors
    /// The system's error for the folder.
    pub fn first(&self) -> std::io::Result<Option<u32>> {
        Ok(self.numbers()?.first().copied())
    }

    /// The numbers whose files are there, in order.
    ///
    /// # Errors
    /// The system's error for the folder.
    pub fn numbers(&self) -> std::io::Result<Vec<u32>> {
        let folder = self.path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let mut numbers = Vec::new();
        for entry in std::fs::read_dir(folder.unwrap_or(Path::new(".")))? {
            numbers.extend(self.number_of(&entry?.file_name()));
        }
        numbers.sort_unstable();
        Ok(numbers)
    }

    /// The number of a name, if it is one of these.
    fn number_of(&self, name: &OsString) -> Option<u32> {
        let digits = name.to_str()?.strip_prefix(&self.before)?.strip_suffix(&self.after)?;
        let is_whole = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
        let number: u32 = digits.parse().ok().filter(|_| is_whole)?;
        (self.at(number).file_name()? == name.as_os_str()).then_some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_run_is_the_number() {
        let named = |text: &str| Numbered::of(Path::new(text));
        let at = |text: &str, number| named(text).expect("a place for a number").at(number);
        assert_eq!(at("a/b.####.png", 7), Path::new("a/b.0007.png"), "zeros before it");
        assert_eq!(at("b#.obj", 123), Path::new("b123.obj"), "as many digits as it takes");
        assert_eq!(at("#1/c##d###", 4), Path::new("#1/c##d004"), "the last run");
        assert_eq!((named("b.png"), named("a#/b.png"), named("")), (None, None, None), "no place");
    }

    #[test]
    fn finds_the_first_file() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let named = Numbered::of(&folder.path().join("m.###.ply")).expect("a place");
        assert_eq!(named.first().expect("a folder"), None, "no file yet");
        for name in ["m.012.ply", "m.007.ply", "m.7.ply", "m.0001.ply", "m.x.ply", "m..ply", "n.001.ply"] {
            std::fs::write(folder.path().join(name), b"").expect("a file");
        }
        assert_eq!(named.first().expect("a folder"), Some(7), "the least whose name is written so");
        assert_eq!(named.numbers().expect("a folder"), [7, 12], "all, in order");
        assert!(Numbered::of(Path::new("no/such/folder/#")).expect("a place").first().is_err(), "no folder");
    }
}
