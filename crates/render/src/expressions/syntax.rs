// SPDX-License-Identifier: GPL-3.0-or-later
//! Light path expressions as text: events in the notation of [Hec90], extended as renderers of the field have it.
//! A path is a word of events, from the camera to the light; an expression names a set of words.
//! Letters: types `C R T V L O B`, scattering `D G S`; `<RG'label'>` joins type, scattering and labels;
//! `.`, `[..]`, `[^..]`, `(..)`, `|`, `*`, `+`, `?`, `{n,m}` as in regular expressions. Spaces are ignored.
//! Invariant: for any text, parsing returns or fails without a panic; nesting and length are bounded.
//! Tests: `tests`.

use std::fmt;

/// Longest expression, in characters, and deepest nesting.
const LONGEST: usize = 4096;
const DEEPEST: u32 = 64;
/// Most repetitions that `{n,m}` may count.
const MOST_COUNTED: u32 = 64;

/// The camera, where every path begins.
pub(crate) const CAMERA: u8 = 1;
pub(crate) const REFLECTION: u8 = 1 << 1;
pub(crate) const TRANSMISSION: u8 = 1 << 2;
pub(crate) const VOLUME: u8 = 1 << 3;
/// Light that light samples know: lamps and surfaces.
pub(crate) const LIGHT: u8 = 1 << 4;
/// Other emission: of media, and of surfaces that light nothing.
pub(crate) const EMISSION: u8 = 1 << 5;
pub(crate) const BACKGROUND: u8 = 1 << 6;

pub(crate) const DIFFUSE: u8 = 1;
pub(crate) const GLOSSY: u8 = 1 << 1;
pub(crate) const SINGULAR: u8 = 1 << 2;
/// The scattering of events that have none.
pub(crate) const NONE: u8 = 1 << 3;

const ANY: u8 = u8::MAX;

/// An expression that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ExpressionError {
    /// The text.
    pub expression: String,
    /// The character that is wrong, from 1 on; `None` = the whole.
    pub position: Option<usize>,
    /// The fault, and what is valid.
    pub problem: String,
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { expression, position, problem } = self;
        match position {
            Some(position) => {
                write!(f, "light path expression '{expression}', character {position}: {problem}")
            }
            None => write!(f, "light path expression '{expression}': {problem}"),
        }
    }
}

/// The labels that an event may have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum LabelPattern {
    Any,
    OneOf(Vec<String>),
    NoneOf(Vec<String>),
}

/// Some events: bits of types and of scattering, and labels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pattern {
    pub(crate) types: u8,
    pub(crate) scattering: u8,
    pub(crate) labels: LabelPattern,
}

/// Events that match one of some patterns, or none of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct EventSet {
    pub(crate) patterns: Vec<Pattern>,
    pub(crate) negated: bool,
}

/// A part of an expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Node {
    Event(EventSet),
    Sequence(Vec<Node>),
    Choice(Vec<Node>),
    /// At least, and at most.
    Repeat(Box<Node>, u32, Option<u32>),
}

/// Reads an expression.
pub(crate) fn parse(text: &str) -> Result<Node, ExpressionError> {
    let mut parser = Parser { text, chars: text.chars().collect(), at: 0, depth: 0 };
    if parser.chars.len() > LONGEST {
        let problem = format!("longer than {LONGEST} characters");
        return Err(ExpressionError { expression: text.chars().take(40).collect(), position: None, problem });
    }
    let node = parser.choice()?;
    match parser.peek() {
        None => Ok(node),
        Some(found) => Err(parser.error(format!("unexpected '{found}'"))),
    }
}

struct Parser<'a> {
    text: &'a str,
    chars: Vec<char>,
    at: usize,
    depth: u32,
}

