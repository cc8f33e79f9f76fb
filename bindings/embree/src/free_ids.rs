// SPDX-License-Identifier: GPL-3.0-or-later
//! Free ids: the lowest is found at once, however many are taken.
//! Invariant: ranges neither meet nor touch. Tests: `tests`.

use std::collections::BTreeMap;

/// The greatest id that there is.
const LAST: u32 = u32::MAX - 1;

/// Ranges of free ids: the last of each by its first.
#[derive(Debug)]
pub(crate) struct FreeIds(BTreeMap<u32, u32>);

impl Default for FreeIds {
    /// All are free.
    fn default() -> Self {
        Self(BTreeMap::from([(0, LAST)]))
    }
}

impl FreeIds {
    /// The lowest.
    pub(crate) fn lowest(&self) -> Option<u32> {
        self.0.keys().next().copied()
    }

    /// Takes a free id; a taken one stays taken.
    pub(crate) fn take(&mut self, id: u32) {
        let Some((&first, &last)) = self.0.range(..=id).next_back().filter(|(_, last)| **last >= id) else {
            return;
        };
        self.0.remove(&first);
        if first < id {
            self.0.insert(first, id - 1);
        }
        if id < last {
            self.0.insert(id + 1, last);
        }
    }

    /// Gives back an id that was taken.
    pub(crate) fn give(&mut self, id: u32) {
        let before = self.0.range(..id).next_back().filter(|(_, last)| **last + 1 == id);
        let first = before.map_or(id, |(&first, _)| first);
        let last = self.0.remove(&(id + 1)).unwrap_or(id);
        self.0.insert(first, last);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_lowest_id_is_that_of_a_list() {
        let (mut free, mut taken, mut state) = (FreeIds::default(), BTreeSet::new(), 1u64);
        // Miri takes an hour for 4000 steps.
        let steps = if cfg!(miri) { 150 } else { 4000 };
        for step in 0..steps {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let id = (state >> 59) as u32;
            match state >> 40 & 3 {
                0 if taken.contains(&id) => {
                    free.give(id);
                    taken.remove(&id);
                }
                0 | 1 => {
                    free.take(id);
                    taken.insert(id);
                }
                _ => {
                    let lowest = free.lowest().expect("there are many");
                    free.take(lowest);
                    taken.insert(lowest);
                }
            }
            let lowest = (0..).find(|id| !taken.contains(id));
            assert_eq!(free.lowest(), lowest, "step {step}: {taken:?}");
        }
    }

    #[test]
    fn there_is_a_last_id() {
        let mut free = FreeIds::default();
        free.take(LAST);
        free.give(LAST);
        assert_eq!(free.0.len(), 1, "in one piece again");
        free.0 = BTreeMap::from([(LAST, LAST)]);
        free.take(LAST);
        assert_eq!(free.lowest(), None, "none is left");
    }
}
