// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads files, obeys directives and hands out expanded tokens.
//! The rules are those of C99.
//!
//! Invariant: macros, includes and text are bounded ([`TOKENS`], [`INCLUDES`], [`BYTES`]), so every input ends, in memory that its files
//! account for.

use super::condition::evaluate;
use super::macros::{Argument, Macro, Marked};
use crate::budget::Budget;
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::lexer::Lexer;
use crate::source::{Loc, Sources};
use crate::token::{Tok, Token};
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

/// Reads a file; None when there is none.
pub type Loader<'a> = dyn Fn(&Path) -> Option<String> + 'a;

/// Macros by name.
pub type Macros = HashMap<Arc<str>, Arc<Macro>>;

/// Tokens that macros may make in one compilation.
const TOKENS: u64 = 4_000_000;
/// Bytes of all files of one compilation, each counted as often as it is included.
const BYTES: usize = 32 << 20;
/// Files that may include each other.
const INCLUDES: usize = 64;
/// Macro arguments may nest this deep.
const NESTING: usize = 64;

enum Item {
    Token(Marked),
    Done(Arc<str>),
    Stop,
}

struct Condition {
    /// Whether the lines now read count.
    on: bool,
    /// Whether a branch has been taken.
    taken: bool,
    /// Whether the lines around count.
    outer: bool,
    has_else: bool,
}

/// The preprocessor.
pub struct Preprocessor<'a> {
    /// Files read so far.
    pub sources: Sources,
    /// Messages so far.
    pub diagnostics: Diagnostics,
    load: &'a Loader<'a>,
    search: Vec<String>,
    /// Macros by name.
    pub macros: Macros,
    active: HashSet<Arc<str>>,
    pending: Vec<Item>,
    files: Vec<(Lexer, usize, u16)>,
    conditions: Vec<Condition>,
    once: HashSet<Arc<str>>,
    budget: Budget,
    nesting: usize,
    /// Bytes that were read.
    bytes: usize,
}

impl<'a> Preprocessor<'a> {
    /// With the folders that `#include` searches after the including file's own.
    #[must_use]
    pub fn new(load: &'a Loader<'a>, search: Vec<String>) -> Self {
        Self {
            sources: Sources::default(),
            diagnostics: Diagnostics::default(),
            load,
            search,
            macros: HashMap::new(),
            active: HashSet::new(),
            pending: Vec::new(),
            files: Vec::new(),
            conditions: Vec::new(),
            once: HashSet::new(),
            budget: Budget::new(TOKENS, ["macros make more than", "tokens"]),
            nesting: 0,
            bytes: 0,
        }
    }

    /// As `-DNAME=TEXT` does.
    pub fn define(&mut self, option: &str) {
        match Macro::from_option(option) {
            Some((name, made)) => drop(self.macros.insert(name, Arc::new(made))),
            None => self.error(Loc::NONE, format!("macro name must be a name: -D{option}")),
        }
    }

    /// As `-UNAME` does.
    pub fn undefine(&mut self, name: &str) {
        self.macros.remove(name);
    }

    /// Reads this text next, then continues where it was.
    pub fn push_text(&mut self, name: &str, text: &str, system: bool) {
        self.bytes = self.bytes.saturating_add(text.len());
        if self.bytes > BYTES {
            let what = "files have more than";
            self.error(
                Loc::NONE,
                format!(
                    "{name}: with it {what} {} MiB, each counted as often as it is included",
                    BYTES >> 20
                ),
            );
            // Else each of the others would be tried.
            self.pending.clear();
            self.files.clear();
            return;
        }
        match self.sources.add(name, text, system) {
            Some(file) => {
                let text = self.sources.get(file).map(|f| f.text.clone()).unwrap_or_default();
                self.files.push((Lexer::new(text, file), self.conditions.len(), file));
            }
            None => self.error(Loc::NONE, "too many files".to_owned()),
        }
    }

    fn error(&mut self, loc: Loc, message: String) {
        self.diagnostics.push(Diagnostic::error(loc, message));
    }

    fn counts(&self) -> bool {
        self.conditions.last().is_none_or(|c| c.on)
    }