impl Parser<'_> {
    fn error_at(&self, at: usize, problem: impl Into<String>) -> ExpressionError {
        ExpressionError { expression: self.text.into(), position: Some(at + 1), problem: problem.into() }
    }

    fn error(&self, problem: impl Into<String>) -> ExpressionError {
        self.error_at(self.at, problem)
    }

    /// The next character that is no space.
    fn peek(&mut self) -> Option<char> {
        while self.chars.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.chars.get(self.at).copied()
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.at += usize::from(found);
        found
    }

    fn choice(&mut self) -> Result<Node, ExpressionError> {
        let mut ways = vec![self.sequence()?];
        while self.take('|') {
            ways.push(self.sequence()?);
        }
        Ok(if ways.len() == 1 { ways.remove(0) } else { Node::Choice(ways) })
    }

    fn sequence(&mut self) -> Result<Node, ExpressionError> {
        let mut parts = Vec::new();
        while let Some(next) = self.peek().filter(|next| !matches!(next, '|' | ')')) {
            let part = self.part(next)?;
            parts.push(self.repeated(part)?);
        }
        match parts.len() {
            0 => Err(self.error("an event is missing, such as C, <RD> or .")),
            1 => Ok(parts.remove(0)),
            _ => Ok(Node::Sequence(parts)),
        }
    }

    fn part(&mut self, next: char) -> Result<Node, ExpressionError> {
        let begin = self.at;
        match next {
            '(' => {
                self.at += 1;
                self.depth += 1;
                if self.depth > DEEPEST {
                    return Err(self.error(format!("more than {DEEPEST} parentheses inside each other")));
                }
                let inner = self.choice()?;
                self.depth -= 1;
                if self.take(')') {
                    Ok(inner)
                } else {
                    Err(self.error_at(begin, "')' is missing for this '('"))
                }
            }
            '[' => {
                self.at += 1;
                let negated = self.take('^');
                let mut patterns = Vec::new();
                loop {
                    match self.peek() {
                        None => return Err(self.error_at(begin, "']' is missing for this '['")),
                        Some(']') => break,
                        Some(next) => patterns.push(self.event(next)?),
                    }
                }
                self.at += 1;
                if patterns.is_empty() {
                    return Err(self.error_at(begin, "these brackets are empty"));
                }
                Ok(Node::Event(EventSet { patterns, negated }))
            }
            _ => Ok(Node::Event(EventSet { patterns: vec![self.event(next)?], negated: false })),
        }
    }

    fn repeated(&mut self, mut part: Node) -> Result<Node, ExpressionError> {
        loop {
            let (least, most) = match self.peek() {
                Some('*') => (0, None),
                Some('+') => (1, None),
                Some('?') => (0, Some(1)),
                Some('{') => {
                    part = self.counted(part)?;
                    continue;
                }
                _ => return Ok(part),
            };
            self.at += 1;
            part = Node::Repeat(Box::new(part), least, most);
        }
    }

    /// `{n}`, `{n,}`, `{n,m}`.
    fn counted(&mut self, part: Node) -> Result<Node, ExpressionError> {
        let begin = self.at;
        self.at += 1;
        let least = self.number();
        let most = if self.take(',') { self.number() } else { least };
        let has_end = self.chars.get(self.at.wrapping_sub(1)) != Some(&',');
        let Some(least) = least.filter(|_| self.take('}')) else {
            return Err(self.error_at(begin, "expected a count: {n}, {n,} or {n,m}"));
        };
        let most = if has_end { most } else { None };
        if least > MOST_COUNTED || most.is_some_and(|most| most > MOST_COUNTED) {
            return Err(self.error_at(begin, format!("counts go up to {MOST_COUNTED}")));
        }
        if most.is_some_and(|most| most < least) {
            return Err(self.error_at(begin, "the second count is below the first"));
        }
        Ok(Node::Repeat(Box::new(part), least, most))
    }

    fn number(&mut self) -> Option<u32> {
        let mut value = None;
        while let Some(digit) = self.peek().and_then(|c| c.to_digit(10)) {
            self.at += 1;
            value = Some((value.unwrap_or(0_u32) * 10 + digit).min(9999));
        }
        value
    }

    /// One event: a letter, a label or `<..>`.
    fn event(&mut self, next: char) -> Result<Pattern, ExpressionError> {
        if next == '<' {
            return self.joined();
        }
        if next == '\'' {
            let label = self.label()?;
            return Ok(Pattern { types: ANY, scattering: ANY, labels: LabelPattern::OneOf(vec![label]) });
        }
        let (types, scattering) = match (type_of(next), scattering_of(next)) {
            (Some(types), _) => (types, ANY),
            (_, Some(scattering)) => (ANY, scattering),
            _ if next == '.' => (ANY, ANY),
            _ => return Err(self.error(unknown(next))),
        };
        self.at += 1;
        Ok(Pattern { types, scattering, labels: LabelPattern::Any })
    }

    /// `<type scattering labels>`; missing parts may be anything.
    fn joined(&mut self) -> Result<Pattern, ExpressionError> {
        let begin = self.at;
        self.at += 1;
        let types = self.letters(type_of, "a type of event: one of C R T V L O B, or .")?;
        let scattering = match self.peek() {
            Some('>' | '\'') | None => ANY,
            Some('[') if self.is_label_list() => ANY,
            Some(_) => self.letters(scattering_of, "scattering: one of D G S, or .")?,
        };
        let mut labels = LabelPattern::Any;
        loop {
            match self.peek() {
                Some('>') => break,
                Some('\'') => {
                    let label = self.label()?;
                    match &mut labels {
                        LabelPattern::OneOf(list) => list.push(label),
                        _ => labels = LabelPattern::OneOf(vec![label]),
                    }
                }
                Some('.') => self.at += 1,
                Some('[') => {
                    self.at += 1;
                    let negated = self.take('^');
                    let mut list = Vec::new();
                    while self.peek() == Some('\'') {
                        list.push(self.label()?);
                    }
                    if list.is_empty() || !self.take(']') {
                        return Err(self.error("expected labels such as ['key''fill']"));
                    }
                    labels = if negated { LabelPattern::NoneOf(list) } else { LabelPattern::OneOf(list) };
                }
                None => return Err(self.error_at(begin, "'>' is missing for this '<'")),
                Some(found) => {
                    return Err(self.error(format!("unexpected '{found}': expected a label or '>'")));
                }
            }
        }
        self.at += 1;
        Ok(Pattern { types, scattering, labels })
    }

    /// Whether the bracket here holds labels.
    fn is_label_list(&self) -> bool {
        let after = self.chars[self.at + 1..].iter().find(|c| !c.is_whitespace() && **c != '^');
        after == Some(&'\'')
    }

    /// A letter, `.`, or letters in brackets, as bits.
    fn letters(&mut self, bits: fn(char) -> Option<u8>, what: &str) -> Result<u8, ExpressionError> {
        let begin = self.at;
        match self.peek() {
            Some('.') => {
                self.at += 1;
                Ok(ANY)
            }
            Some('[') => {
                self.at += 1;
                let negated = self.take('^');
                let mut all = 0;
                while let Some(found) = self.peek().and_then(bits) {
                    all |= found;
                    self.at += 1;
                }
                if all == 0 || !self.take(']') {
                    return Err(self.error(format!("expected {what}")));
                }
                Ok(if negated { !all } else { all })
            }
            Some(next) => match bits(next) {
                Some(found) => {
                    self.at += 1;
                    Ok(found)
                }
                None => Err(self.error(format!("'{next}' is not {what}"))),
            },
            None => Err(self.error_at(begin, format!("expected {what}"))),
        }
    }

    /// `'text'`.
    fn label(&mut self) -> Result<String, ExpressionError> {
        let begin = self.at;
        self.at += 1;
        let rest = &self.chars[self.at..];
        let Some(length) = rest.iter().position(|&c| c == '\'') else {
            return Err(self.error_at(begin, "the label has no closing '"));
        };
        let label = rest[..length].iter().collect();
        self.at += length + 1;
        Ok(label)
    }
}

