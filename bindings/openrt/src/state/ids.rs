// SPDX-License-Identifier: GPL-3.0-or-later
//! Ids that programs reserve: consecutive, from 1, never used twice.
//! Source: original. Invariant: an id exists if it was generated and not removed since; neither 0 nor `RT_INVALID` nor
//! an id of the forbidden range is ever generated. Memory grows with removals, not with the ids reserved.
//! Proof: `tests`.

use std::collections::BTreeSet;
use std::ops::Range;

use super::error::{Error, Result};

/// What id-returning calls give when they fail.
pub(crate) const RT_INVALID: u32 = u32::MAX;

/// A supply of ids.
#[derive(Clone, Debug)]
pub(crate) struct Ids {
    /// The next id to give out.
    next: u32,
    /// Ids below `next` that were skipped.
    skipped: Range<u32>,
    removed: BTreeSet<u32>,
    /// Ids that must not be given out.
    forbidden: Range<u32>,
}

impl Default for Ids {
    fn default() -> Self {
        Self::without(0..0)
    }
}

impl Ids {
    /// A supply that never gives out ids of `forbidden`.
    #[must_use]
    pub(crate) fn without(forbidden: Range<u32>) -> Self {
        Self { next: 1, skipped: 0..0, removed: BTreeSet::new(), forbidden }
    }

    /// Reserves `count` consecutive ids and returns the first.
    pub(crate) fn reserve(&mut self, count: i32) -> Result<u32> {
        let count = u32::try_from(count).ok().filter(|&n| n > 0).ok_or(Error::InvalidValue)?;
        let ends_before = |first: u32, end: u32| first.checked_add(count).is_some_and(|last| last <= end);
        let must_skip = self.next < self.forbidden.end && !ends_before(self.next, self.forbidden.start);
        let first = if must_skip { self.forbidden.end } else { self.next };
        if !ends_before(first, RT_INVALID) {
            return Err(Error::OutOfMemory);
        }
        if must_skip {
            self.skipped = self.next..first;
        }
        self.next = first + count;
        Ok(first)
    }

    /// Whether `id` was generated and not removed.
    #[must_use]
    pub(crate) fn exists(&self, id: u32) -> bool {
        (1..self.next).contains(&id) && !self.skipped.contains(&id) && !self.removed.contains(&id)
    }

    /// The id itself if it exists; [`Error::InvalidValue`] if not.
    pub(crate) fn check(&self, id: u32) -> Result<u32> {
        if self.exists(id) { Ok(id) } else { Err(Error::InvalidValue) }
    }

    /// Removes an id; it will not come back.
    pub(crate) fn remove(&mut self, id: u32) -> Result<()> {
        self.check(id)?;
        self.removed.insert(id);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_consecutive_and_never_come_back() {
        let mut ids = Ids::default();
        assert_eq!(ids.reserve(3), Ok(1), "from 1");
        assert_eq!(ids.reserve(1), Ok(4), "after the three");
        assert_eq!(ids.remove(2), Ok(()), "it exists");
        assert_eq!(ids.remove(2), Err(Error::InvalidValue), "only once");
        assert_eq!(ids.reserve(1), Ok(5), "2 does not come back");
        assert!(!ids.exists(0) && !ids.exists(2) && !ids.exists(6) && ids.exists(5), "who exists");
    }

    #[test]
    fn wrong_counts_and_exhaustion() {
        let mut ids = Ids::default();
        assert_eq!(ids.reserve(0), Err(Error::InvalidValue), "none");
        assert_eq!(ids.reserve(-1), Err(Error::InvalidValue), "fewer than none");
        assert_eq!(ids.reserve(i32::MAX), Ok(1), "very many take no memory");
        assert_eq!(ids.reserve(i32::MAX), Ok(0x8000_0000), "once more");
        assert_eq!(ids.reserve(i32::MAX), Err(Error::OutOfMemory), "then there are too few");
        assert!(!ids.exists(RT_INVALID), "RT_INVALID is no id");
    }

    #[test]
    fn forbidden_ids_are_skipped() {
        let mut ids = Ids::without(4..8);
        assert_eq!(ids.reserve(2), Ok(1), "before the range");
        assert_eq!(ids.reserve(2), Ok(8), "would reach into it");
        assert!(!ids.exists(3) && !ids.exists(5) && ids.exists(9), "what was skipped does not exist");
    }
}