    fn file_token(&mut self) -> Token {
        loop {
            let counts = self.counts();
            let Some((lexer, ..)) = self.files.last_mut() else {
                return Token { tok: Tok::End, loc: Loc::NONE, space: true, first: true };
            };
            let token = lexer.next_token();
            if token.tok == Tok::End {
                let last = self.files.len() == 1;
                let depth = self.files.last().map_or(0, |f| f.1);
                if self.conditions.len() > depth {
                    self.error(token.loc, "unterminated conditional directive: #endif is missing".to_owned());
                    self.conditions.truncate(depth);
                }
                if last {
                    return token;
                }
                self.files.pop();
                continue;
            }
            if token.first && token.is("#") {
                if let Some(token) = self.directive(&token) {
                    return token;
                }
                continue;
            }
            if counts {
                return token;
            }
        }
    }

    fn raw(&mut self) -> Marked {
        loop {
            match self.pending.pop() {
                Some(Item::Token(marked)) => return marked,
                Some(Item::Done(name)) => drop(self.active.remove(&name)),
                Some(Item::Stop) => {
                    self.pending.push(Item::Stop);
                    return (Token { tok: Tok::End, loc: Loc::NONE, space: true, first: false }, true);
                }
                None => return (self.file_token(), false),
            }
        }
    }

    /// The next token, macros expanded.
    pub fn next_token(&mut self) -> Token {
        self.expanded().0
    }

    fn expanded(&mut self) -> Marked {
        loop {
            let (token, painted) = self.raw();
            let Some(name) = token.ident().filter(|_| !painted) else { return (token, painted) };
            match &**name {
                "__LINE__" => {
                    return (Token { tok: Tok::Int(token.loc.line.to_string().into()), ..token }, true);
                }
                "__FILE__" => {
                    let text = format!("\"{}\"", self.sources.name(token.loc));
                    return (Token { tok: Tok::Str(text.into()), ..token }, true);
                }
                _ => {}
            }
            let Some(found) = self.macros.get(name).cloned() else { return (token, painted) };
            if self.active.contains(name) {
                return (token, true);
            }
            let arguments = match &found.parameters {
                None => Vec::new(),
                Some(parameters) => {
                    let next = self.raw();
                    if !next.0.is("(") {
                        if next.0.tok != Tok::End {
                            self.pending.push(Item::Token(next));
                        }
                        return (token, false);
                    }
                    match self.arguments(&token, parameters.len(), found.variadic) {
                        Some(arguments) => arguments,
                        None => return (token, true),
                    }
                }
            };
            let Some(tokens) = found.substitute(&arguments, &token, &mut self.budget) else {
                self.error(token.loc, self.budget.to_string());
                self.pending.clear();
                self.files.clear();
                return (Token { tok: Tok::End, ..token }, true);
            };
            self.active.insert(name.clone());
            self.pending.push(Item::Done(name.clone()));
            self.pending.extend(tokens.into_iter().rev().map(Item::Token));
        }
    }

    fn arguments(&mut self, name: &Token, expected: usize, variadic: bool) -> Option<Vec<Argument>> {
        let mut list = vec![Argument::default()];
        let mut depth = 0_usize;
        loop {
            let marked = self.raw();
            let token = &marked.0;
            if token.tok == Tok::End {
                self.error(
                    name.loc,
                    format!("unterminated call of macro '{}': ')' is missing", name.spelling()),
                );
                return None;
            }
            if token.is(")") && depth == 0 {
                break;
            }
            if token.is("(") {
                depth += 1;
            } else if token.is(")") {
                depth -= 1;
            } else if token.is(",") && depth == 0 && !(variadic && list.len() == expected) {
                list.push(Argument::default());
                continue;
            }
            if let Some(last) = list.last_mut() {
                last.raw.push(marked);
            }
        }
        let none = expected == 0 && list.len() == 1 && list[0].raw.is_empty();
        let enough = list.len() == expected || (variadic && list.len() + 1 >= expected);
        if !none && !enough {
            let message =
                format!("macro '{}' takes {expected} arguments, got {}", name.spelling(), list.len());
            self.error(name.loc, message);
            return None;
        }
        if self.nesting >= NESTING {
            self.error(name.loc, "macro arguments are nested too deeply".to_owned());
            return None;
        }
        self.nesting += 1;
        for argument in &mut list {
            argument.expanded = self.expand(argument.raw.clone());
        }
        self.nesting -= 1;
        Some(list)
    }

    fn expand(&mut self, tokens: Vec<Marked>) -> Vec<Marked> {
        self.pending.push(Item::Stop);
        self.pending.extend(tokens.into_iter().rev().map(Item::Token));
        let mut out = Vec::new();
        loop {
            let marked = self.expanded();
            if marked.0.tok == Tok::End {
                break;
            }
            out.push(marked);
        }
        while !matches!(self.pending.pop(), Some(Item::Stop) | None) {}
        out
    }

