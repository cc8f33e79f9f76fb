// SPDX-License-Identifier: GPL-3.0-or-later
//! Files of tests, and the scenes loaded from them.

use std::path::PathBuf;

use gnurt_scene::io::{Error, Formats, LoadOptions, Loaded, Oddity};
use tempfile::TempDir;

/// The table with this crate's format alone.
pub(crate) const FORMATS: Formats = Formats::new(&[&gnurt_usd::FORMAT]);

/// A folder with files.
pub(crate) struct Folder(TempDir);

impl Folder {
    /// Files by name and text.
    pub(crate) fn with(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        for (name, text) in files {
            std::fs::write(folder.path(name), text).expect("a file");
        }
        folder
    }

    /// A file in it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Loads a file of it.
    pub(crate) fn load(&self, name: &str, options: &LoadOptions) -> Result<Loaded, Error> {
        FORMATS.load(self.path(name), options)
    }
}

/// Loads a text layer in metres with y up.
pub(crate) fn load(body: &str) -> Loaded {
    load_at(body, None)
}

/// Loads a text layer as [`load`] does, at a moment in seconds.
pub(crate) fn load_at(body: &str, at: Option<f64>) -> Loaded {
    let text = format!("#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n{body}");
    let folder = Folder::with(&[("scene.usda", &text)]);
    let options = LoadOptions { at, ..LoadOptions::default() };
    folder.load("scene.usda", &options).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// All warnings but that there is nothing to see, one a line.
pub(crate) fn warnings(loaded: &Loaded) -> String {
    let reported = loaded.warnings.iter().filter(|warning| warning.oddity != Oddity::EmptyScene);
    reported.map(|warning| format!("{warning}\n")).collect()
}
