// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads regular expressions of ECMAScript's syntax, as OSL does through C++'s library: groups, lookahead, references back, lazy
//! repetition, classes with names.
//! Source: ECMA-262, 3rd edition, 15.10.1, with POSIX's named classes. Tests: `tests/regex.rs`.

use super::program::{Set, Step, is_word_byte};

/// Longer programs are an error: nested counts multiply.
const LONGEST: usize = 50_000;
/// Deeper groups are an error.
const DEEPEST: usize = 100;

pub(super) struct Parsed {
    pub(super) steps: Vec<Step>,
    /// Two for each group, and two for the whole.
    pub(super) saves: usize,
    pub(super) loops: usize,
}

/// Where and why a pattern is none.
pub(super) type Fault = (usize, &'static str);

/// Whether a byte is in a class.
type IsIn = fn(u8) -> bool;

pub(super) fn parse(pattern: &str) -> Result<Parsed, Fault> {
    let mut parser = Parser { text: pattern.as_bytes(), at: 0, groups: 0, loops: 0, depth: 0, steps: vec![] };
    parser.steps.push(Step::Save(0));
    parser.alternatives()?;
    if parser.at < parser.text.len() {
        return Err((parser.at, "unmatched closing parenthesis"));
    }
    parser.steps.extend([Step::Save(1), Step::Found]);
    let highest =
        parser.steps.iter().filter_map(|step| if let Step::Again(n) = step { Some(*n) } else { None }).max();
    if highest.is_some_and(|highest| highest > parser.groups) {
        return Err((parser.text.len(), "a reference to a group that there is not"));
    }
    Ok(Parsed { steps: parser.steps, saves: 2 * (parser.groups + 1), loops: parser.loops })
}

struct Parser<'a> {
    text: &'a [u8],
    at: usize,
    groups: usize,
    loops: usize,
    depth: usize,
    steps: Vec<Step>,
}

