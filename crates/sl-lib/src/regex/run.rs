// SPDX-License-Identifier: GPL-3.0-or-later
//! Runs regular expressions: tries alternatives in order, and backtracks where one fails. The meaning of
//! results is that of OSL 1.14, `regex_search`. Invariants: no pattern and no subject makes it panic, recurse
//! more deeply than lookaheads are nested, or take more than `MOST_STEPS` steps. Tests: `tests/regex.rs`.

use super::parse::parse;
use super::program::{Step, is_word_byte};

/// A search is ended after so many steps: a tenth of a second or so.
pub(super) const MOST_STEPS: u64 = 10_000_000;

/// A compiled regular expression.
#[derive(Clone, Debug)]
pub struct Regex {
    steps: Vec<Step>,
    saves: usize,
    loops: usize,
    pattern_length: usize,
}

/// A pattern that is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RegexError {
    /// The pattern.
    pub pattern: String,
    /// At which byte.
    pub at: usize,
    /// Why.
    pub reason: &'static str,
}

impl std::fmt::Display for RegexError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "regular expression \"{}\", byte {}: {}", self.pattern, self.at, self.reason)
    }
}

impl std::error::Error for RegexError {}

/// A search was ended, for it tried too many alternatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManySteps;

impl std::fmt::Display for TooManySteps {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "a regular expression was given up after {MOST_STEPS} steps: repetitions within repetitions multiply"
        )
    }
}

impl std::error::Error for TooManySteps {}

/// Start and end in bytes of the whole match, then of each group; `None` for groups that took no part.
pub type Groups = Vec<Option<(usize, usize)>>;

const UNSET: usize = usize::MAX;

/// The alternative after a failed path.
enum Back {
    /// Continues here.
    Try { step: usize, at: usize },
    /// Puts a number back.
    Restore { slot: usize, value: usize },
}

struct Machine<'a> {
    steps: &'a [Step],
    subject: &'a [u8],
    /// Starts and ends of groups, then starts of iterations.
    slots: Vec<usize>,
    loops_at: usize,
    whole: bool,
    steps_left: u64,
}

impl Machine<'_> {
    /// Counts extra work of a step: bytes that are compared or copied, 64 of them as one.
    fn spend(&mut self, bytes: usize) -> Result<(), TooManySteps> {
        self.steps_left = self.steps_left.checked_sub(bytes as u64 / 64).ok_or(TooManySteps)?;
        Ok(())
    }

    fn set(&mut self, back: &mut Vec<Back>, slot: usize, value: usize) {
        back.push(Back::Restore { slot, value: self.slots[slot] });
        self.slots[slot] = value;
    }

    /// Runs from a step on; `true` if it reaches the end, which for a lookaround is the end of its own steps.
    fn run(&mut self, mut step: usize, mut at: usize) -> Result<bool, TooManySteps> {
        let mut back = Vec::new();
        loop {
            self.steps_left = self.steps_left.checked_sub(1).ok_or(TooManySteps)?;
            let byte = self.subject.get(at).copied();
            let next = match &self.steps[step] {
                Step::One(set) => byte.filter(|byte| set.has(*byte)).map(|_| (step + 1, at + 1)),
                Step::Either(first, second) => {
                    back.push(Back::Try { step: *second, at });
                    Some((*first, at))
                }
                Step::Jump(step_index) => Some((*step_index, at)),
                Step::Save(slot) => {
                    self.set(&mut back, *slot, at);
                    Some((step + 1, at))
                }
                Step::Start => (at == 0).then_some((step + 1, at)),
                Step::End => byte.is_none().then_some((step + 1, at)),
                Step::Boundary(expected) => {
                    let before = at > 0 && is_word_byte(self.subject[at - 1]);
                    let found = before != byte.is_some_and(is_word_byte);
                    (found == *expected).then_some((step + 1, at))
                }
                Step::Again(group) => {
                    let (start, end) = (self.slots[2 * group], self.slots[2 * group + 1]);
                    // A group that holds nothing yet is met by nothing.
                    let held = if start == UNSET || end == UNSET {
                        &[]
                    } else {
                        &self.subject[start..end.max(start)]
                    };
                    let length = held.len();
                    self.spend(length)?;
                    let held = &self.subject[start.min(self.subject.len())..][..length];
                    self.subject[at..].starts_with(held).then_some((step + 1, at + held.len()))
                }
                Step::Lookahead { expected, then } => {
                    let (expected, then, before) = (*expected, *then, self.slots.clone());
                    self.spend(2 * size_of_val(&*before))?;
                    let captured = self.run(step + 1, at)?;
                    let found = std::mem::replace(&mut self.slots, before);
                    if captured && expected {
                        for (slot, value) in found.into_iter().enumerate() {
                            if self.slots[slot] != value {
                                self.set(&mut back, slot, value);
                            }
                        }
                    }
                    (captured == expected).then_some((then, at))
                }
                Step::Loop(loop_index) => {
                    self.set(&mut back, self.loops_at + loop_index, at);
                    Some((step + 1, at))
                }
                Step::Moved(loop_index) => {
                    (self.slots[self.loops_at + loop_index] != at).then_some((step + 1, at))
                }
                Step::Captured => return Ok(true),
                Step::Found if !self.whole || byte.is_none() => return Ok(true),
                Step::Found => None,
            };
            if let Some(next) = next {
                (step, at) = next;
                continue;
            }
            loop {
                match back.pop() {
                    Some(Back::Try { step: there, at: step_index }) => {
                        (step, at) = (there, step_index);
                        break;
                    }
                    Some(Back::Restore { slot, value }) => self.slots[slot] = value,
                    None => return Ok(false),
                }
            }
        }
    }
}

