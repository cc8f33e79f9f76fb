// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of the objects of a scene, those of nested scenes too, in the order of the instances on the path
//! to them. An instance of an object takes one number, and so does an absent one; an instance of a scene
//! takes one for each of its objects. If no instance shows a scene, an object's number is its instance's
//! index, and nothing is stored.
//! Tests: `tests`, `tests/nested.rs`.

use std::sync::Arc;

/// Where the numbers of each instance begin.
#[derive(Clone, Debug, Default)]
pub(super) struct Leaves {
    /// By instance; empty where each has one number.
    firsts: Arc<Vec<u32>>,
    count: u32,
}

impl Leaves {
    /// Of instances with these numbers of objects, less than 2^32 in all.
    pub(super) fn new(counts: impl ExactSizeIterator<Item = u32> + Clone) -> Self {
        if counts.clone().all(|count| count == 1) {
            return Self { firsts: Arc::default(), count: counts.len() as u32 };
        }
        let mut next = 0;
        let first = |count: u32| {
            next += count;
            next - count
        };
        Self { firsts: Arc::new(counts.map(first).collect()), count: next }
    }

    /// With other numbers of objects at some indices, which ascend, of `len` in all.
    pub(super) fn updated(&self, before: usize, len: usize, changed: &[(u32, u32)]) -> Self {
        let end = before.min(len);
        let is_as_before = |&(index, count): &(u32, u32)| match (index as usize) < end {
            true => self.of(index as usize) == count,
            false => self.firsts.is_empty() && count == 1,
        };
        if changed.iter().all(is_as_before) && (before == len || self.firsts.is_empty()) {
            let count = if self.firsts.is_empty() { len as u32 } else { self.count };
            return Self { firsts: self.firsts.clone(), count };
        }
        let mut counts: Vec<u32> = (0..end).map(|index| self.of(index)).collect();
        counts.resize(len, 1);
        for &(index, count) in changed {
            counts[index as usize] = count;
        }
        Self::new(counts.into_iter())
    }

    /// How many objects there are.
    pub(super) fn count(&self) -> u32 {
        self.count
    }

    /// How many objects an instance shows.
    fn of(&self, index: usize) -> u32 {
        match self.firsts.get(index) {
            Some(first) => self.firsts.get(index + 1).unwrap_or(&self.count) - first,
            None => 1,
        }
    }

    /// The first number of an instance.
    #[inline]
    pub(super) fn first(&self, index: usize) -> u32 {
        if self.firsts.is_empty() { index as u32 } else { self.firsts[index] }
    }

    /// The instance that has a number, which is below `count`.
    #[inline]
    pub(super) fn index(&self, leaf: u32) -> usize {
        if self.firsts.is_empty() {
            return leaf as usize;
        }
        self.firsts.partition_point(|&first| first <= leaf) - 1
    }

    /// Whether instances have the same numbers here and there, as far as both have them.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.firsts, &other.firsts) || self.firsts == other.firsts
    }

    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&self.firsts[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against a list of the owner of each number.
    fn check(leaves: &Leaves, counts: &[u32]) {
        let owners: Vec<usize> =
            counts.iter().enumerate().flat_map(|(index, &count)| vec![index; count as usize]).collect();
        assert_eq!(leaves.count() as usize, owners.len(), "{counts:?}");
        for (leaf, owner) in owners.iter().enumerate() {
            assert_eq!(leaves.index(leaf as u32), *owner, "number {leaf} of {counts:?}");
        }
        for (index, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let first = owners.iter().position(|owner| *owner == index);
            assert_eq!(Some(leaves.first(index) as usize), first, "instance {index} of {count}");
        }
    }

    #[test]
    fn numbers_follow_the_instances() {
        for counts in [&[][..], &[1, 1, 1], &[3], &[0, 2, 0, 0, 1, 5, 0], &[1, 0]] {
            check(&Leaves::new(counts.iter().copied()), counts);
        }
    }

    #[test]
    fn updates_equal_new_ones() {
        let mut random = gnurt_testkit::Random::new(1);
        let (mut counts, mut leaves) = (Vec::new(), Leaves::default());
        for step in 0..500 {
            let before = counts.len();
            let len = if step % 5 == 0 { random.pick(&[0, 3, 8, 12]) } else { before };
            counts.resize(len, 1);
            let nested = step % 50 < 25;
            let edits = (0..len as u32).filter(|_| random.unit() < 0.3).collect::<Vec<_>>();
            let edits: Vec<(u32, u32)> = edits
                .into_iter()
                .map(|index| (index, if nested { random.pick(&[0, 1, 1, 4]) } else { 1 }))
                .collect();
            edits.iter().for_each(|&(index, count)| counts[index as usize] = count);
            leaves = leaves.updated(before, len, &edits);
            check(&leaves, &counts);
        }
    }
}
