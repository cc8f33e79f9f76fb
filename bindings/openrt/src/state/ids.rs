// SPDX-License-Identifier: GPL-3.0-or-later
//! Ids that programs reserve: consecutive, from 1; a removed one is used again when there are no others.
//! Invariant: an id exists if it was generated and not removed since; neither 0 nor `RT_INVALID` nor
//! an id of the forbidden range is ever generated. Memory grows with the gaps between ids that exist, not with the ids
//! that were ever reserved or removed.
//! Tests: `tests`.

use std::collections::BTreeMap;
use std::ops::Range;

use super::error::{Error, Result};

/// The result of id-returning calls on failure.
pub(crate) const RT_INVALID: u32 = u32::MAX;

/// A supply of ids.
#[derive(Clone, Debug)]
pub(crate) struct Ids {
    /// The next id to give out.
    next: u32,
    /// Ids below `next` that were skipped.
    skipped: Range<u32>,
    /// Removed ids: where each run of them begins, and where it ends, exclusive. Runs do not touch.
    removed: BTreeMap<u32, u32>,
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
        Self { next: 1, skipped: 0..0, removed: BTreeMap::new(), forbidden }
    }

    /// Reserves `count` consecutive ids and returns the first. Removed ones are only used again if `is_free`
    /// allows it.
    pub(crate) fn reserve(&mut self, count: i32, is_free: impl Fn(u32) -> bool) -> Result<u32> {
        let count = u32::try_from(count).ok().filter(|&n| n > 0).ok_or(Error::InvalidValue)?;
        let ends_before = |first: u32, end: u32| first.checked_add(count).is_some_and(|last| last <= end);
        let must_skip = self.next < self.forbidden.end && !ends_before(self.next, self.forbidden.start);
        let first = if must_skip { self.forbidden.end } else { self.next };
        if !ends_before(first, RT_INVALID) {
            return self.reserve_again(count, is_free).ok_or(Error::OutOfMemory);
        }
        if must_skip {
            self.skipped = self.next..first;
        }
        self.next = first + count;
        Ok(first)
    }

    /// Reserves ids that were removed.
    fn reserve_again(&mut self, count: u32, is_free: impl Fn(u32) -> bool) -> Option<u32> {
        let (run, first) = self.removed.iter().find_map(|(&start, &end)| {
            let mut first = start;
            let last = (start..end).find(|&id| {
                first = if is_free(id) { first } else { id + 1 };
                id + 1 - first == count
            });
            last.map(|_| (start..end, first))
        })?;
        self.removed.remove(&run.start);
        for rest in [run.start..first, first + count..run.end] {
            if !rest.is_empty() {
                self.removed.insert(rest.start, rest.end);
            }
        }
        Some(first)
    }

    /// Whether `id` was generated and not removed.
    #[must_use]
    pub(crate) fn exists(&self, id: u32) -> bool {
        let is_removed = || self.removed.range(..=id).next_back().is_some_and(|(_, &end)| id < end);
        (1..self.next).contains(&id) && !self.skipped.contains(&id) && !is_removed()
    }

    /// The id itself if it exists; [`Error::InvalidValue`] if not.
    pub(crate) fn check(&self, id: u32) -> Result<u32> {
        if self.exists(id) { Ok(id) } else { Err(Error::InvalidValue) }
    }

    /// Removes an id.
    pub(crate) fn remove(&mut self, id: u32) -> Result<()> {
        self.check(id)?;
        // With the runs that it touches it becomes one.
        let before = self.removed.range(..id).next_back().filter(|(_, end)| **end == id);
        let start = before.map_or(id, |(&start, _)| start);
        let end = self.removed.remove(&(id + 1)).unwrap_or(id + 1);
        self.removed.insert(start, end);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(_: u32) -> bool {
        true
    }

    #[test]
    fn ids_are_consecutive_and_come_back_late() {
        let mut ids = Ids::default();
        assert_eq!(ids.reserve(3, free), Ok(1), "from 1");
        assert_eq!(ids.reserve(1, free), Ok(4), "after the three");
        assert_eq!(ids.remove(2), Ok(()), "it exists");
        assert_eq!(ids.remove(2), Err(Error::InvalidValue), "only once");
        assert_eq!(ids.reserve(1, free), Ok(5), "2 does not come back while there are others");
        assert!(!ids.exists(0) && !ids.exists(2) && !ids.exists(6) && ids.exists(5), "who exists");
    }

    #[test]
    fn wrong_counts_and_exhaustion() {
        let mut ids = Ids::default();
        assert_eq!(ids.reserve(0, free), Err(Error::InvalidValue), "none");
        assert_eq!(ids.reserve(-1, free), Err(Error::InvalidValue), "fewer than none");
        assert_eq!(ids.reserve(i32::MAX, free), Ok(1), "very many take no memory");
        assert_eq!(ids.reserve(i32::MAX, free), Ok(0x8000_0000), "once more");
        assert_eq!(ids.reserve(i32::MAX, free), Err(Error::OutOfMemory), "then there are too few");
        assert!(!ids.exists(RT_INVALID), "RT_INVALID is no id");
    }

    #[test]
    fn forbidden_ids_are_skipped() {
        let mut ids = Ids::without(4..8);
        assert_eq!(ids.reserve(2, free), Ok(1), "before the range");
        assert_eq!(ids.reserve(2, free), Ok(8), "would reach into it");
        assert!(!ids.exists(3) && !ids.exists(5) && ids.exists(9), "what was skipped does not exist");
    }

    #[test]
    fn removed_ids_come_back_last_and_take_no_memory() {
        let mut ids = Ids::without(4..8);
        let rounds = if cfg!(miri) { 20 } else { 1000 };
        for _ in 0..rounds {
            let first = ids.reserve(3, free).expect("there are many");
            [1, 0, 2].iter().for_each(|k| ids.remove(first + k).expect("it exists"));
        }
        // The forbidden ones are between.
        assert_eq!(ids.removed.len(), 2, "runs of removed ids");
        // In fast motion: as if all ids had been used.
        let retained = ids.next;
        ids.next = RT_INVALID;
        assert_eq!(ids.reserve(2, |id| id != 1), Ok(2), "1 is still shown");
        assert!(ids.exists(2) && ids.exists(3) && !ids.exists(1), "they are there again");
        assert_eq!(ids.reserve(2, free), Ok(8), "two in a row");
        assert_eq!(ids.reserve(1, free), Ok(1), "what is left before");
        assert_eq!(ids.remove(2), Ok(()), "as ever");
        assert_eq!(ids.reserve(1, free), Ok(2), "and back");
        assert_eq!(ids.reserve(i32::MAX, free), Err(Error::OutOfMemory), "not so many in a row");
        assert!(ids.exists(retained), "nothing else has changed");
    }
}
