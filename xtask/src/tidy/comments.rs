// SPDX-License-Identifier: GPL-3.0-or-later
//! The comments of a Rust file as a Markdown page, so that the rules of prose hold for them as for pages.
//! Invariant: a comment is on the same line of the page as of the file.

use super::files::SourceFile;
use super::pages::Page;
use super::rust_code::comments_only;

/// Words before a colon that begin a fact of their own.
const LABELS: [&str; 6] = ["Source:", "Space:", "Invariant:", "Tests:", "SAFETY:", "Differs:"];

/// A page of the file's line comments; other lines are empty.
pub(super) fn page(file: &SourceFile) -> Page {
    let comments = comments_only(&file.text);
    let mut text = String::with_capacity(comments.len());
    let mut marker_before = None;
    for (comment, line) in comments.lines().zip(file.text.lines()) {
        let (marker, words) = split(comment.trim());
        // After code, a comment is a separate block.
        let is_alone = line.trim_start().starts_with("//");
        if marker.is_some() && !words.starts_with("SPDX-") {
            let begins = !is_alone || marker != marker_before;
            let is_marked = ["#", "|", "```"].iter().any(|mark| words.starts_with(mark));
            if (begins && !is_marked) || LABELS.iter().any(|label| words.starts_with(label)) {
                text.push_str("* ");
            }
            text.push_str(words);
        }
        text.push('\n');
        marker_before = marker.filter(|_| is_alone);
    }
    Page { path: file.path.clone(), text }
}

/// The marker of a comment (`//!`, `///` or `//`) and its text.
fn split(comment: &str) -> (Option<&str>, &str) {
    let marker = ["//!", "///", "//"].into_iter().find(|marker| comment.starts_with(marker));
    (marker, marker.map_or("", |marker| comment[marker.len()..].trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_become_a_page() {
        let text = "// SPDX-FileType: SOURCE\n//! Head.\n//! Tests: `a.rs`.\n\n/// # Errors\n/// One\n\
                    /// two.\nfn f() { // three\n    // four\n    // five\n    let a = \"// no\"; }\n";
        let expected = "\n* Head.\n* Tests: `a.rs`.\n\n# Errors\nOne\ntwo.\n* three\n* four\nfive\n\n";
        assert_eq!(page(&SourceFile::new("a.rs", text)).text, expected, "the comments, line for line");
    }
}
