// SPDX-License-Identifier: GPL-3.0-or-later
//! A Rust file's references to other files: its modules, imports, definitions and paths. From only the text,
//! without a compiler. Tests (`#[cfg(test)]`) are free: they are not read. Tests: `tests`.

use std::collections::BTreeSet;

use super::rust_code::without_tests;

/// A name that `use` brings in.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Import {
    /// From 1.
    pub(super) line: usize,
    /// The modules within the file that contain it.
    pub(super) within: Vec<String>,
    /// Where it comes from.
    pub(super) path: Vec<String>,
    /// Its name here; `None` for a star.
    pub(super) name: Option<String>,
    /// Whether others may import it from here.
    pub(super) is_public: bool,
}

/// A path of at least two names outside of `use`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mention {
    pub(super) line: usize,
    pub(super) within: Vec<String>,
    pub(super) path: Vec<String>,
}

/// A file as the others see it.
#[derive(Debug, Default)]
pub(super) struct Imports {
    /// Modules that have files of their own.
    pub(super) modules: Vec<String>,
    pub(super) imports: Vec<Import>,
    pub(super) mentions: Vec<Mention>,
    /// Names of items, at any depth.
    pub(super) defined: BTreeSet<String>,
    /// Macros by `macro_rules!`, which need no import in later code.
    pub(super) macros: BTreeSet<String>,
    /// Calls of macros without a path, with their lines.
    pub(super) macro_calls: Vec<(usize, String)>,
    /// Every word outside of `use`.
    pub(super) names: BTreeSet<String>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Token<'a> {
    Name(&'a str),
    /// `::`
    Within,
    Sign(char),
}

const ITEMS: [&str; 9] = ["fn", "struct", "enum", "trait", "type", "const", "static", "union", "mod"];

impl Imports {
    /// Reads code, of which comments and strings are blanked.
    pub(super) fn of(code: &str) -> Self {
        let code = without_tests(code);
        let tokens = tokens(&code);
        let mut reader = Reader { tokens: &tokens, at: 0, found: Self::default() };
        reader.read();
        reader.found
    }
}

fn tokens(code: &str) -> Vec<(usize, Token<'_>)> {
    let mut tokens = Vec::new();
    for (number, line) in code.lines().enumerate() {
        let mut rest = line;
        while let Some(letter) = rest.chars().next() {
            let name_end =
                rest.len() - rest.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_').len();
            let (token, length) = if name_end > 0 {
                (Token::Name(&rest[..name_end]), name_end)
            } else if rest.starts_with("::") {
                (Token::Within, 2)
            } else {
                (Token::Sign(letter), letter.len_utf8())
            };
            if token != Token::Sign(' ') {
                tokens.push((number + 1, token));
            }
            rest = &rest[length..];
        }
    }
    tokens
}

struct Reader<'a> {
    tokens: &'a [(usize, Token<'a>)],
    at: usize,
    found: Imports,
}

