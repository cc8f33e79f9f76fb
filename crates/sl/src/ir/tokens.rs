// SPDX-License-Identifier: GPL-3.0-or-later
//! Cuts a line of `.oso` into words.
//! The format is OSL's.

use crate::parse::unescape;

/// A word of a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum TextToken {
    /// A name, number or type.
    Plain(String),
    /// A text in quotes, escapes replaced.
    Text(String),
    /// `%name{...}` or `%name`; the contents of the braces unchanged.
    Hint(String, String),
}

/// The words of a line; text after `#` is dropped.
pub(super) fn line_tokens(line: &str) -> Vec<TextToken> {
    let mut out = Vec::new();
    let mut rest = line;
    loop {
        rest = rest.trim_start();
        let Some(first) = rest.chars().next() else { return out };
        match first {
            '#' => return out,
            '"' => {
                let end = quoted(rest);
                out.push(TextToken::Text(unescape(&rest[..end])));
                rest = &rest[end..];
            }
            '%' => {
                let end = rest[1..]
                    .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
                    .map_or(rest.len(), |p| p + 1);
                let name = rest[1..end].to_owned();
                rest = &rest[end..];
                let mut inner = String::new();
                if rest.starts_with('{') {
                    let close = braces(rest);
                    inner = rest[1..close].to_owned();
                    rest = rest.get(close + 1..).unwrap_or("");
                }
                out.push(TextToken::Hint(name, inner));
            }
            _ => {
                let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
                out.push(TextToken::Plain(rest[..end].to_owned()));
                rest = &rest[end..];
            }
        }
    }
}

/// Length of the text in quotes at the start.
fn quoted(text: &str) -> usize {
    let mut escaped = false;
    for (i, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return i + 1,
            _ => {}
        }
    }
    text.len()
}

/// Where the brace at the start is closed.
fn braces(text: &str) -> usize {
    let (mut escaped, mut in_text, mut depth) = (false, false, 0_usize);
    for (i, c) in text.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' if in_text => escaped = true,
            '"' => in_text = !in_text,
            '{' if !in_text => depth += 1,
            '}' if !in_text => {
                depth -= 1;
                if depth == 0 {
                    return i;
                }
            }
            _ => {}
        }
    }
    text.len()
}

/// Parts between commas outside of quotes.
pub(super) fn parts(text: &str) -> Vec<String> {
    let mut out = vec![String::new()];
    let (mut escaped, mut in_text) = (false, false);
    for c in text.chars() {
        match c {
            ',' if !in_text => {
                out.push(String::new());
                continue;
            }
            _ if escaped => escaped = false,
            '\\' if in_text => escaped = true,
            '"' => in_text = !in_text,
            _ => {}
        }
        if let Some(last) = out.last_mut() {
            last.push(c);
        }
    }
    out
}
