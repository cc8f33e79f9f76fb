// SPDX-License-Identifier: GPL-3.0-or-later
//! Sentences of pages and of comments in Rust: their length, relative clauses with `what` and `who`, words to avoid.
//!
//! CONTRIBUTING.md has the style sheet. `known_prose.rs` lists files with more than the rules allow; it only gets shorter.

use super::known_prose::KNOWN;
use super::pages::{Page, prose_lines};

/// A sentence of more words is read twice.
const MOST_WORDS: usize = 40;
/// `what` and `who` in a file: at most this many, and one more for each 400 words.
const FREE_CLAUSES: usize = 1;
const WORDS_A_CLAUSE: usize = 400;

/// Words and phrases that the style sheet replaces.
const AVOIDED: [&str; 14] = [
    "anew",
    "thereby",
    "likewise",
    "hang on",
    "hangs on",
    "stand in",
    "lie in",
    "by turns",
    "of its own accord",
    "for what it is worth",
    "nobody",
    "somebody",
    "whoever",
    "as many as",
];

/// Complaints about pages of docs/ and of the root, without records and the history, and about comments.
pub(super) fn check(pages: &[Page]) -> Vec<String> {
    let mut complaints = Vec::new();
    for page in pages.iter().filter(|page| is_checked(&page.path)) {
        let found = complaints_of(page);
        let known = KNOWN.iter().find(|(path, _)| *path == page.path).map_or(0, |(_, count)| *count);
        if found.len() > known {
            complaints.extend(found);
        } else if found.len() < known {
            complaints.push(format!(
                "xtask/src/tidy/known_prose.rs: {}: {} is enough now",
                page.path,
                found.len()
            ));
        }
    }
    let gone = KNOWN.iter().filter(|(path, _)| !pages.iter().any(|page| page.path == *path));
    complaints.extend(gone.map(|(path, _)| format!("xtask/src/tidy/known_prose.rs: {path} is not there")));
    complaints
}

fn is_checked(path: &str) -> bool {
    path.starts_with("docs/")
        || path.ends_with(".rs")
        || ["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md"].contains(&path)
}

fn complaints_of(page: &Page) -> Vec<String> {
    let mut complaints = Vec::new();
    let (mut words, mut clauses) = (0, Vec::new());
    for (line, sentence) in sentences(&page.text) {
        let count = sentence.split_whitespace().count();
        words += count;
        if count > MOST_WORDS {
            let begin: Vec<&str> = sentence.split_whitespace().take(8).collect();
            complaints.push(format!(
                "{}:{line}: a sentence of {count} words: '{} ...'",
                page.path,
                begin.join(" ")
            ));
        }
        let plain = format!(" {} ", words_only(&sentence));
        clauses.extend(std::iter::repeat_n(
            line,
            plain.matches(" what ").count() + plain.matches(" who ").count(),
        ));
        for avoided in AVOIDED.iter().filter(|avoided| plain.contains(&format!(" {avoided} "))) {
            complaints.push(format!("{}:{line}: avoid '{avoided}' (CONTRIBUTING.md, English)", page.path));
        }
    }
    let most = FREE_CLAUSES + words / WORDS_A_CLAUSE;
    let over = clauses.into_iter().skip(most);
    complaints.extend(over.map(|line| {
        format!("{}:{line}: 'what' or 'who' again, {most} in {words} words is enough: use a noun", page.path)
    }));
    complaints
}

