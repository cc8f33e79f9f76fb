// SPDX-License-Identifier: GPL-3.0-or-later
//! Rust text without its comments, strings and characters, for rules about code.
//! Invariant: line breaks stay where they are; everything else that is taken out becomes a space.

/// Blanks comments (nested ones too), strings (raw ones too) and character literals.
pub(super) fn code_only(text: &str) -> String {
    let mut rest = text;
    let mut code = String::with_capacity(text.len());
    while let Some(letter) = rest.chars().next() {
        let blank = blank_length(rest, code.chars().next_back());
        if blank == 0 {
            code.push(letter);
            rest = &rest[letter.len_utf8()..];
        } else {
            code.extend(rest[..blank].chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
            rest = &rest[blank..];
        }
    }
    code
}

/// Blanks all but line comments: the opposite of [`code_only`].
pub(super) fn comments_only(text: &str) -> String {
    let mut rest = text;
    let mut before = None;
    let mut comments = String::with_capacity(text.len());
    while let Some(letter) = rest.chars().next() {
        let blank = blank_length(rest, before);
        before = Some(if blank == 0 { letter } else { ' ' });
        let (part, after) = rest.split_at(blank.max(letter.len_utf8()));
        if part.starts_with("//") {
            comments.push_str(part);
        } else {
            comments.extend(part.chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        }
        rest = after;
    }
    comments
}

/// Blanks items that are only for tests (`#[cfg(test)]`), of code without comments and strings.
pub(super) fn without_tests(code: &str) -> String {
    const MARK: &str = "#[cfg(test)]";
    let mut rest = code;
    let mut retained = String::with_capacity(code.len());
    while let Some(at) = rest.find(MARK) {
        let end = at + item_length(&rest[at..]);
        retained.push_str(&rest[..at]);
        retained.extend(rest[at..end].chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        rest = &rest[end..];
    }
    retained + rest
}

/// Bytes of an item with its attributes: up to its semicolon, or to the end of its braces.
fn item_length(code: &str) -> usize {
    // Attributes and lists of arguments hold semicolons and braces of their own.
    let (mut depth, mut braces) = (0_usize, 0_usize);
    for (at, letter) in code.char_indices() {
        match letter {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.saturating_sub(1),
            '{' => braces += 1,
            '}' => {
                braces = braces.saturating_sub(1);
                if braces == 0 && depth == 0 {
                    // `use a::{b};` continues.
                    let after = code[at + 1..].trim_start();
                    return if after.starts_with(';') { code.len() - after.len() + 1 } else { at + 1 };
                }
            }
            ';' if depth == 0 && braces == 0 => return at + 1,
            _ => {}
        }
    }
    code.len()
}

/// Bytes at the beginning of the text that are no code; 0 if it begins with code.
fn blank_length(text: &str, before: Option<char>) -> usize {
    let within_word = before.is_some_and(|c| c.is_alphanumeric() || c == '_');
    if text.starts_with("//") {
        text.find('\n').unwrap_or(text.len())
    } else if text.starts_with("/*") {
        block_comment_length(text)
    } else if text.starts_with('"') {
        string_length(text, 1)
    } else if text.starts_with('\'') {
        character_length(text)
    } else if text.starts_with('r') && !within_word {
        raw_string_length(text)
    } else {
        0
    }
}

fn block_comment_length(text: &str) -> usize {
    let mut depth = 0_usize;
    let mut at = 0;
    while at < text.len() {
        if text[at..].starts_with("/*") {
            depth += 1;
            at += 2;
        } else if text[at..].starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += text[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    text.len()
}

fn string_length(text: &str, open: usize) -> usize {
    let mut escaped = false;
    for (at, letter) in text[open..].char_indices() {
        match letter {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return open + at + 1,
            _ => {}
        }
    }
    text.len()
}

/// `'x'` and `'\n'` are characters, `'a` is a lifetime.
fn character_length(text: &str) -> usize {
    let mut letters = text.char_indices().skip(1);
    match letters.next() {
        Some((_, '\\')) => text[2..].find(['\'', '\n']).map_or(0, |_| {
            // The escaped letter may itself be a quote.
            text.char_indices().skip(3).find(|(_, c)| *c == '\'').map_or(0, |(at, _)| at + 1)
        }),
        Some(_) => letters.next().filter(|(_, c)| *c == '\'').map_or(0, |(at, _)| at + 1),
        None => 0,
    }
}

fn raw_string_length(text: &str) -> usize {
    let hashes = text[1..].chars().take_while(|c| *c == '#').count();
    if !text[1 + hashes..].starts_with('"') {
        return 0;
    }
    let end = format!("\"{}", "#".repeat(hashes));
    text[2 + hashes..].find(&end).map_or(text.len(), |at| 2 + hashes + at + end.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_code_is_left() {
        let cases = [
            ("a // b\nc", "a     \nc"),
            ("a /* b /* c */ d */ e", "a                   e"),
            (r#"a("b \" c", d)"#, "a(        , d)"),
            ("a(r#\"b \" c\"#)", "a(          )"),
            ("'a, 'b', '\\'', '\\n' c", "'a,    ,     ,      c"),
            ("for x in r { var\"s\" }", "for x in r { var    }"),
        ];
        for (text, expected) in cases {
            assert_eq!(code_only(text), expected, "code of: {text}");
        }
    }

    #[test]
    fn tests_are_left_out() {
        let cases = [
            ("a\n#[cfg(test)]\nmod t { fn b() { c } }\nd", "a d"),
            ("#[cfg(test)] use a::{b}; c", "c"),
            ("#[cfg(test)] #[x(y)] fn f(a: [u8; 2]) { g } h", "h"),
            ("#[cfg(test)] mod t; a", "a"),
            ("#[cfg(any(test, unix))] mod t;", "#[cfg(any(test, unix))] mod t;"),
        ];
        for (code, expected) in cases {
            let left = without_tests(code);
            assert_eq!(
                left.split_whitespace().collect::<Vec<_>>().join(" "),
                expected,
                "without tests: {code}"
            );
            assert_eq!(left.lines().count(), code.lines().count(), "lines stay: {code}");
        }
    }
}
