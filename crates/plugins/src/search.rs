// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a plugin's file is searched. A name with '/' is a path. Any other is searched in each folder of
//! `$OPENRT_SHADER_PATH` (separated by ':'), then by the system's loader (LD_LIBRARY_PATH, /etc/ld.so.conf),
//! then in the working directory. The first file that is there counts, even if it cannot be loaded: a broken
//! one hides no other.
//! Tests: `tests`; bindings/openrt/tests/plugins.rs.

use std::path::{Path, PathBuf};

/// The variable that lists folders.
pub(crate) const PATH_VARIABLE: &str = "OPENRT_SHADER_PATH";

/// Opens `file` at the first path that has it; or returns the searched paths and their faults. `open` gets a
/// path, or the bare name for the system's loader.
pub(crate) fn find<T>(
    file: &str,
    folders: &str,
    open: impl Fn(&Path) -> Result<T, String>,
) -> Result<T, String> {
    if file.contains('/') {
        return open(Path::new(file)).map_err(|why| format!("cannot load library \"{file}\": {why}"));
    }
    let mut tried = Vec::new();
    let mut at = |path: PathBuf| {
        if path.exists() {
            return Some(
                open(&path).map_err(|why| format!("cannot load library \"{}\": {why}", path.display())),
            );
        }
        tried.push(format!("no file {}", path.display()));
        None
    };
    for folder in folders.split(':').filter(|folder| !folder.is_empty()) {
        if let Some(outcome) = at(Path::new(folder).join(file)) {
            return outcome;
        }
    }
    let of_loader = match open(Path::new(file)) {
        Ok(opened) => return Ok(opened),
        Err(why) => format!("the system's loader: {why}"),
    };
    if let Some(outcome) = at(Path::new(".").join(file)) {
        return outcome;
    }
    let here = tried.pop().unwrap_or_default();
    tried.extend([of_loader, here]);
    let none = if folders.is_empty() { format!("; {PATH_VARIABLE} is not set") } else { String::new() };
    Err(format!("cannot find library \"{file}\": {}{none}", tried.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loader that finds nothing by bare names and "loads" every path that does not end in "broken.so".
    fn open(path: &Path) -> Result<String, String> {
        let text = path.display().to_string();
        if !text.contains('/') || text.ends_with("broken.so") { Err("no good".into()) } else { Ok(text) }
    }

    #[test]
    fn the_first_folder_counts() {
        let folder = tempfile::tempdir().expect("a folder");
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        for folder in [&a, &b] {
            std::fs::create_dir(folder).expect("it is new");
            std::fs::write(folder.join("x.so"), "").expect("it is ours");
        }
        std::fs::write(a.join("broken.so"), "").expect("it is ours");
        let folders = format!("/nowhere::{}:{}", a.display(), b.display());
        assert_eq!(find("x.so", &folders, open), Ok(a.join("x.so").display().to_string()), "the first one");
        assert_eq!(find("./x.so", &folders, open), Ok("./x.so".to_owned()), "a path is a path");
        let broken = find("broken.so", &folders, open).expect_err("it cannot be loaded");
        assert!(broken.contains("a/broken.so\": no good"), "the broken file is named: {broken}");
    }

    #[test]
    fn all_places_are_told() {
        let reported = find("none.so", "/nowhere", open).expect_err("there is none");
        for plugin_path in ["\"none.so\"", "/nowhere/none.so", "loader: no good", "./none.so"] {
            assert!(reported.contains(plugin_path), "'{plugin_path}' in {reported}");
        }
        let reported = find("none.so", "", open).expect_err("there is none");
        assert!(reported.contains("OPENRT_SHADER_PATH is not set"), "{reported}");
    }
}
