// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes from text.

use std::path::Path;

use gnurt_scene::io::{Error, Formats, LoadOptions, Loaded};
use tempfile::TempDir;

const FORMATS: Formats = Formats::new(&[&gnurt_pbrt::FORMAT]);

/// What is read of a text, beside these files.
pub(crate) fn read_with_files(text: &str, files: &[(&str, &[u8])]) -> (Result<Loaded, Error>, TempDir) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).expect("a file");
    }
    let path = folder.path().join("t.pbrt");
    std::fs::write(&path, text).expect("a file");
    (FORMATS.load(&path, &LoadOptions::default()), folder)
}

/// The same of a file.
pub(crate) fn load(path: &Path) -> Result<Loaded, Error> {
    FORMATS.load(path, &LoadOptions::default())
}

/// A scene of these statements behind `WorldBegin`, without warnings but these.
pub(crate) fn world_warned(text: &str, expected: &[&str]) -> Loaded {
    let (loaded, _folder) = read_with_files(&format!("WorldBegin\n{text}"), &[]);
    let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    let found: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    let all = found.iter().all(|line| expected.iter().any(|part| line.contains(part)));
    assert!(all && found.len() == expected.len(), "{found:#?} instead of {expected:#?}");
    loaded
}

/// The same without warnings.
pub(crate) fn world(text: &str) -> Loaded {
    world_warned(text, &[])
}
