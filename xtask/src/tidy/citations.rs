// SPDX-License-Identifier: GPL-3.0-or-later
//! Citations of file heads are in the bibliography.

use super::files::SourceFile;

/// The keys of a bibliography, with other keys (`ids`) of the same works.
pub(super) fn keys(bibliography: &str) -> Vec<String> {
    let mut keys = Vec::new();
    for line in bibliography.lines().filter(|line| line.starts_with('@')) {
        keys.extend(
            line.split_once('{').and_then(|(_, rest)| rest.split_once(',')).map(|(key, _)| key.trim()),
        );
        let ids = line.split_once("ids = {").and_then(|(_, rest)| rest.split_once('}'));
        keys.extend(ids.into_iter().flat_map(|(ids, _)| ids.split(',').map(str::trim)));
    }
    keys.into_iter().map(String::from).collect()
}

/// Complains about keys in the head of a crate's source file that the bibliography lacks.
pub(super) fn check(file: &SourceFile, keys: &[String]) -> Vec<(usize, String)> {
    if !file.is_rust() || !file.path.starts_with("crates/") || !file.path.contains("/src/") {
        return vec![];
    }
    let head = file.text.lines().enumerate().filter(|(_, line)| line.starts_with("//!"));
    let cited = head.flat_map(|(number, line)| cited(line).map(move |key| (number + 1, key)));
    let unknown = cited.filter(|(_, key)| !keys.iter().any(|known| known == key));
    unknown.map(|(line, key)| (line, format!("[{key}] is not in docs/papers.bib"))).collect()
}

/// `[Key]`: a capital, letters or a star, at least two digits, perhaps a letter; several may be separated by commas.
fn cited(line: &str) -> impl Iterator<Item = &str> {
    let brackets = line.split('[').skip(1).filter_map(|rest| rest.split_once(']')).map(|(within, _)| within);
    brackets.flat_map(|within| within.split(',').map(str::trim)).filter(|key| is_key(key))
}

fn is_key(token: &str) -> bool {
    let bare = token.strip_suffix(|c: char| c.is_ascii_lowercase()).unwrap_or(token);
    let name = bare.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = bare.len() - name.len();
    (2..=4).contains(&digits)
        && name.starts_with(|c: char| c.is_ascii_uppercase())
        && name.chars().all(|c| c.is_ascii_alphabetic() || c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    const BIBLIOGRAPHY: &str =
        "@article{WH06, title = {T}}\n@misc{SSM*05, ids = {Old05, WBS03a}, title = {T}}\n";

    #[test]
    fn keys_and_other_keys_are_read() {
        assert_eq!(keys(BIBLIOGRAPHY), ["WH06", "SSM*05", "Old05", "WBS03a"], "all keys");
    }

    #[test]
    fn unknown_keys_are_found() {
        let count = |head: &str| {
            let file = SourceFile::new("crates/accel/src/a.rs", &format!("// SPDX\n//! {head}\n"));
            check(&file, &keys(BIBLIOGRAPHY)).len()
        };
        assert_eq!(count("Source: [WH06], [SSM*05, WBS03a]."), 0, "all are known");
        assert_eq!(count("Source: [WH07], [WBS03b] section 2."), 2, "neither is known");
        assert_eq!(count("Values in [0, 1], a [`f32`], see [Vec3] and [x]."), 0, "these are no keys");
    }
}
