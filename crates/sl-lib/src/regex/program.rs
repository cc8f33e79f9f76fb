// SPDX-License-Identifier: GPL-3.0-or-later
//! The compiled form of a regular expression: steps for a backtracking machine.
//! Source: after Cox's "Regular Expression Matching: the Virtual Machine Approach".
//! Tests: `tests/regex.rs`.

/// A set of bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Set([u64; 4]);

impl Set {
    pub(super) fn of(bytes: impl IntoIterator<Item = u8>) -> Self {
        let mut set = Self::default();
        bytes.into_iter().for_each(|byte| set.add(byte));
        set
    }

    pub(super) fn add(&mut self, byte: u8) {
        self.0[usize::from(byte >> 6)] |= 1 << (byte & 63);
    }

    pub(super) fn join(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a |= b);
    }

    pub(super) fn inverse(self) -> Self {
        Self(self.0.map(|bits| !bits))
    }

    pub(super) fn has(&self, byte: u8) -> bool {
        self.0[usize::from(byte >> 6)] >> (byte & 63) & 1 == 1
    }
}

/// Letters, digits and the underscore.
pub(super) fn is_word_byte(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// One step. Targets are indices of steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// One byte of a set.
    One(Set),
    /// The first target, and the second one if that fails.
    Either(usize, usize),
    /// Another target.
    Jump(usize),
    /// Where a group begins or ends.
    Save(usize),
    /// The start of the subject.
    Start,
    /// Its end.
    End,
    /// Between a letter and none, or, if not, elsewhere.
    Boundary(bool),
    /// The contents of a group again.
    Again(usize),
    /// Tests whether the steps up to the next `Captured` of this level match, or do not; then continues at
    /// `then`.
    Lookahead { expected: bool, then: usize },
    /// The end of a lookaround.
    Captured,
    /// Records where an iteration of a loop begins.
    Loop(usize),
    /// Fails if that iteration matched nothing.
    Moved(usize),
    /// All is found.
    Found,
}
