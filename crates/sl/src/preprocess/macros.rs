// SPDX-License-Identifier: GPL-3.0-or-later
//! Macros: their definition and the tokens that a use of one becomes.
//! Source: C99, section 6.10.3; original code.

use crate::budget::Budget;
use crate::lexer::{Lexer, tokens_of};
use crate::source::Loc;
use crate::token::{Tok, Token};
use std::sync::Arc;

/// A macro.
#[derive(Clone, Debug)]
pub struct Macro {
    /// Names of the parameters; none for a macro that takes no parentheses.
    pub parameters: Option<Vec<Arc<str>>>,
    /// Whether the last parameter takes all arguments that are left.
    pub variadic: bool,
    /// The text.
    pub body: Vec<Token>,
}

/// A token and whether it must never be expanded again.
pub(super) type Marked = (Token, bool);

/// One argument as written, and after expansion.
#[derive(Clone, Debug, Default)]
pub struct Argument {
    /// As written.
    pub raw: Vec<Marked>,
    /// Expanded by itself.
    pub expanded: Vec<Marked>,
}

impl Macro {
    /// From the rest of a `#define` line, after the name.
    ///
    /// # Errors
    /// The fault of the parameter list.
    pub fn read(lexer: &mut Lexer) -> Result<Self, String> {
        let mut body = Vec::new();
        while !lexer.at_line_end() {
            body.push(lexer.next_token());
        }
        let takes = body.first().is_some_and(|t| t.is("(") && !t.space);
        if !takes {
            return Ok(Self { parameters: None, variadic: false, body });
        }
        let (mut parameters, mut variadic, mut at) = (Vec::new(), false, 1);
        if body.get(at).is_some_and(|t| t.is(")")) {
            at += 1;
        } else {
            loop {
                let Some(token) = body.get(at) else {
                    return Err("missing ')' in macro parameter list".into());
                };
                if token.is("...") {
                    parameters.push("__VA_ARGS__".into());
                    variadic = true;
                    at += 1;
                } else if let Some(name) = token.ident() {
                    parameters.push(name.clone());
                    at += 1;
                    if body.get(at).is_some_and(|t| t.is("...")) {
                        variadic = true;
                        at += 1;
                    }
                } else {
                    return Err("expected a name in macro parameter list".into());
                }
                match body.get(at) {
                    Some(t) if t.is(")") => break,
                    Some(t) if t.is(",") && !variadic => at += 1,
                    _ => return Err("missing ')' in macro parameter list".into()),
                }
            }
            at += 1;
        }
        Ok(Self { parameters: Some(parameters), variadic, body: body.split_off(at.min(body.len())) })
    }

    /// From a `-D` option: `NAME`, `NAME=TEXT`, `NAME(a,b)=TEXT`.
    #[must_use]
    pub fn from_option(option: &str) -> Option<(Arc<str>, Self)> {
        let (head, text) = option.split_once('=').unwrap_or((option, "1"));
        let line = head.replacen('(', " (", 1);
        let name = tokens_of(&line).first()?.ident()?.clone();
        let rest = head.get(name.len()..)?;
        let mut lexer =
            Lexer::new(format!("{rest}{}{text}", if rest.is_empty() { " " } else { "" }).into(), u16::MAX);
        Some((name, Self::read(&mut lexer).ok()?))
    }

    fn parameter(&self, token: &Token) -> Option<usize> {
        let name = token.ident()?;
        self.parameters.as_ref()?.iter().position(|p| p == name)
    }

    /// The tokens that a use becomes, all at the position of the use; none if they are more than the budget.
    #[must_use]
    pub fn substitute(&self, arguments: &[Argument], at: &Token, budget: &mut Budget) -> Option<Vec<Marked>> {
        let empty = Argument::default();
        let argument = |i: usize| arguments.get(i).unwrap_or(&empty);
        let mut out: Vec<Marked> = Vec::new();
        let mut i = 0;
        while i < self.body.len() {
            let token = &self.body[i];
            if token.is("#")
                && self.parameters.is_some()
                && let Some(p) = self.body.get(i + 1).and_then(|t| self.parameter(t))
            {
                budget.spend(argument(p).raw.len())?;
                let text = quote(&argument(p).raw);
                budget.spend(text.len() / TOKEN)?;
                out.push((Token { tok: Tok::Str(text.into()), ..token.clone() }, false));
                i += 2;
                continue;
            }
            budget.spend(1)?;
            if token.is("##") && i + 1 < self.body.len() && !out.is_empty() {
                let right = &self.body[i + 1];
                let tokens = match self.parameter(right) {
                    Some(p) => {
                        budget.spend(argument(p).raw.len())?;
                        argument(p).raw.clone()
                    }
                    None => vec![(right.clone(), false)],
                };
                let swallow = self.variadic && out.last().is_some_and(|(t, _)| t.is(","));
                if swallow && tokens.is_empty() {
                    out.pop();
                } else if swallow {
                    out.extend(tokens);
                } else {
                    let length = out.last().map_or(0, |(left, _)| left.spelling().len());
                    budget.spend(length / TOKEN)?;
                    paste(&mut out, tokens);
                }
                i += 2;
                continue;
            }
            match self.parameter(token) {
                Some(p) => {
                    let before_paste = self.body.get(i + 1).is_some_and(|t| t.is("##"));
                    let source = if before_paste { &argument(p).raw } else { &argument(p).expanded };
                    if before_paste && source.is_empty() {
                        // An empty left side: the right side stays as it is.
                        let blank = Token { tok: Tok::Str("".into()), ..token.clone() };
                        out.push((blank, true));
                    }
                    budget.spend(source.len())?;
                    let from = out.len();
                    out.extend(source.iter().cloned());
                    if let Some((first, _)) = out.get_mut(from) {
                        first.space = token.space;
                    }
                }
                None => out.push((token.clone(), false)),
            }
            i += 1;
        }
        out.retain(|(t, _)| !matches!(&t.tok, Tok::Str(s) if s.is_empty()));
        for (token, _) in &mut out {
            token.loc = Loc { line: at.loc.line, ..at.loc };
            token.first = false;
        }
        Some(out)
    }
}

/// Bytes of a text that count as a token.
const TOKEN: usize = 16;

fn quote(tokens: &[Marked]) -> String {
    let mut text = String::from("\"");
    for (i, (token, _)) in tokens.iter().enumerate() {
        if i > 0 && token.space {
            text.push(' ');
        }
        let spelling = token.spelling();
        match token.tok {
            Tok::Str(_) => text.push_str(&spelling.replace('\\', "\\\\").replace('"', "\\\"")),
            _ => text.push_str(&spelling),
        }
    }
    text.push('"');
    text
}

fn paste(out: &mut Vec<Marked>, right: Vec<Marked>) {
    let mut right = right.into_iter();
    let (Some((left, _)), Some((first, _))) = (out.pop(), right.next()) else { return };
    let space = left.space;
    for (i, mut token) in
        tokens_of(&format!("{}{}", left.spelling(), first.spelling())).into_iter().enumerate()
    {
        if i == 0 {
            token.space = space;
        }
        out.push((token, false));
    }
    out.extend(right);
}