    fn line_tokens(&mut self) -> Vec<Token> {
        let mut out = Vec::new();
        if let Some((lexer, ..)) = self.files.last_mut() {
            while !lexer.at_line_end() {
                out.push(lexer.next_token());
            }
        }
        out
    }

    fn directive(&mut self, hash: &Token) -> Option<Token> {
        let (lexer, ..) = self.files.last_mut()?;
        if lexer.at_line_end() {
            return None;
        }
        let next_token_read = lexer.next_token();
        let counts = self.counts();
        match next_token_read.ident().map(|n| &**n) {
            Some("if") => self.open(&next_token_read, |s| s.condition()),
            Some("ifdef") => self.open(&next_token_read, |s| s.is_defined()),
            Some("ifndef") => self.open(&next_token_read, |s| !s.is_defined()),
            Some("elif") => self.elif(&next_token_read),
            Some("else") => self.otherwise(&next_token_read),
            Some("endif") => {
                self.line_tokens();
                if self.conditions.len() <= self.files.last().map_or(0, |f| f.1) {
                    self.error(next_token_read.loc, "#endif without #if".to_owned());
                } else {
                    self.conditions.pop();
                }
            }
            _ if !counts => drop(self.line_tokens()),
            Some("define") => self.define_line(&next_token_read),
            Some("undef") => {
                if let Some(name) = self.line_tokens().first().and_then(Token::ident) {
                    self.macros.remove(name);
                }
            }
            Some("include") => self.include(&next_token_read),
            Some("pragma") => {
                let text = self.files.last_mut()?.0.rest_of_line();
                if text == "once" {
                    let file = self.files.last()?.2;
                    self.once.insert(self.sources.get(file)?.name.clone());
                    return None;
                }
                return Some(Token { tok: Tok::Pragma(text.into()), ..hash.clone() });
            }
            Some("line") => self.renumber(),
            Some("error") => {
                let text = self.files.last_mut()?.0.rest_of_line();
                self.error(next_token_read.loc, format!("#error {text}"));
            }
            Some("warning") => {
                let text = self.files.last_mut()?.0.rest_of_line();
                self.diagnostics.push(Diagnostic::warning(next_token_read.loc, format!("#warning {text}")));
            }
            _ => {
                self.line_tokens();
                self.error(
                    next_token_read.loc,
                    format!("invalid preprocessing directive '#{}'", next_token_read.spelling()),
                );
            }
        }
        None
    }

    fn open(&mut self, next_token_read: &Token, test: impl FnOnce(&mut Self) -> bool) {
        let outer = self.counts();
        if self.conditions.len() > 1000 {
            self.error(next_token_read.loc, "#if is nested too deeply".to_owned());
        }
        let on = if outer { test(self) } else { false };
        self.line_tokens();
        self.conditions.push(Condition { on, taken: on, outer, has_else: false });
    }

    fn branch(&mut self, next_token_read: &Token) -> Option<usize> {
        let lowest = self.files.last().map_or(0, |f| f.1);
        if self.conditions.len() <= lowest || self.conditions.last().is_some_and(|c| c.has_else) {
            self.error(next_token_read.loc, format!("#{} without #if", next_token_read.spelling()));
            self.line_tokens();
            return None;
        }
        Some(self.conditions.len() - 1)
    }

    fn elif(&mut self, next_token_read: &Token) {
        let Some(at) = self.branch(next_token_read) else { return };
        let is_active = self.conditions[at].outer && !self.conditions[at].taken;
        let on = is_active && self.condition();
        self.line_tokens();
        self.conditions[at].on = on;
        self.conditions[at].taken |= on;
    }

    fn otherwise(&mut self, next_token_read: &Token) {
        let Some(at) = self.branch(next_token_read) else { return };
        self.line_tokens();
        let condition = &mut self.conditions[at];
        condition.on = condition.outer && !condition.taken;
        condition.taken = true;
        condition.has_else = true;
    }

    fn is_defined(&mut self) -> bool {
        let tokens = self.line_tokens();
        tokens.first().and_then(Token::ident).is_some_and(|name| self.macros.contains_key(name))
    }

