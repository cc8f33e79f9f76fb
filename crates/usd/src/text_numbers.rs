// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of text layers that begin or end with their point (`.5`, `-.5`, `2.`), with the zero that the library expects there.
//! Source: the text format's grammar, which has them. Tests: `tests`.

use crate::text_check::string_end;

/// The text with whole numbers; `None` = it has no such ones.
pub(crate) fn whole(text: &[u8]) -> Option<Vec<u8>> {
    let mut made: Option<Vec<u8>> = None;
    let (mut at, mut copied) = (0, 0);
    while at < text.len() {
        match text[at] {
            b'#' => at += text[at..].iter().position(|&byte| byte == b'\n').unwrap_or(text.len() - at),
            quote @ (b'"' | b'\'' | b'@') => at += string_end(&text[at..], quote).unwrap_or(text.len() - at),
            b'.' => {
                let begins = matches!(
                    before(text, at),
                    None | Some(
                        b'(' | b'[' | b',' | b'=' | b':' | b'-' | b'+' | b' ' | b'\t' | b'\n' | b'\r'
                    )
                );
                let ends = ends_a_number(text, at);
                let next_is_digit = text.get(at + 1).is_some_and(u8::is_ascii_digit);
                let place = if begins && next_is_digit { Some(at) } else { ends.then_some(at + 1) };
                if let Some(place) = place {
                    let made = made.get_or_insert_with(|| Vec::with_capacity(text.len() + text.len() / 16));
                    made.extend_from_slice(&text[copied..place]);
                    made.push(b'0');
                    copied = place;
                }
                at += 1;
            }
            _ => at += 1,
        }
    }
    made.map(|mut made| {
        made.extend_from_slice(&text[copied..]);
        made
    })
}

fn before(text: &[u8], at: usize) -> Option<u8> {
    at.checked_sub(1).map(|i| text[i])
}

/// Whether the point at `at` is the last of a number: behind digits that begin no word, and before none.
fn ends_a_number(text: &[u8], at: usize) -> bool {
    let digits = text[..at].iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
    let is_of_name = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.');
    digits > 0
        && !before(text, at - digits).is_some_and(is_of_name)
        && !text.get(at + 1).is_some_and(|&byte| is_of_name(byte) || byte == b':')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_get_zeros() {
        let text = "a = (.5, -.25, 2., -3.) # .5\n\"x .5 2.\" @./a.2.usd@ b = 1.5 c.d [.5e3] rel = </A.x> inputs:a.connect = 1.e2\n";
        let expected = "a = (0.5, -0.25, 2.0, -3.0) # .5\n\"x .5 2.\" @./a.2.usd@ b = 1.5 c.d [0.5e3] rel = </A.x> inputs:a.connect = 1.e2\n";
        let found = whole(text.as_bytes()).expect("numbers");
        assert_eq!(String::from_utf8_lossy(&found), expected);
        assert_eq!(whole(b"#usda 1.0\nfloat a = 0.5\n"), None);
    }

    #[test]
    fn the_library_reads_them() {
        let text = "#usda 1.0\ndef \"A\" { double3 a = (.5, -.25, 2.) }\n";
        let found = whole(text.as_bytes()).expect("numbers");
        assert!(openusd::usda::parse(std::str::from_utf8(&found).expect("text")).is_ok());
        // Once it reads them by itself, this file can go.
        assert!(openusd::usda::parse(text).is_err());
    }
}
