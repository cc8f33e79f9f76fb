// SPDX-License-Identifier: GPL-3.0-or-later
//! The words of the language.
//! The syntax of numbers is OSL's.

use crate::source::Loc;
use std::sync::Arc;

/// The kind of a token.
#[derive(Clone, Debug, PartialEq)]
pub enum Tok {
    /// A name or keyword.
    Ident(Arc<str>),
    /// Digits, or hexadecimal digits after `0x`.
    Int(Arc<str>),
    /// A number with a point or an exponent.
    Float(Arc<str>),
    /// A string as written, quotes and escapes in it.
    Str(Arc<str>),
    /// An operator or another sign.
    Sign(&'static str),
    /// A character that means nothing.
    Other(char),
    /// The rest of a line after `#pragma`.
    Pragma(Arc<str>),
    /// End of the text.
    End,
}

/// A token and its position.
#[derive(Clone, Debug)]
pub struct Token {
    /// Its kind.
    pub tok: Tok,
    /// Where it is; inside a macro's text, where the macro is used.
    pub loc: Loc,
    /// Whether white space comes before it.
    pub space: bool,
    /// Whether it is the first of its line.
    pub first: bool,
}

/// All signs, longest first among those with the same start.
pub const SIGNS: [&str; 51] = [
    "<<=", ">>=", "...", "+=", "-=", "*=", "/=", "&=", "|=", "^=", "<<", ">>", "&&", "||", "<=", ">=", "==",
    "!=", "++", "--", "[[", "##", "#", "+", "-", "*", "/", "%", "=", "<", ">", "!", "~", "&", "|", "^", "?",
    ":", ",", ";", ".", "(", ")", "[", "]", "{", "}", "@", "$", "`", "\\",
];

impl Token {
    /// Whether it is this sign.
    #[must_use]
    pub fn is(&self, sign: &str) -> bool {
        matches!(self.tok, Tok::Sign(s) if s == sign)
    }

    /// The name, if it is one.
    #[must_use]
    pub fn ident(&self) -> Option<&Arc<str>> {
        match &self.tok {
            Tok::Ident(name) => Some(name),
            _ => None,
        }
    }

    /// As it is written.
    #[must_use]
    pub fn spelling(&self) -> String {
        match &self.tok {
            Tok::Ident(s) | Tok::Int(s) | Tok::Float(s) | Tok::Str(s) => s.to_string(),
            Tok::Pragma(s) => format!("#pragma {s}"),
            Tok::Sign(s) => (*s).to_owned(),
            Tok::Other(c) => c.to_string(),
            Tok::End => String::new(),
        }
    }
}