impl<'a> Reader<'a> {
    fn token(&self, offset: usize) -> Option<Token<'a>> {
        self.tokens.get(self.at + offset).map(|(_, token)| *token)
    }

    fn before(&self) -> Option<Token<'a>> {
        self.at.checked_sub(1).map(|at| self.tokens[at].1)
    }

    fn name_end(&self, offset: usize) -> Option<&'a str> {
        match self.token(offset) {
            Some(Token::Name(name_end)) => Some(name_end),
            _ => None,
        }
    }

    fn read(&mut self) {
        // Modules within the file that are open, with the depth of braces around their body.
        let mut open: Vec<(String, usize)> = Vec::new();
        let mut depth = 0_usize;
        while let Some(&(line, token)) = self.tokens.get(self.at) {
            match token {
                Token::Sign('{') => depth += 1,
                Token::Sign('}') => {
                    depth = depth.saturating_sub(1);
                    if open.last().is_some_and(|(_, around)| *around == depth) {
                        open.pop();
                    }
                }
                Token::Name("mod") => {
                    if let (Some(name), Some(after)) = (self.name_end(1), self.token(2)) {
                        match after {
                            Token::Sign(';') => self.found.modules.push(name.into()),
                            Token::Sign('{') => {
                                self.found.defined.insert(name.into());
                                open.push((name.into(), depth));
                            }
                            _ => {}
                        }
                    }
                }
                // `use<'a>` captures a lifetime.
                Token::Name("use") if self.token(1) != Some(Token::Sign('<')) => {
                    let within = open.iter().map(|(name, _)| name.clone()).collect();
                    self.read_use(line, within);
                    continue;
                }
                Token::Name(name_end) => {
                    let within = open.iter().map(|(name, _)| name.clone()).collect();
                    self.read_word(line, name_end, within);
                }
                Token::Within | Token::Sign(_) => {}
            }
            self.at += 1;
        }
    }

    fn read_word(&mut self, line: usize, name_end: &str, within: Vec<String>) {
        let starts = !matches!(self.before(), Some(Token::Within | Token::Sign('.')));
        if let Some(name) = self.name_end(1) {
            if ITEMS.contains(&name_end) {
                self.found.defined.insert(name.into());
            }
        } else if self.token(1) == Some(Token::Sign('!')) {
            if name_end == "macro_rules" {
                if let Some(name) = self.name_end(2) {
                    self.found.defined.insert(name.into());
                    self.found.macros.insert(name.into());
                }
            } else if starts {
                self.found.macro_calls.push((line, name_end.into()));
            }
        }
        // A definition of a name is no use of it.
        let defines = matches!(self.before(), Some(Token::Name(before)) if ITEMS.contains(&before));
        if !defines {
            self.found.names.insert(name_end.into());
        }
        // `pub(in a::b)` gives a visibility, not an import.
        let looks = !matches!(self.before(), Some(Token::Name("in")) if self.at >= 2 && self.tokens[self.at - 2].1 == Token::Sign('('));
        if starts && looks && self.token(1) == Some(Token::Within) {
            let mut path = vec![name_end.to_string()];
            let mut offset = 1;
            while self.token(offset) == Some(Token::Within)
                && let Some(name) = self.name_end(offset + 1)
            {
                path.push(name.into());
                offset += 2;
            }
            if path.len() > 1 {
                self.found.mentions.push(Mention { line, within, path });
            }
        }
    }

    /// From `use` to its semicolon.
    fn read_use(&mut self, line: usize, within: Vec<String>) {
        let is_public = matches!(self.before(), Some(Token::Name("pub") | Token::Sign(')')));
        self.at += 1;
        // A path that begins with `::` begins with another crate's name, which no file here has.
        if self.token(0) == Some(Token::Within) {
            while self.token(0).is_some_and(|token| token != Token::Sign(';')) {
                self.at += 1;
            }
            return;
        }
        let mut leaves = Vec::new();
        self.read_tree(&mut Vec::new(), &mut leaves);
        self.found.imports.extend(leaves.into_iter().map(|(path, name)| Import {
            line,
            within: within.clone(),
            path,
            name,
            is_public,
        }));
    }

    /// One branch of `use`, up to the comma, brace or semicolon after it.
    fn read_tree(&mut self, stem: &mut Vec<String>, leaves: &mut Vec<(Vec<String>, Option<String>)>) {
        let above = stem.len();
        let mut leaf = true;
        let mut name = None;
        while let Some(token) = self.token(0) {
            match token {
                Token::Name("as") => {
                    self.at += 1;
                    name = self.name_end(0).map(String::from);
                }
                Token::Name("self") if !stem.is_empty() => {}
                Token::Name(name_end) => stem.push(name_end.into()),
                Token::Sign('*') => {
                    leaves.push((stem.clone(), None));
                    leaf = false;
                }
                Token::Sign('{') => {
                    leaf = false;
                    self.at += 1;
                    while self.token(0).is_some_and(|token| token != Token::Sign('}')) {
                        self.read_tree(stem, leaves);
                        if self.token(0) == Some(Token::Sign(',')) {
                            self.at += 1;
                        }
                    }
                }
                Token::Sign(',' | '}' | ';') => break,
                Token::Within | Token::Sign(_) => {}
            }
            self.at += 1;
        }
        if leaf && let Some(last) = stem.last() {
            leaves.push((stem.clone(), Some(name.unwrap_or_else(|| last.clone()))));
        }
        stem.truncate(above);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tidy::rust_code::code_only;

    fn leaves(text: &str) -> Vec<String> {
        let shown = |import: &Import| {
            let within = import.within.iter().map(|name| format!("{name}> ")).collect::<String>();
            let name = import.name.as_deref().unwrap_or("*");
            let public = if import.is_public { "pub " } else { "" };
            format!("{public}{within}{} = {name}", import.path.join("::"))
        };
        Imports::of(&code_only(text)).imports.iter().map(shown).collect()
    }

    #[test]
    fn trees_of_use_are_read() {
        assert_eq!(
            leaves("use crate::a::{self, b as c, d::{e, *}};\npub(super) use f;\nuse super::super::g::*;"),
            [
                "crate::a = a",
                "crate::a::b = c",
                "crate::a::d::e = e",
                "crate::a::d = *",
                "pub f = f",
                "super::super::g = *"
            ],
            "each leaf"
        );
        assert_eq!(
            leaves("mod x { pub use super::a; fn f() -> impl B + use<'_> {} }"),
            ["pub x> super::a = a"]
        );
        assert_eq!(
            leaves("#[cfg(test)]\nmod tests { use crate::a; }\nuse b; // use c;"),
            ["b = b"],
            "tests are free"
        );
        assert_eq!(leaves("use ::png::Encoder;\nuse a;"), ["a = a"], "another crate");
    }

    #[test]
    fn paths_items_and_macros_are_read() {
        let found = Imports::of(
            "mod a;\npub mod b { fn c() { crate::d::E::f(super::g::<h::I>()) } }\n\
             macro_rules! m { () => { $crate::n::o() } }\npub(in crate::q) fn p() { x.y::<u8>(); z!(1) }",
        );
        assert_eq!(found.modules, ["a"], "only files");
        let paths = found.mentions.iter().map(|m| (m.line, m.path.join("::"))).collect::<Vec<_>>();
        let expected = [(2, "crate::d::E::f"), (2, "super::g"), (2, "h::I"), (3, "crate::n::o")];
        assert_eq!(paths, expected.map(|(line, path)| (line, path.to_string())), "with their lines");
        assert_eq!(found.mentions[0].within, ["b"], "within a module of the file");
        assert!(["b", "c", "m", "p"].iter().all(|name| found.defined.contains(*name)), "{:?}", found.defined);
        assert_eq!(found.macro_calls, [(4, "z".to_string())], "called");
        assert!(found.names.contains("E") && !found.names.contains("p"), "a definition is no use");
    }
}
