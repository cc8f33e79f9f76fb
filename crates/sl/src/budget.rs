// SPDX-License-Identifier: GPL-3.0-or-later
//! Work that an input may cause, counted before it is done.
//! Tests: `tests/hostile.rs`.

/// What is left of some work.
#[derive(Clone, Debug)]
pub struct Budget {
    left: u64,
    most: u64,
    /// The work, and its unit: "macros make more than {} tokens".
    what: [&'static str; 2],
}

impl Budget {
    /// So much work; the text before and after the number.
    #[must_use]
    pub const fn new(most: u64, what: [&'static str; 2]) -> Self {
        Self { left: most, most, what }
    }

    /// Takes some; none if so much is not left, and then nothing is left.
    pub fn spend(&mut self, work: usize) -> Option<()> {
        let rest = self.left.checked_sub(work as u64);
        self.left = rest.unwrap_or(0);
        rest.map(|_| ())
    }

    /// Whether all was spent.
    #[must_use]
    pub const fn is_spent(&self) -> bool {
        self.left == 0
    }
}

impl std::fmt::Display for Budget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [before, after] = self.what;
        write!(f, "{before} {} {after}", self.most)
    }
}
