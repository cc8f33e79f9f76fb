// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads tokens one after the other, and obeys pragmas. The pragmas are OSL's.

use super::unescape::unescape;
use crate::ast::{Expr, ExprKind, Item};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::preprocess::Preprocessor;
use crate::source::Loc;
use crate::token::{Tok, Token};
use std::collections::HashSet;
use std::sync::Arc;

/// Expressions and statements may nest this deep, operators in a row counted.
pub(super) const DEPTH: u16 = 400;

/// Marks that parsing cannot go on; the message has been given.
pub(super) struct Stop;
/// The result of a part of the grammar.
pub(super) type Parse<T> = Result<T, Stop>;

/// A file as a tree.
#[derive(Debug, Default)]
pub struct Parsed {
    /// Its items, up to a syntax error if there is one.
    pub items: Vec<Item>,
    /// Lines whose warnings are suppressed: number of the file and line.
    pub quiet: HashSet<(u16, u32)>,
    /// The messages.
    pub diagnostics: Diagnostics,
    /// Whether the text ended early with a syntax error.
    pub broken: bool,
}

/// Reads tokens.
#[derive(Debug)]
pub struct Parser {
    tokens: Vec<Token>,
    at: usize,
    pub(super) depth: u16,
    /// Whether extensions to OSL are unknown.
    pub(super) strict: bool,
    pub(super) out: Parsed,
}

const RESERVED: [&str; 31] = [
    "bool",
    "case",
    "char",
    "class",
    "const",
    "default",
    "double",
    "enum",
    "extern",
    "false",
    "friend",
    "inline",
    "long",
    "private",
    "protected",
    "short",
    "signed",
    "sizeof",
    "static",
    "switch",
    "template",
    "this",
    "true",
    "typedef",
    "uniform",
    "union",
    "unsigned",
    "varying",
    "virtual",
    "illuminance",
    "illuminate",
];

const KEYWORDS: [&str; 26] = [
    "break",
    "closure",
    "color",
    "continue",
    "do",
    "else",
    "float",
    "for",
    "if",
    "int",
    "matrix",
    "normal",
    "output",
    "point",
    "public",
    "return",
    "string",
    "struct",
    "vector",
    "void",
    "while",
    "or",
    "and",
    "not",
    "illuminance",
    "illuminate",
];

impl Parser {
    /// Takes all tokens of a preprocessor. If `strict`, extensions to OSL are unknown.
    #[must_use]
    pub fn new(source: &mut Preprocessor<'_>, strict: bool) -> Self {
        let mut this = Self { tokens: Vec::new(), at: 0, depth: 0, strict, out: Parsed::default() };
        loop {
            let mut token = source.next_token();
            match &token.tok {
                Tok::Pragma(text) => {
                    let text = text.clone();
                    this.pragma(&text, token.loc);
                    continue;
                }
                Tok::Ident(name) => match &**name {
                    "and" => token.tok = Tok::Sign("&&"),
                    "or" => token.tok = Tok::Sign("||"),
                    "not" => token.tok = Tok::Sign("!"),
                    _ => {}
                },
                _ => {}
            }
            let end = token.tok == Tok::End;
            this.tokens.push(token);
            if end {
                return this;
            }
        }
    }

    fn pragma(&mut self, text: &str, loc: Loc) {
        let (keyword, rest) = text.split_once(' ').unwrap_or((text, ""));
        let rest = rest.trim();
        let message = |unknown: &str| if rest.starts_with('"') { unescape(rest) } else { unknown.to_owned() };
        match keyword {
            "error" => self.out.diagnostics.push(Diagnostic::error(loc, message("<unknown error>"))),
            "warning" => self.out.diagnostics.push(Diagnostic::warning(loc, message("<unknown warning>"))),
            _ if keyword.eq_ignore_ascii_case("osl") => match rest {
                "nowarn" => drop(self.out.quiet.insert((loc.file, loc.line + 1))),
                other => self.out.diagnostics.push(
                    Diagnostic::warning(loc, format!("Unknown pragma '{other}'"))
                        .help("known is: #pragma osl nowarn"),
                ),
            },
            _ => {}
        }
    }

    pub(super) fn peek(&self) -> &Token {
        self.peek_at(0)
    }

    pub(super) fn peek_at(&self, ahead: usize) -> &Token {
        let last = self.tokens.len() - 1;
        &self.tokens[(self.at + ahead).min(last)]
    }

