// SPDX-License-Identifier: GPL-3.0-or-later
//! MaterialX documents as scripts: `FILE.mtlx`, or `FILE.mtlx:NODE` for one of several materials, nodes or outputs of graphs.
//! Tests: `tests/scripts/mtlx.rs`.

use std::path::{Path, PathBuf};

use gnurt_shading::script::document_and_node;

use crate::access::Access;

/// A document's shader.
pub(crate) struct Written {
    pub(crate) text: String,
    /// All files of the document.
    pub(crate) files: Vec<PathBuf>,
    /// The texts that were read.
    pub(crate) texts: Vec<(PathBuf, String)>,
    pub(crate) warnings: Vec<String>,
}

#[cfg(feature = "materialx")]
mod reading {
    use gnurt_materialx::Document;

    use super::{Access, Path, PathBuf, Written};

    /// The document of a file, or of its text; what it includes is searched as `#include` is.
    fn document(
        file: &Path,
        text: Option<&str>,
        access: &Access,
    ) -> Result<(Document, Vec<(PathBuf, String)>), String> {
        let mut texts: Vec<(PathBuf, String)> =
            text.iter().map(|text| (file.to_owned(), (*text).to_owned())).collect();
        let mut load = |path: &Path| {
            let folders = access.includes.iter().map(Path::new);
            let others = path.file_name().map(|name| folders.map(move |folder| folder.join(name)));
            let first = access.text(path);
            let found = match &first {
                Ok(text) => Some((path.to_owned(), text.clone())),
                Err(_) => others
                    .into_iter()
                    .flatten()
                    .find_map(|path| Some((path.clone(), access.text(&path).ok()?))),
            };
            texts.extend(found.clone());
            found.map_or(first, |(_, text)| Ok(text))
        };
        let read = match text {
            Some(text) => Document::of_text(file, text, &mut load),
            None => Document::open(file, &mut load),
        };
        Ok((read.map_err(|error| error.to_string())?, texts))
    }

    /// The text of a document's node.
    pub(crate) fn written(
        file: &Path,
        node: Option<&str>,
        text: Option<&str>,
        access: &Access,
    ) -> Result<Written, String> {
        let (document, texts) = document(file, text, access)?;
        let made = document.shader(node).map_err(|error| error.to_string())?;
        let files = document.paths().map(Path::to_owned).collect();
        Ok(Written { text: made.text, files, texts, warnings: made.warnings })
    }

    /// The names of a document's materials.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn materials(file: &Path, access: &Access) -> Result<Vec<String>, String> {
        Ok(document(file, None, access)?.0.materials())
    }
}

#[cfg(not(feature = "materialx"))]
mod reading {
    use super::{Access, Path, Written};

    fn none(file: &Path) -> String {
        format!(
            "{}: this program was compiled without MaterialX; `cargo run --release --features materialx -- ...` compiles \
             it; `cargo build --release` and `cargo xtask install` have all formats",
            file.display()
        )
    }

    pub(crate) fn written(
        file: &Path,
        _: Option<&str>,
        _: Option<&str>,
        _: &Access,
    ) -> Result<Written, String> {
        Err(none(file))
    }

    /// The names of a document's materials.
    ///
    /// # Errors
    /// This build reads none.
    pub fn materials(file: &Path, _: &Access) -> Result<Vec<String>, String> {
        Err(none(file))
    }
}

pub use reading::materials;
pub(crate) use reading::written;

/// The shaders of a scene's materials, of which those called `material` are meant, or all (`*`): pairs of the name of some
/// materials and of their shader. A document with several materials gives each the one of its name, and the others keep
/// theirs; anything else is one shader for `material`. Pairs are in the order of their first materials.
///
/// # Errors
/// The document cannot be read.
pub fn shaders_by_material<'a>(
    shader: &str,
    material: &str,
    names: impl Iterator<Item = &'a str>,
    access: &Access,
) -> Result<Vec<(String, String)>, String> {
    let several = match document_and_node(shader) {
        Some((file, None)) => materials(Path::new(file), access)?,
        _ => Vec::new(),
    };
    let mut found: Vec<(String, String)> = Vec::new();
    if several.len() > 1 {
        for name in names.filter(|name| material == "*" || material == *name) {
            if several.iter().any(|other| other == name) && found.iter().all(|(other, _)| other != name) {
                found.push((name.to_owned(), format!("{shader}:{name}")));
            }
        }
    }
    if found.is_empty() {
        // A document that has none of the names says which it has.
        found.push((material.to_owned(), shader.to_owned()));
    }
    Ok(found)
}