/// The line on which each sentence begins, and its text; code in backticks counts as one word, links as their text.
fn sentences(text: &str) -> Vec<(usize, String)> {
    let mut sentences = Vec::new();
    let mut open: Option<(usize, String)> = None;
    let mut close =
        |open: &mut Option<(usize, String)>| sentences.extend(open.take().filter(|s| !s.1.trim().is_empty()));
    for (number, line) in prose_lines(text) {
        let trimmed = line.trim();
        let is_row = trimmed.starts_with('|');
        let begins = is_row
            || ["#", "* ", "- ", "> ", "<"].iter().any(|mark| trimmed.starts_with(mark))
            || is_numbered(trimmed);
        if trimmed.is_empty() || begins {
            close(&mut open);
        }
        if trimmed.starts_with('<') || trimmed.starts_with("|--") || trimmed.starts_with("|:") {
            continue;
        }
        let cells: Vec<&str> = if is_row { trimmed.split('|').collect() } else { vec![trimmed] };
        for cell in cells {
            for piece in pieces(&flattened(cell)) {
                let (_, text) = open.get_or_insert_with(|| (number, String::new()));
                text.push_str(&piece);
                text.push(' ');
                if piece.ends_with(['.', '!', '?']) {
                    close(&mut open);
                }
            }
            if is_row {
                close(&mut open);
            }
        }
        if trimmed.starts_with('#') {
            close(&mut open);
        }
    }
    close(&mut open);
    sentences
}

fn is_numbered(line: &str) -> bool {
    line.split_once(". ")
        .is_some_and(|(number, _)| !number.is_empty() && number.chars().all(|c| c.is_ascii_digit()))
}

/// The line cut after each full stop, question or exclamation mark that a blank or the line's end follows.
fn pieces(line: &str) -> Vec<String> {
    let mut pieces = vec![String::new()];
    for word in line.split_whitespace() {
        if let Some(piece) = pieces.last_mut() {
            piece.push_str(if piece.is_empty() { "" } else { " " });
            piece.push_str(word);
        }
        let ends = word.trim_end_matches([')', '"', '*', ']']);
        let is_short = ["e.g.", "i.e.", "etc.", "vs.", "cf."].contains(&ends);
        if ends.ends_with(['.', '!', '?']) && !is_short {
            pieces.push(String::new());
        }
    }
    pieces
        .into_iter()
        .filter(|piece| !piece.is_empty())
        .map(|piece| piece.trim_end_matches([')', '"', '*', ']']).into())
        .collect()
}

/// Without targets of links, marks of emphasis and list marks; code is one word.
fn flattened(line: &str) -> String {
    let mut text = String::new();
    for (i, part) in line.split('`').enumerate() {
        text.push_str(if i % 2 == 1 { "code" } else { part });
    }
    while let Some(at) = text.find("](") {
        let end = text[at..].find(')').map_or(text.len(), |end| at + end + 1);
        text.replace_range(at..end, "");
    }
    text.replace(['[', '*'], "").trim_start_matches(['#', '-', '>', ' ']).to_string()
}

fn words_only(sentence: &str) -> String {
    let words = sentence.split(|c: char| !c.is_alphanumeric() && c != '\'').filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(text: &str) -> usize {
        complaints_of(&Page { path: "docs/a.md".into(), text: text.into() }).len()
    }

    #[test]
    fn long_sentences_are_found() {
        let words = |n: usize| vec!["word"; n].join(" ");
        assert_eq!(count(&format!("{}.\n{}.", words(40), words(40))), 0, "two of forty words");
        assert_eq!(count(&format!("{}\n{}.", words(20), words(21))), 1, "one of 41 words on two lines");
        assert_eq!(count(&format!("* {}\n* {}", words(30), words(30))), 0, "items of a list end sentences");
        assert_eq!(count(&format!("| {} | {} |", words(30), words(30))), 0, "cells end sentences");
        assert_eq!(count(&format!("{} `{}` ends.", words(30), words(30))), 0, "code is one word");
        assert_eq!(count(&format!("```\n{}\n```", words(50))), 0, "code blocks are no sentences");
    }

    #[test]
    fn clauses_and_avoided_words_are_found() {
        assert_eq!(count("It says what it does."), 0, "one is allowed");
        assert_eq!(count("It says what it does. It knows who asks and what for."), 2, "two more");
        assert_eq!(count("Rays are traced anew. Nobody waits."), 2, "two words to avoid");
        assert_eq!(count("Use `anew`."), 0, "code is free");
    }

    #[test]
    fn sentences_begin_on_their_line() {
        let found = sentences("# Head\n\nOne two. Three\nfour five.\n");
        let expected = [(1, "Head "), (3, "One two. "), (3, "Three four five. ")];
        assert_eq!(found, expected.map(|(line, text)| (line, text.to_string())), "three sentences");
    }
}
