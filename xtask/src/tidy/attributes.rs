// SPDX-License-Identifier: GPL-3.0-or-later
//! Exceptions to lints state a reason.

use super::files::SourceFile;

/// No `#[allow(..)]` or `#[expect(..)]` without a reason.
pub(super) fn check(file: &SourceFile) -> Vec<(usize, String)> {
    let mut complaints = Vec::new();
    for opening in ["[allow(", "[expect("] {
        for (at, _) in file.code.match_indices(opening) {
            // The reason's text is blanked, its name is not.
            let attribute = &file.code[at..];
            let end = attribute.find(")]").unwrap_or(attribute.len());
            if !attribute[..end].contains("reason =") {
                let line = file.code[..at].matches('\n').count() + 1;
                complaints.push((line, format!("'#{opening}' without a reason = \"..\"")));
            }
        }
    }
    complaints
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exceptions_need_reasons() {
        let lines = |text: &str| {
            check(&SourceFile::new("a.rs", text)).iter().map(|(line, _)| *line).collect::<Vec<_>>()
        };
        assert_eq!(lines("fn a() {}\n#[allow(dead_code)]\nfn b() {}"), [2], "no reason");
        assert_eq!(lines("#![expect(dead_code)]"), [1], "no reason either");
        assert_eq!(lines("#[expect(\n    dead_code,\n    reason = \"C calls it\"\n)]"), [0; 0], "a reason");
    }
}
