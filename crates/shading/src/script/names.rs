// SPDX-License-Identifier: GPL-3.0-or-later
//! Names of scripts that are not paths of files of the language: built-in shaders and nodes of MaterialX documents.
//! Tests: `tests`.

use std::path::Path;

/// The folder of built-in shaders.
const FOLDER: &str = "builtin";

/// How names of documents end.
const END: &str = ".mtlx";

/// The last part of a name `builtin/NAME`, in every folder, if there is no such file.
#[must_use]
pub fn built_in_name(path: &Path) -> Option<&str> {
    let is_named = path.parent().and_then(Path::file_name).is_some_and(|folder| folder == FOLDER);
    if !is_named || path.exists() {
        return None;
    }
    path.file_name()?.to_str()
}

/// The file of a MaterialX document's name, and the node after it: `FILE.mtlx` or `FILE.mtlx:NODE`.
#[must_use]
pub fn document_and_node(name: &str) -> Option<(&str, Option<&str>)> {
    if name.ends_with(END) {
        return Some((name, None));
    }
    let at = name.find(".mtlx:")? + END.len();
    let node = &name[at + 1..];
    (!node.is_empty()).then_some((&name[..at], Some(node)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_names_have_no_file() {
        for (path, expected) in [
            ("builtin/wood.osl", Some("wood.osl")),
            ("scenes/builtin/wood.osl", Some("wood.osl")),
            ("wood.osl", None),
            ("builtin/shaders/wood.osl", None),
            (concat!(env!("CARGO_MANIFEST_DIR"), "/src/script/names.rs"), None),
        ] {
            assert_eq!(built_in_name(path.as_ref()), expected, "{path}");
        }
        let folder = std::env::temp_dir().join(format!("gnurt-names-{}", std::process::id())).join(FOLDER);
        std::fs::create_dir_all(&folder).expect("a folder");
        let file = folder.join("wood.osl");
        assert_eq!(built_in_name(&file), Some("wood.osl"), "there is no file yet");
        std::fs::write(&file, "").expect("a file");
        assert_eq!(built_in_name(&file), None, "a file takes precedence");
        std::fs::remove_dir_all(folder.parent().expect("the folder above")).expect("it was made here");
    }

    #[test]
    fn nodes_follow_documents() {
        for (name, expected) in [
            ("a/b.mtlx", Some(("a/b.mtlx", None))),
            ("a/b.mtlx:ns:gold", Some(("a/b.mtlx", Some("ns:gold")))),
            ("b.mtlx:graph/out", Some(("b.mtlx", Some("graph/out")))),
            ("b.mtlx:", None),
            ("b.osl", None),
        ] {
            assert_eq!(document_and_node(name), expected, "{name}");
        }
    }
}