fn type_of(letter: char) -> Option<u8> {
    Some(match letter {
        'C' => CAMERA,
        'R' => REFLECTION,
        'T' => TRANSMISSION,
        'V' => VOLUME,
        'L' => LIGHT,
        'O' => EMISSION,
        'B' => BACKGROUND,
        _ => return None,
    })
}

fn scattering_of(letter: char) -> Option<u8> {
    Some(match letter {
        'D' => DIFFUSE,
        'G' => GLOSSY,
        'S' => SINGULAR,
        _ => return None,
    })
}

fn unknown(letter: char) -> String {
    match letter {
        's' => "'s' is unsupported: paths go straight through holes without an event".into(),
        '*' | '+' | '?' | '{' => format!("'{letter}' repeats nothing: an event goes before it"),
        ']' | '>' | '}' => format!("'{letter}' closes nothing"),
        _ => format!("unknown event '{letter}': types are C R T V L O B, scattering is D G S"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_and_groups_are_read() {
        let Ok(Node::Sequence(parts)) = parse("C <R[DG]'a'> .* [^LB]") else { panic!("a sequence") };
        let event = |i: usize| match &parts[i] {
            Node::Event(set) => set.clone(),
            other => panic!("{other:?} is an event"),
        };
        assert_eq!(event(0).patterns[0].types, CAMERA, "a type");
        let joined = &event(1).patterns[0];
        assert_eq!((joined.types, joined.scattering), (REFLECTION, DIFFUSE | GLOSSY), "both");
        assert_eq!(joined.labels, LabelPattern::OneOf(vec!["a".into()]), "a label");
        assert!(matches!(&parts[2], Node::Repeat(_, 0, None)), "any number");
        assert!(event(3).negated && event(3).patterns.len() == 2, "none of two");
        assert!(matches!(parse("CD{2,}L"), Ok(Node::Sequence(parts)) if parts[1] == Node::Repeat(
            Box::new(Node::Event(EventSet { patterns: vec![Pattern { types: ANY, scattering: DIFFUSE, labels: LabelPattern::Any }], negated: false })), 2, None)));
    }

    #[test]
    fn faults_have_a_position() {
        for (text, position, problem) in [
            ("", 1, "missing"),
            ("C<RD", 2, "'>' is missing"),
            ("C<DR>L", 3, "not a type"),
            ("C<RL>", 4, "not scattering"),
            ("CX", 2, "unknown event 'X'"),
            ("C(R|L", 2, "')' is missing"),
            ("C[R", 2, "']' is missing"),
            ("C[]L", 2, "empty"),
            ("*C", 1, "repeats nothing"),
            ("C)", 2, "unexpected"),
            ("C<L.'key>", 5, "no closing"),
            ("C{3,2}", 2, "below"),
            ("C{99}", 2, "up to"),
            ("C{x}", 2, "count"),
            ("Cs", 2, "unsupported"),
            ("C||L", 3, "missing"),
        ] {
            let error = parse(text).expect_err(text);
            assert_eq!(error.position, Some(position), "{text}: {error}");
            assert!(error.problem.contains(problem), "{text}: {error}");
        }
        assert!(parse(&"(".repeat(1000)).is_err() && parse(&"C".repeat(5000)).is_err(), "bounded");
    }
}
