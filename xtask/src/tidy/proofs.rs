// SPDX-License-Identifier: GPL-3.0-or-later
//! Tests that file heads name are there.

use super::files::SourceFile;

/// Complains about test files in the head of a Rust file that no folder has.
pub(super) fn check(files: &[SourceFile]) -> Vec<String> {
    let mut complaints = Vec::new();
    for file in files.iter().filter(|file| file.is_rust()) {
        for (number, line) in file.text.lines().enumerate().take_while(|(_, line)| line.starts_with("//")) {
            for name in line.split(|c: char| !(c.is_ascii_alphanumeric() || "_-./".contains(c))) {
                let is_test = name.starts_with("tests/") || name.contains("/tests/");
                let name = name.trim_end_matches('.');
                if is_test && name.ends_with(".rs") && !files.iter().any(|file| ends(&file.path, name)) {
                    complaints.push(format!("{}:{}: there is no {name}", file.path, number + 1));
                }
            }
        }
    }
    complaints
}

/// Whether the last folders and the name of a path are these.
fn ends(path: &str, name: &str) -> bool {
    path.strip_suffix(name).is_some_and(|rest| rest.is_empty() || rest.ends_with('/'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_nothing_are_found() {
        let head =
            "//! Proof: `tests/there.rs`, crates/a/tests/there.rs and `tests/gone.rs`.\n\n// tests/code.rs\n";
        let files =
            [SourceFile::new("crates/a/src/lib.rs", head), SourceFile::new("crates/a/tests/there.rs", "")];
        assert_eq!(check(&files), ["crates/a/src/lib.rs:1: there is no tests/gone.rs"]);
    }
}
