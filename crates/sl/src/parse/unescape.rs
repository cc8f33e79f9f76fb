// SPDX-License-Identifier: GPL-3.0-or-later
//! Unescapes strings. The escapes are C's.

/// The text between quotes, escapes replaced. Takes it with or without the quotes.
#[must_use]
pub(crate) fn unescape(text: &str) -> String {
    let inner = text.strip_prefix('"').and_then(|t| t.strip_suffix('"')).unwrap_or(text);
    let mut out = String::with_capacity(inner.len());
    let mut rest = inner.chars().peekable();
    while let Some(c) = rest.next() {
        if c != '\\' {
            out.push(c);
            continue;
        }
        match rest.next() {
            Some('n') => out.push('\n'),
            // A line's end that a backslash hides.
            Some('\n') => {}
            Some('\r') if rest.peek() == Some(&'\n') => drop(rest.next()),
            Some('t') => out.push('\t'),
            Some('r') => out.push('\r'),
            Some('a') => out.push('\x07'),
            Some('b') => out.push('\x08'),
            Some('v') => out.push('\x0b'),
            Some('f') => out.push('\x0c'),
            Some(digit @ '0'..='7') => {
                let mut value = digit as u32 - '0' as u32;
                for _ in 0..2 {
                    if let Some(d) = rest.peek().and_then(|c| c.to_digit(8)) {
                        value = value * 8 + d;
                        rest.next();
                    }
                }
                out.push(char::from((value & 0xff) as u8));
            }
            Some(other) => out.push(other),
            None => out.push('\\'),
        }
    }
    out
}