    pub(super) fn next(&mut self) -> Token {
        let token = self.peek().clone();
        if self.at + 1 < self.tokens.len() {
            self.at += 1;
        }
        token
    }

    pub(super) fn loc(&self) -> Loc {
        self.peek().loc
    }

    pub(super) fn is(&self, sign: &str) -> bool {
        self.peek().is(sign)
    }

    pub(super) fn is_keyword(&self, keyword: &str) -> bool {
        self.peek().ident().is_some_and(|n| &**n == keyword)
    }

    pub(super) fn take(&mut self, sign: &str) -> bool {
        let found = self.is(sign);
        if found {
            self.next();
        }
        found
    }

    pub(super) fn take_keyword(&mut self, keyword: &str) -> bool {
        let found = self.is_keyword(keyword);
        if found {
            self.next();
        }
        found
    }

    pub(super) fn expect(&mut self, sign: &str) -> Parse<()> {
        if self.take(sign) { Ok(()) } else { Err(self.syntax(&format!("'{sign}'"))) }
    }

    /// A name that may be given to something: no keyword.
    pub(super) fn name(&mut self) -> Parse<(Arc<str>, Loc)> {
        match self.peek().ident().cloned() {
            Some(name) if RESERVED.contains(&&*name) => {
                let loc = self.loc();
                self.out.diagnostics.push(Diagnostic::error(loc, format!("'{name}' is a reserved word")));
                Err(self.syntax("a name"))
            }
            Some(name) if !KEYWORDS.contains(&&*name) => Ok((name, self.next().loc)),
            _ => Err(self.syntax("a name")),
        }
    }

    /// Whether the token there is a name that is no keyword.
    pub(super) fn is_name(&self, ahead: usize) -> bool {
        self.peek_at(ahead).ident().is_some_and(|n| !KEYWORDS.contains(&&**n) && !RESERVED.contains(&&**n))
    }

    /// Reports that the next token is invalid, and the expected one.
    pub(super) fn syntax(&mut self, expected: &str) -> Stop {
        let token = self.peek().clone();
        let found = match token.tok {
            Tok::End => "the end of the file".to_owned(),
            _ => format!("'{}'", token.spelling()),
        };
        if token.ident().is_some_and(|n| RESERVED.contains(&&**n)) {
            let message = format!("'{}' is a reserved word", token.spelling());
            self.out.diagnostics.push(Diagnostic::error(token.loc, message));
        }
        let loc = if token.tok == Tok::End && self.at > 0 { self.tokens[self.at - 1].loc } else { token.loc };
        let help = format!("expected {expected}, found {found}");
        self.out.diagnostics.push(Diagnostic::error(loc, "Syntax error: syntax error").help(help));
        self.out.broken = true;
        Stop
    }

    pub(super) fn error(&mut self, loc: Loc, message: String) {
        self.out.diagnostics.push(Diagnostic::error(loc, message));
    }

    /// Goes one level deeper.
    pub(super) fn enter(&mut self) -> Parse<()> {
        self.depth += 1;
        if self.depth > DEPTH { Err(self.too_deep()) } else { Ok(()) }
    }

    fn too_deep(&mut self) -> Stop {
        let loc = self.loc();
        self.error(loc, format!("nested more than {DEPTH} levels deep"));
        self.out.broken = true;
        Stop
    }

    /// An expression whose depth is worked out from its parts.
    pub(super) fn node(&mut self, kind: ExprKind, loc: Loc) -> Parse<Expr> {
        let many = |list: &[Expr]| list.iter().map(|e| e.depth).max().unwrap_or(0);
        let below = match &kind {
            ExprKind::Int(_) | ExprKind::Float(_) | ExprKind::Str(_) | ExprKind::Name(_) => 0,
            ExprKind::Index(a, list) => a.depth.max(many(list)),
            ExprKind::Field(a, _)
            | ExprKind::Unary(_, a)
            | ExprKind::Before(_, a)
            | ExprKind::After(_, a)
            | ExprKind::Cast(_, a) => a.depth,
            ExprKind::Binary(_, a, b) | ExprKind::Assign(_, a, b) => a.depth.max(b.depth),
            ExprKind::Ternary(parts) => many(&**parts),
            ExprKind::Comma(list, _)
            | ExprKind::Call(_, list)
            | ExprKind::Construct(_, list)
            | ExprKind::Braces(list) => many(list),
        };
        if below >= DEPTH { Err(self.too_deep()) } else { Ok(Expr { kind, loc, depth: below + 1 }) }
    }
}
