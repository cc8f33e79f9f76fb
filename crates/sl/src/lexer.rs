// SPDX-License-Identifier: GPL-3.0-or-later
//! Cuts a file's text into tokens. Comments are white space; a backslash at a line's end joins it with the next.
//! The syntax of numbers is OSL's.
//!
//! Invariant: every call either advances or returns [`Tok::End`].

use crate::source::Loc;
use crate::token::{SIGNS, Tok, Token};
use std::sync::Arc;

/// A position in a text that is being read.
#[derive(Clone, Debug)]
pub struct Lexer {
    text: Arc<str>,
    at: usize,
    /// The file's number.
    pub file: u16,
    /// The line, as `#line` counts.
    pub line: u32,
    first: bool,
    /// White space that was skipped in the search for the line's end.
    spaced: bool,
}

impl Lexer {
    /// At the start of a text.
    #[must_use]
    pub fn new(text: Arc<str>, file: u16) -> Self {
        Self { text, at: 0, file, line: 1, first: true, spaced: false }
    }

    fn byte(&self, ahead: usize) -> u8 {
        self.text.as_bytes().get(self.at + ahead).copied().unwrap_or(0)
    }

    /// Length of a line end that a backslash hides, at `at`.
    fn splice(&self, at: usize) -> usize {
        match &self.text.as_bytes()[at.min(self.text.len())..] {
            [b'\\', b'\n', ..] => 2,
            [b'\\', b'\r', b'\n', ..] => 3,
            _ => 0,
        }
    }

    /// Skips white space and comments; returns whether there was any. Stops before a line end if `stay`.
    fn skip_space(&mut self, stay: bool) -> bool {
        let start = self.at;
        while self.at < self.text.len() {
            let splice = self.splice(self.at);
            if splice > 0 {
                self.at += splice;
                self.line += 1;
                continue;
            }
            match (self.byte(0), self.byte(1)) {
                (b'\n', _) if stay => break,
                (b'\n', _) => {
                    self.at += 1;
                    self.line += 1;
                    self.first = true;
                }
                (b' ' | b'\t' | b'\r' | 0x0b | 0x0c, _) => self.at += 1,
                (b'/', b'/') => {
                    while self.at < self.text.len() && self.byte(0) != b'\n' {
                        let splice = self.splice(self.at);
                        self.line += u32::from(splice > 0);
                        self.at += splice.max(1);
                    }
                }
                (b'/', b'*') => {
                    let end = self.text.as_bytes()[self.at + 2..].windows(2).position(|w| w == b"*/");
                    let end = end.map_or(self.text.len(), |p| self.at + 2 + p + 2);
                    self.line +=
                        self.text.as_bytes()[self.at..end].iter().filter(|&&b| b == b'\n').count() as u32;
                    self.at = end;
                }
                _ => break,
            }
        }
        self.at > start
    }

    /// Whether the rest of this line is empty.
    pub fn at_line_end(&mut self) -> bool {
        self.spaced |= self.skip_space(true);
        self.at >= self.text.len() || self.byte(0) == b'\n'
    }

    /// The rest of the line, comments left out.
    pub fn rest_of_line(&mut self) -> String {
        let mut out = String::new();
        while !self.at_line_end() {
            let token = self.next_token();
            if token.space && !out.is_empty() {
                out.push(' ');
            }
            out.push_str(&token.spelling());
        }
        out
    }

    /// The next token.
    pub fn next_token(&mut self) -> Token {
        let space = self.skip_space(false) | std::mem::take(&mut self.spaced);
        let first = std::mem::replace(&mut self.first, false);
        let start = self.at;
        let line = self.line;
        let tok = self.scan();
        let loc =
            Loc { file: self.file, start: start as u32, len: (self.at - start).min(0xffff) as u16, line };
        Token { tok, loc, space, first }
    }

    fn scan(&mut self) -> Tok {
        let Some(c) = self.text.get(self.at..).and_then(|rest| rest.chars().next()) else { return Tok::End };
        if c.is_ascii_alphabetic() || c == '_' {
            return Tok::Ident(self.take_while(|b| b.is_ascii_alphanumeric() || b == b'_'));
        }
        if c.is_ascii_digit() || (c == '.' && self.byte(1).is_ascii_digit()) {
            return self.number();
        }
        if c == '"' {
            return self.string();
        }
        if let Some(sign) = SIGNS.iter().find(|sign| self.text[self.at..].starts_with(**sign)) {
            self.at += sign.len();
            return Tok::Sign(sign);
        }
        self.at += c.len_utf8();
        Tok::Other(c)
    }

    fn take_while(&mut self, keep: impl Fn(u8) -> bool) -> Arc<str> {
        let start = self.at;
        while self.at < self.text.len() && keep(self.byte(0)) {
            self.at += 1;
        }
        self.text[start..self.at].into()
    }

    fn number(&mut self) -> Tok {
        let start = self.at;
        if self.byte(0) == b'0' && matches!(self.byte(1), b'x' | b'X') && self.byte(2).is_ascii_hexdigit() {
            self.at += 2;
            self.take_while(|b| b.is_ascii_hexdigit());
            return Tok::Int(self.text[start..self.at].into());
        }
        let mut float = false;
        self.take_while(|b| b.is_ascii_digit());
        if self.byte(0) == b'.' {
            float = true;
            self.at += 1;
            self.take_while(|b| b.is_ascii_digit());
        }
        let sign = usize::from(matches!(self.byte(1), b'+' | b'-'));
        if matches!(self.byte(0), b'e' | b'E') && self.byte(1 + sign).is_ascii_digit() {
            float = true;
            self.at += 1 + sign;
            self.take_while(|b| b.is_ascii_digit());
        }
        let text = self.text[start..self.at].into();
        if float { Tok::Float(text) } else { Tok::Int(text) }
    }

    fn string(&mut self) -> Tok {
        let start = self.at;
        let mut at = self.at + 1;
        loop {
            match self.text.as_bytes().get(at) {
                Some(b'"') => break,
                Some(b'\\') if self.splice(at) > 0 => {
                    at += self.splice(at);
                    self.line += 1;
                }
                Some(b'\\') if self.text.as_bytes().get(at + 1).is_some() => at += 2,
                // The rest of the line belongs to it: another quote there would search for its end as far
                // again.
                Some(b'\n') | None => {
                    self.at = at;
                    return Tok::Other('"');
                }
                Some(_) => at += 1,
            }
        }
        self.at = at + 1;
        // A backslash may have hidden the first byte of a longer character; the end is a quote, so the cut is at a character.
        Tok::Str(self.text.get(start..self.at).unwrap_or("\"\"").into())
    }
}

/// All tokens of a text that has no file, as macros given on the command line.
#[must_use]
pub fn tokens_of(text: &str) -> Vec<Token> {
    let mut lexer = Lexer::new(text.into(), u16::MAX);
    let mut out = Vec::new();
    loop {
        let token = lexer.next_token();
        if token.tok == Tok::End {
            return out;
        }
        out.push(token);
    }
}
