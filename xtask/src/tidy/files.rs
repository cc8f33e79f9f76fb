// SPDX-License-Identifier: GPL-3.0-or-later
//! Our own files: all below the root except build products and generated files.

use std::path::Path;

use super::pages::Page;
use super::rust_code::code_only;
use crate::failure::Failure;

const SKIPPED_FOLDERS: [&str; 4] = ["target", ".git", "generated", "shared"];
const EXTENSIONS: [&str; 5] = ["rs", "toml", "c", "h", "sh"];
/// Scripts without an ending.
const SCRIPTS: [&str; 1] = [".ci/run"];

/// A file, with its path from the root with forward slashes.
pub(super) struct SourceFile {
    pub(super) path: String,
    pub(super) text: String,
    /// The text without comments, strings and characters, line for line; empty unless it is Rust.
    pub(super) code: String,
}

impl SourceFile {
    pub(super) fn new(path: &str, text: &str) -> Self {
        let code = if path.ends_with(".rs") { code_only(text) } else { String::new() };
        Self { path: path.into(), text: text.into(), code }
    }

    pub(super) fn is_rust(&self) -> bool {
        self.path.ends_with(".rs")
    }

    /// Line numbers from 1 and identifiers of the code.
    pub(super) fn identifiers(&self) -> impl Iterator<Item = (usize, &str)> {
        let in_line = |line: &'_ str| -> Vec<(usize, usize)> {
            let mut found = Vec::new();
            let mut start = None;
            for (at, letter) in line.char_indices().chain([(line.len(), ' ')]) {
                match (letter.is_alphanumeric() || letter == '_', start) {
                    (true, None) => start = Some(at),
                    (false, Some(from)) => {
                        found.push((from, at));
                        start = None;
                    }
                    _ => {}
                }
            }
            found
        };
        self.code.lines().enumerate().flat_map(move |(number, line)| {
            in_line(line).into_iter().map(move |(from, to)| (number + 1, &line[from..to]))
        })
    }
}

/// All files that rules are for, in the order of their paths.
pub(super) fn all(root: &Path) -> Result<Vec<SourceFile>, Failure> {
    let is_source = |path: &str, extension: &str| EXTENSIONS.contains(&extension) || SCRIPTS.contains(&path);
    let texts = sorted_texts(root, &is_source)?;
    Ok(texts.iter().map(|(path, text)| SourceFile::new(path, text)).collect())
}

/// All Markdown pages, in the order of their paths.
pub(super) fn pages(root: &Path) -> Result<Vec<Page>, Failure> {
    let texts = sorted_texts(root, &|_, extension| extension == "md")?;
    Ok(texts.into_iter().map(|(path, text)| Page { path, text }).collect())
}

/// Paths from the root and texts of the files that `takes` accepts by path and extension.
fn sorted_texts(root: &Path, takes: &dyn Fn(&str, &str) -> bool) -> Result<Vec<(String, String)>, Failure> {
    let mut texts = Vec::new();
    collect(root, root, takes, &mut texts)?;
    texts.sort();
    Ok(texts)
}

fn collect(
    root: &Path,
    folder: &Path,
    takes: &dyn Fn(&str, &str) -> bool,
    texts: &mut Vec<(String, String)>,
) -> Result<(), Failure> {
    let failed = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    for entry in std::fs::read_dir(folder).map_err(|error| failed(folder, error))? {
        let path = entry.map_err(|error| failed(folder, error))?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let from_root = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        if path.is_dir() {
            // A link leads to files that are checked where they are.
            if !SKIPPED_FOLDERS.contains(&name) && !path.is_symlink() {
                collect(root, &path, takes, texts)?;
            }
        } else if takes(&from_root, extension) {
            let text = std::fs::read_to_string(&path).map_err(|error| failed(&path, error))?;
            texts.push((from_root, text));
        }
    }
    Ok(())
}