impl Parser<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn eat(&mut self, token: &str) -> bool {
        let found = self.text[self.at..].starts_with(token.as_bytes());
        self.at += if found { token.len() } else { 0 };
        found
    }

    fn push(&mut self, step: Step) -> Result<(), Fault> {
        if self.steps.len() >= LONGEST {
            return Err((self.at, "too large: fewer or smaller counts are needed"));
        }
        self.steps.push(step);
        Ok(())
    }

    fn alternatives(&mut self) -> Result<(), Fault> {
        let mut start = self.steps.len();
        let mut ends = Vec::new();
        self.sequence()?;
        while self.eat("|") {
            // All earlier steps move by one, for the choice before them.
            self.insert(start, 1);
            self.push(Step::Jump(0))?;
            ends.push(self.steps.len() - 1);
            self.steps[start] = Step::Either(start + 1, self.steps.len());
            start = self.steps.len();
            self.sequence()?;
        }
        let end = self.steps.len();
        for step_index in ends {
            self.steps[step_index] = Step::Jump(end);
        }
        Ok(())
    }

    /// Inserts steps at an index; those behind it move.
    fn insert(&mut self, at: usize, count: usize) {
        for step in &mut self.steps[at..] {
            shift(step, at, count as isize);
        }
        self.steps.splice(at..at, std::iter::repeat_n(Step::Jump(0), count));
    }

    fn sequence(&mut self) -> Result<(), Fault> {
        while let Some(c) = self.peek() {
            if c == b'|' || c == b')' {
                break;
            }
            self.term()?;
        }
        Ok(())
    }

    fn term(&mut self) -> Result<(), Fault> {
        let start = self.steps.len();
        let repeatable = self.atom()?;
        let at = self.at;
        let (least, most) = match self.peek() {
            Some(b'*') => (0, None),
            Some(b'+') => (1, None),
            Some(b'?') => (0, Some(1)),
            Some(b'{') => (0, None),
            _ => return Ok(()),
        };
        if !repeatable {
            return Err((at, "nothing to repeat before this"));
        }
        let (least, most) = if self.eat("{") {
            self.counts()?
        } else {
            self.at += 1;
            (least, most)
        };
        let lazy = self.eat("?");
        self.repeat(start, least, most, lazy)
    }

    fn number(&mut self) -> Option<usize> {
        let start = self.at;
        let mut value = 0_usize;
        while let Some(c @ b'0'..=b'9') = self.peek() {
            value = (value * 10 + usize::from(c - b'0')).min(LONGEST);
            self.at += 1;
        }
        (self.at > start).then_some(value)
    }

    /// The counts in braces.
    fn counts(&mut self) -> Result<(usize, Option<usize>), Fault> {
        let at = self.at;
        let least = self.number().ok_or((at, "count missing in the braces"))?;
        let most = if self.eat(",") { self.number() } else { Some(least) };
        if !self.eat("}") {
            return Err((self.at, "a closing brace is missing"));
        }
        if most.is_some_and(|most| most < least) {
            return Err((at, "the second count is below the first"));
        }
        Ok((least, most))
    }

    /// Repeats the steps from `start` on.
    fn repeat(&mut self, start: usize, least: usize, most: Option<usize>, lazy: bool) -> Result<(), Fault> {
        let body: Vec<Step> = self.steps.split_off(start);
        let either = |stay: usize, leave: usize| {
            if lazy { Step::Either(leave, stay) } else { Step::Either(stay, leave) }
        };
        for _ in 0..least {
            self.copy(&body, start)?;
        }
        if let Some(most) = most {
            let mut choices = Vec::new();
            for _ in least..most {
                choices.push(self.steps.len());
                self.push(Step::Jump(0))?;
                self.copy(&body, start)?;
            }
            let end = self.steps.len();
            for step_index in choices {
                self.steps[step_index] = either(step_index + 1, end);
            }
        } else {
            let loop_index = self.loops;
            self.loops += 1;
            let choice = self.steps.len();
            self.push(Step::Jump(0))?;
            self.push(Step::Loop(loop_index))?;
            self.copy(&body, start)?;
            self.push(Step::Moved(loop_index))?;
            self.push(Step::Jump(choice))?;
            self.steps[choice] = either(choice + 1, self.steps.len());
        }
        Ok(())
    }

    /// A copy of steps that began at `from`.
    fn copy(&mut self, body: &[Step], from: usize) -> Result<(), Fault> {
        let by = self.steps.len() as isize - from as isize;
        for step in body {
            let mut step = step.clone();
            shift(&mut step, from, by);
            self.push(step)?;
        }
        Ok(())
    }

    /// One atom, and whether it may be repeated.
    fn atom(&mut self) -> Result<bool, Fault> {
        let at = self.at;
        let Some(c) = self.peek() else { return Ok(false) };
        self.at += 1;
        match c {
            b'^' => self.push(Step::Start)?,
            b'$' => self.push(Step::End)?,
            b'(' => return self.group(at),
            b'[' => {
                let set = self.class(at)?;
                self.push(Step::One(set))?;
                return Ok(true);
            }
            b'.' => {
                self.push(Step::One(Set::of([b'\n', b'\r']).inverse()))?;
                return Ok(true);
            }
            b'\\' => return self.escape(at),
            b'*' | b'+' | b'?' | b'{' => return Err((at, "nothing to repeat before this")),
            _ => {
                self.push(Step::One(Set::of([c])))?;
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn group(&mut self, at: usize) -> Result<bool, Fault> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err((at, "groups are nested too deeply"));
        }
        let lookahead = if self.eat("?=") {
            Some(true)
        } else if self.eat("?!") {
            Some(false)
        } else {
            None
        };
        if let Some(expected) = lookahead {
            let step_index = self.steps.len();
            self.push(Step::Jump(0))?;
            self.alternatives()?;
            self.push(Step::Captured)?;
            self.steps[step_index] = Step::Lookahead { expected, then: self.steps.len() };
        } else if self.eat("?:") {
            self.alternatives()?;
        } else if self.peek() == Some(b'?') {
            return Err((self.at, "after (? only :, = and ! are supported"));
        } else {
            self.groups += 1;
            let group = self.groups;
            self.push(Step::Save(2 * group))?;
            self.alternatives()?;
            self.push(Step::Save(2 * group + 1))?;
        }
        if !self.eat(")") {
            return Err((at, "this parenthesis is not closed"));
        }
        self.depth -= 1;
        Ok(true)
    }

    /// Hexadecimal digits.
    fn hex(&mut self, digits: usize) -> Result<u8, Fault> {
        let at = self.at;
        let text = self.text.get(at..at + digits).and_then(|text| std::str::from_utf8(text).ok());
        let value = text.and_then(|text| u32::from_str_radix(text, 16).ok());
        self.at += digits;
        let value = value.ok_or((at, "hexadecimal digits are missing"))?;
        value.try_into().map_err(|_| (at, "only bytes can be matched"))
    }

    /// The classes and bytes that a letter behind a backslash means everywhere.
    fn escaped_set(&mut self, at: usize) -> Result<Set, Fault> {
        let c = self.peek().ok_or((at, "character missing after the backslash"))?;
        self.at += 1;
        let all = || 0..=u8::MAX;
        let class = |f: fn(u8) -> bool| Set::of(all().filter(|byte| f(*byte)));
        let is_space: fn(u8) -> bool = |c| c.is_ascii_whitespace() || c == 0x0b;
        Ok(match c {
            b'd' => class(|c| c.is_ascii_digit()),
            b'D' => class(|c| c.is_ascii_digit()).inverse(),
            b'w' => class(is_word_byte),
            b'W' => class(is_word_byte).inverse(),
            b's' => class(is_space),
            b'S' => class(is_space).inverse(),
            b't' => Set::of([b'\t']),
            b'n' => Set::of([b'\n']),
            b'v' => Set::of([0x0b]),
            b'f' => Set::of([0x0c]),
            b'r' => Set::of([b'\r']),
            b'0' => Set::of([0]),
            b'x' => Set::of([self.hex(2)?]),
            b'u' => Set::of([self.hex(4)?]),
            b'c' => {
                let letter =
                    self.peek().filter(u8::is_ascii_alphabetic).ok_or((at, "\\c requires a letter"))?;
                self.at += 1;
                Set::of([letter & 31])
            }
            c if c.is_ascii_alphanumeric() => return Err((at, "unknown letter after a backslash")),
            c => Set::of([c]),
        })
    }

    fn escape(&mut self, at: usize) -> Result<bool, Fault> {
        match self.peek() {
            Some(b'b') => {
                self.at += 1;
                self.push(Step::Boundary(true))?;
                Ok(false)
            }
            Some(b'B') => {
                self.at += 1;
                self.push(Step::Boundary(false))?;
                Ok(false)
            }
            Some(b'1'..=b'9') => {
                let group = self.number().unwrap_or(0);
                self.push(Step::Again(group))?;
                Ok(true)
            }
            _ => {
                let set = self.escaped_set(at)?;
                self.push(Step::One(set))?;
                Ok(true)
            }
        }
    }

    fn named_class(&mut self, at: usize) -> Result<Set, Fault> {
        const NAMES: [(&str, IsIn); 13] = [
            ("alpha:]", |c| c.is_ascii_alphabetic()),
            ("digit:]", |c| c.is_ascii_digit()),
            ("alnum:]", |c| c.is_ascii_alphanumeric()),
            ("upper:]", |c| c.is_ascii_uppercase()),
            ("lower:]", |c| c.is_ascii_lowercase()),
            ("space:]", |c| c.is_ascii_whitespace() || c == 0x0b),
            ("blank:]", |c| c == b' ' || c == b'\t'),
            ("punct:]", |c| c.is_ascii_punctuation()),
            ("xdigit:]", |c| c.is_ascii_hexdigit()),
            ("cntrl:]", |c| c.is_ascii_control()),
            ("graph:]", |c| c.is_ascii_graphic()),
            ("print:]", |c| c.is_ascii_graphic() || c == b' '),
            ("w:]", is_word_byte),
        ];
        for (name, function) in NAMES {
            if self.eat(name) {
                return Ok(Set::of((0..=u8::MAX).filter(|byte| function(*byte))));
            }
        }
        Err((at, "unknown class"))
    }

    /// One part of a class: a byte, or a set.
    fn class_part(&mut self, at: usize) -> Result<(Option<u8>, Set), Fault> {
        if self.eat("[:") {
            return Ok((None, self.named_class(at)?));
        }
        if self.eat("\\") {
            if self.eat("b") {
                return Ok((Some(8), Set::of([8])));
            }
            let set = self.escaped_set(at)?;
            let mut bytes = (0..=u8::MAX).filter(|byte| set.has(*byte));
            let (first, second) = (bytes.next(), bytes.next());
            return Ok((first.filter(|_| second.is_none()), set));
        }
        let c = self.peek().ok_or((at, "this bracket is not closed"))?;
        self.at += 1;
        Ok((Some(c), Set::of([c])))
    }

    fn class(&mut self, at: usize) -> Result<Set, Fault> {
        let inverted = self.eat("^");
        let mut all = Set::default();
        while !self.eat("]") {
            let step_index = self.at;
            let (low, set) = self.class_part(at)?;
            all.join(set);
            let is_range =
                self.peek() == Some(b'-') && !matches!(self.text.get(self.at + 1), None | Some(b']'));
            if let (Some(low), true) = (low, is_range) {
                self.at += 1;
                let (high, _) = self.class_part(at)?;
                let high = high
                    .filter(|high| *high >= low)
                    .ok_or((step_index, "a range must end above its start"))?;
                all.join(Set::of(low..=high));
            }
        }
        Ok(if inverted { all.inverse() } else { all })
    }
}

/// Moves the targets of a step that are at `from` or behind.
fn shift(step: &mut Step, from: usize, by: isize) {
    let moved = |step_index: &mut usize| {
        if *step_index >= from {
            *step_index = step_index.wrapping_add_signed(by);
        }
    };
    match step {
        Step::Either(a, b) => {
            moved(a);
            moved(b);
        }
        Step::Jump(step_index) | Step::Lookahead { then: step_index, .. } => moved(step_index),
        _ => {}
    }
}
