// SPDX-License-Identifier: GPL-3.0-or-later
//! Instances: objects put somewhere, and their ids.
//! Source: \[DWBS03\]; two levels after the paper's section 6. Space: an instance's matrix goes from object to world.
//! Invariant: ids never run out while fewer than 2^32 - 2 instances are there. Tests: `tests`; tests/c/scene.c.

use std::collections::{BTreeMap, BTreeSet};

use super::error::{Error, Result};
use super::ids::RT_INVALID;
use super::matrix::Matrix;

/// An object put somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Instance {
    /// The object's id.
    pub(crate) object: u32,
    /// Where it is put.
    pub(crate) world_from_object: Matrix,
    /// Which kinds of rays see it, as bits.
    pub(crate) mask: u32,
}

/// Ids that instances may have; beyond them is `RT_INVALID`.
const FIRST: u32 = 1;
const LAST: u32 = RT_INVALID - 1;
/// The size of the range of ids.
const MOST: usize = (LAST - FIRST + 1) as usize;

/// All instances. Ids are given out in a circle, so that a removed one is used again as late as possible.
#[derive(Clone, Debug, Default)]
pub(crate) struct Instances {
    last_id: u32,
    all: BTreeMap<u32, Instance>,
    /// How many show each object.
    of_objects: BTreeMap<u32, usize>,
    changes: Changes,
}

/// The changes since the last frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Changes {
    /// Whether any may have changed.
    pub(crate) any: bool,
    /// Else the ids of those that came, moved or went.
    pub(crate) ids: BTreeSet<u32>,
}

impl Instances {
    /// All of them, in the order of their ids.
    #[cfg(test)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Instance> {
        self.all.values()
    }

    /// All of them with their ids, in that order.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (u32, &Instance)> {
        self.all.iter().map(|(&id, instance)| (id, instance))
    }

    /// How many there are.
    #[must_use]
    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// Adds one and returns its id: the next free one after the last.
    pub(crate) fn add(&mut self, instance: Instance) -> Result<u32> {
        if self.all.len() >= MOST {
            return Err(Error::OutOfMemory);
        }
        let after = |id: u32| if id < LAST { id + 1 } else { FIRST };
        let mut id = after(self.last_id);
        // Passed over once per round through all ids, each: next to nothing per instance.
        while self.all.contains_key(&id) {
            id = after(id);
        }
        self.last_id = id;
        self.all.insert(id, instance);
        *self.of_objects.entry(instance.object).or_default() += 1;
        self.changes.note(id);
        Ok(id)
    }

    /// The instance of an id.
    #[must_use]
    pub(crate) fn get(&self, id: u32) -> Option<&Instance> {
        self.all.get(&id)
    }

    /// Whether any shows an object.
    #[must_use]
    pub(crate) fn show(&self, object: u32) -> bool {
        self.of_objects.contains_key(&object)
    }

    /// The instance of an id, to be moved; it still shows its object.
    pub(crate) fn get_mut(&mut self, id: u32) -> Option<&mut Instance> {
        let found = self.all.get_mut(&id);
        if found.is_some() {
            self.changes.note(id);
        }
        found
    }

    /// Removes one; returns whether it existed.
    pub(crate) fn remove(&mut self, id: u32) -> bool {
        let Some(gone) = self.all.remove(&id) else { return false };
        self.changes.note(id);
        if let Some(count) = self.of_objects.get_mut(&gone.object) {
            *count -= 1;
            if *count == 0 {
                self.of_objects.remove(&gone.object);
            }
        }
        true
    }

    /// Removes all.
    pub(crate) fn clear(&mut self) {
        self.all.clear();
        self.of_objects.clear();
        self.changes = Changes { any: true, ids: BTreeSet::new() };
    }

    /// The changes since the last call.
    pub(crate) fn take_changes(&mut self) -> Changes {
        std::mem::take(&mut self.changes)
    }
}

impl Changes {
    fn note(&mut self, id: u32) {
        // A full pass needs no list.
        if !self.any {
            self.ids.insert(id);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const THERE: Instance = Instance { object: 1, world_from_object: Matrix::IDENTITY, mask: u32::MAX };

    #[test]
    fn ids_come_back_after_the_last_one() {
        let mut instances = Instances::default();
        assert_eq!([1, 2, 3].map(|_| instances.add(THERE)), [1, 2, 3].map(Ok), "from 1");
        assert!(instances.remove(2), "it was there");
        assert_eq!(instances.add(THERE), Ok(4), "2 does not come back at once");
        // In fast motion: as if 2^32 frames had passed.
        instances.last_id = LAST - 1;
        assert_eq!(instances.add(THERE), Ok(LAST), "the last one is not RT_INVALID");
        assert_eq!(instances.add(THERE), Ok(2), "1 is in use");
        assert_eq!(instances.add(THERE), Ok(5), "3 and 4 are, too");
        instances.clear();
        assert_eq!(instances.add(THERE), Ok(6), "empty, and going on");
    }

    #[test]
    fn frames_for_ever() {
        let count = if cfg!(miri) { 20 } else { 1000 };
        let mut instances = Instances { last_id: LAST - 3 * count / 2, ..Instances::default() };
        for frame in 0..10 {
            (0..count).for_each(|i| assert!(instances.add(THERE).is_ok(), "instance {i} of frame {frame}"));
            assert_eq!(instances.len(), count as usize, "as many as the frame has");
            instances.clear();
        }
    }
}
