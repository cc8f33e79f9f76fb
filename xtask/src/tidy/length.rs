// SPDX-License-Identifier: GPL-3.0-or-later
//! Files stay short enough to be read at once.

use super::files::SourceFile;

const MAX_LINES: usize = 900;

/// No file has more than 900 lines.
pub(super) fn check(file: &SourceFile) -> Vec<(usize, String)> {
    let lines = file.text.lines().count();
    if lines <= MAX_LINES {
        return vec![];
    }
    vec![(lines, format!("{lines} lines, more than {MAX_LINES}: give each concept a file"))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_files_are_found() {
        assert!(check(&SourceFile::new("a.rs", &"\n".repeat(900))).is_empty(), "900 lines are allowed");
        assert_eq!(check(&SourceFile::new("a.rs", &"\n".repeat(901))).len(), 1, "901 are not");
    }
}
