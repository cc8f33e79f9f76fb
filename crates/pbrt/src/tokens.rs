// SPDX-License-Identifier: GPL-3.0-or-later
//! Tokens: words, texts in quotation marks, and brackets. `#` begins a comment.
//! Source: the section Tokens and the examples of the file-format page. Tests: `tests`.

use gnurt_scene::io::Error;
use gnurt_scene::io::reader::quoted;

use crate::location::Location;
use crate::sources::Source;

/// A token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Token {
    /// A statement's name or a number: its bytes in the file.
    Word(std::ops::Range<usize>),
    /// A text in quotation marks, without them.
    Text(String),
    /// `[`.
    Open,
    /// `]`.
    Close,
}

impl Source {
    /// Where the next token is.
    pub(crate) fn location(&self) -> Location {
        Location { path: self.path.clone(), line: self.line }
    }

    /// The characters of a word.
    pub(crate) fn word(&self, range: &std::ops::Range<usize>) -> &str {
        std::str::from_utf8(&self.bytes[range.clone()]).unwrap_or("\u{fffd}")
    }

    /// Goes to the next token.
    fn skip(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' => self.line += 1,
                b'#' => {
                    while self.bytes.get(self.at).is_some_and(|&byte| byte != b'\n') {
                        self.at += 1;
                    }
                    continue;
                }
                byte if byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.at += 1;
        }
    }

    /// The first byte of the next token.
    pub(crate) fn peek(&mut self) -> Option<u8> {
        self.skip();
        self.bytes.get(self.at).copied()
    }

    /// The next token; `None` at the end of the file.
    pub(crate) fn next(&mut self) -> Result<Option<Token>, Error> {
        let Some(first) = self.peek() else { return Ok(None) };
        match first {
            b'[' => self.at += 1,
            b']' => self.at += 1,
            b'"' => return self.text().map(Some),
            _ => {
                let start = self.at;
                let ends = |byte: u8| byte.is_ascii_whitespace() || matches!(byte, b'"' | b'[' | b']' | b'#');
                while self.bytes.get(self.at).is_some_and(|&byte| !ends(byte)) {
                    self.at += 1;
                }
                return Ok(Some(Token::Word(start..self.at)));
            }
        }
        Ok(Some(if first == b'[' { Token::Open } else { Token::Close }))
    }

    /// A text; the next byte is its quotation mark.
    fn text(&mut self) -> Result<Token, Error> {
        let location = self.location();
        let mut text = Vec::new();
        self.at += 1;
        loop {
            let byte = self.bytes.get(self.at).copied();
            self.at += 1;
            match byte {
                Some(b'"') => return Ok(Token::Text(String::from_utf8_lossy(&text).into_owned())),
                Some(b'\\') => {
                    let escaped = self.bytes.get(self.at).copied().unwrap_or(b'\\');
                    self.at += 1;
                    text.push(match escaped {
                        b'n' => b'\n',
                        b't' => b'\t',
                        b'r' => b'\r',
                        b'b' => 8,
                        b'f' => 12,
                        other => other,
                    });
                }
                Some(b'\n') | None => {
                    let begin = String::from_utf8_lossy(&text);
                    let problem = format!("text {} has no end on its line", quoted(&begin));
                    return Err(location.error(problem, "end it with \""));
                }
                Some(other) => text.push(other),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> Source {
        let path: std::sync::Arc<std::path::Path> = std::path::Path::new("t.pbrt").into();
        Source { path, bytes: text.as_bytes().to_vec(), at: 0, line: 1, import: None }
    }

    #[test]
    fn tokens_of_all_kinds() {
        let mut source = source("LookAt 1 -2.5e3#c\n\"float a\\\"b\"[1]\n  x");
        let mut found = Vec::new();
        while let Some(token) = source.next().expect("good tokens") {
            found.push(match token {
                Token::Word(range) => source.word(&range).to_owned(),
                Token::Text(text) => format!("<{text}>"),
                Token::Open => "[".into(),
                Token::Close => "]".into(),
            });
        }
        assert_eq!(found, ["LookAt", "1", "-2.5e3", "<float a\"b>", "[", "1", "]", "x"]);
        assert_eq!(source.line, 3);
    }

    #[test]
    fn texts_end_on_their_line() {
        let error = source("\n\"abc\n\"").next().expect_err("no end").to_string();
        assert!(error.starts_with("t.pbrt:2: text `abc` has no end"), "{error}");
    }
}