impl Regex {
    /// Reads a pattern.
    ///
    /// # Errors
    /// If it is invalid, with the position and the reason.
    pub fn new(pattern: &str) -> Result<Self, RegexError> {
        let parsed =
            parse(pattern).map_err(|(at, reason)| RegexError { pattern: pattern.to_owned(), at, reason })?;
        let pattern_length = pattern.len();
        Ok(Self { steps: parsed.steps, saves: parsed.saves, loops: parsed.loops, pattern_length })
    }

    /// The first match.
    ///
    /// # Errors
    /// If the search was given up.
    pub fn find(&self, subject: &str, whole: bool) -> Result<Option<Groups>, TooManySteps> {
        let mut machine = Machine {
            steps: &self.steps,
            subject: subject.as_bytes(),
            slots: vec![UNSET; self.saves + self.loops],
            loops_at: self.saves,
            whole,
            steps_left: MOST_STEPS,
        };
        let last = if whole { 0 } else { subject.len() };
        for start in 0..=last {
            machine.spend(size_of_val(&*machine.slots))?;
            machine.slots.fill(UNSET);
            if machine.run(0, start)? {
                let groups = machine.slots[..self.saves].chunks_exact(2);
                let span =
                    |pair: &[usize]| (pair[0] != UNSET && pair[1] != UNSET).then_some((pair[0], pair[1]));
                return Ok(Some(groups.map(span).collect()));
            }
        }
        Ok(None)
    }

    /// `regex_search`, or `regex_match` if the `whole` subject must match: 1 or 0. The start and the end of
    /// the match and of each group go to `results`, pair by pair. A group without a match begins and ends at
    /// the end of the subject; further elements, or all without a match, get the pattern's length.
    ///
    /// # Errors
    /// The search exceeded its limit of steps.
    pub fn search(&self, subject: &str, whole: bool, results: &mut [i32]) -> Result<i32, TooManySteps> {
        let found = self.find(subject, whole)?;
        let groups = found.as_deref().unwrap_or_default();
        for (i, result) in results.iter_mut().enumerate() {
            let value = match groups.get(i / 2) {
                Some(group) => {
                    let (start, end) = group.unwrap_or((subject.len(), subject.len()));
                    if i % 2 == 0 { start } else { end }
                }
                None => self.pattern_length,
            };
            *result = value.try_into().unwrap_or(i32::MAX);
        }
        Ok(found.is_some().into())
    }
}