    fn condition(&mut self) -> bool {
        let tokens = self.line_tokens();
        let loc = tokens.first().map_or(Loc::NONE, |t| t.loc);
        let mut plain: Vec<Marked> = Vec::new();
        let mut i = 0;
        while i < tokens.len() {
            if tokens[i].ident().is_some_and(|n| &**n == "defined") {
                let wrapped = tokens.get(i + 1).is_some_and(|t| t.is("("));
                let at = i + 1 + usize::from(wrapped);
                let known =
                    tokens.get(at).and_then(Token::ident).is_some_and(|n| self.macros.contains_key(n));
                let text: &str = if known { "1" } else { "0" };
                plain.push((Token { tok: Tok::Int(text.into()), ..tokens[i].clone() }, true));
                i = at + 1 + usize::from(wrapped);
            } else {
                plain.push((tokens[i].clone(), false));
                i += 1;
            }
        }
        let expanded: Vec<Token> = self.expand(plain).into_iter().map(|(t, _)| t).collect();
        match evaluate(&expanded) {
            Ok(value) => value != 0,
            Err(message) => {
                self.error(loc, message);
                false
            }
        }
    }

    fn define_line(&mut self, next_token_read: &Token) {
        let Some((lexer, ..)) = self.files.last_mut() else { return };
        if lexer.at_line_end() {
            self.error(next_token_read.loc, "macro name missing".to_owned());
            return;
        }
        let name = lexer.next_token();
        let made = Macro::read(lexer);
        match (name.ident(), made) {
            (Some(name), Ok(made)) => drop(self.macros.insert(name.clone(), Arc::new(made))),
            (None, _) => self.error(name.loc, "macro name must be a name".to_owned()),
            (_, Err(message)) => self.error(name.loc, message),
        }
    }

    fn include(&mut self, next_token_read: &Token) {
        let tokens: Vec<Marked> = self.line_tokens().into_iter().map(|t| (t, false)).collect();
        let tokens: Vec<Token> = match tokens.first() {
            Some((t, _)) if matches!(t.tok, Tok::Str(_)) || t.is("<") => {
                tokens.into_iter().map(|(t, _)| t).collect()
            }
            _ => self.expand(tokens).into_iter().map(|(t, _)| t).collect(),
        };
        let (name, own) = match tokens.first().map(|t| &t.tok) {
            Some(Tok::Str(text)) => (text.trim_matches('"').to_owned(), true),
            Some(Tok::Sign("<")) => {
                (tokens[1..].iter().take_while(|t| !t.is(">")).map(Token::spelling).collect(), false)
            }
            _ => {
                self.error(
                    next_token_read.loc,
                    "expected \"FILENAME\" or <FILENAME> after #include".to_owned(),
                );
                return;
            }
        };
        // The compiler has already included it, and a file of this name would repeat its declarations.
        if Path::new(&name).file_name().is_some_and(|file| file == "stdosl.h") {
            return;
        }
        if self.files.len() >= INCLUDES {
            self.error(next_token_read.loc, format!("#include is nested more than {INCLUDES} deep"));
            return;
        }
        let mut folders: Vec<String> = Vec::new();
        if own {
            let here = self.files.last().and_then(|f| self.sources.get(f.2)).map_or("", |f| &f.name);
            folders.push(Path::new(here).parent().and_then(Path::to_str).unwrap_or("").to_owned());
        }
        folders.extend(self.search.iter().cloned());
        for folder in &folders {
            let path = Path::new(folder).join(&name);
            let shown = path.to_string_lossy().into_owned();
            if self.once.contains(&*shown) {
                return;
            }
            if let Some(text) = (self.load)(&path) {
                self.push_text(&shown, &text, false);
                return;
            }
        }
        let help = format!(
            "looked in: {}",
            folders.iter().map(|f| if f.is_empty() { "." } else { f }).collect::<Vec<_>>().join(", ")
        );
        self.diagnostics
            .push(Diagnostic::error(next_token_read.loc, format!("'{name}' file not found")).help(help));
    }

    fn renumber(&mut self) {
        let tokens = self.line_tokens();
        let Some(Tok::Int(text)) = tokens.first().map(|t| &t.tok) else { return };
        let line: u32 = text.parse().unwrap_or(1);
        let Some((lexer, _, file)) = self.files.last_mut() else { return };
        lexer.line = line.saturating_sub(1);
        if let Some(Tok::Str(name)) = tokens.get(1).map(|t| &t.tok)
            && let Some(renamed) = self.sources.rename(*file, name.trim_matches('"'))
        {
            lexer.file = renamed;
        }
    }
}
