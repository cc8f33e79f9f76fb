// SPDX-License-Identifier: GPL-3.0-or-later
//! A long list whose copies share memory: an edit copies a few values around it, and the path to them.
//! Persistent arrays, here a trie of depth three. For callers that edit one of a million elements while
//! others still read the earlier list. Cost: reading follows two pointers more than a vector; a copy takes a
//! pointer per 512 values; an edit copies 16 values and 32 pointers, once. Tests:
//! `tests::copies_share_what_was_not_edited`.

use std::ops::Index;
use std::sync::Arc;

use rayon::prelude::*;

/// Values of a leaf, and leaves of a branch: powers of two, so that indices are split by shifts.
const LEAF: usize = 16;
const BRANCH: usize = 32;
const SPAN: usize = LEAF * BRANCH;

type Leaf<T> = Arc<[T; LEAF]>;

/// A list whose copies share memory.
///
/// Between its end and the end of a leaf are unused default values.
#[derive(Clone, Debug)]
pub struct SharedList<T> {
    branches: Vec<Arc<[Leaf<T>]>>,
    len: usize,
}

impl<T> Default for SharedList<T> {
    fn default() -> Self {
        Self { branches: Vec::new(), len: 0 }
    }
}

impl<T> Index<usize> for SharedList<T> {
    type Output = T;

    #[inline]
    fn index(&self, position: usize) -> &T {
        &self.branches[position / SPAN][position / LEAF % BRANCH][position % LEAF]
    }
}

impl<T> SharedList<T> {
    /// How many values it has.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether it has no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// A value, if it is there.
    #[must_use]
    #[inline]
    pub fn get(&self, position: usize) -> Option<&T> {
        (position < self.len).then(|| &self[position])
    }

    /// All values.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        let leaves = self.branches.iter().flat_map(|branch| branch.iter());
        leaves.flat_map(|leaf| leaf.iter()).take(self.len)
    }

    /// Bytes of the values and of the path to them.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.len.div_ceil(LEAF) * (size_of::<[T; LEAF]>() + size_of::<Leaf<T>>())
            + size_of_val(&self.branches[..])
    }
}

impl<T: Send + Sync> SharedList<T> {
    /// Its values in pieces, with the index of the first one of each.
    pub fn par_pieces(&self) -> impl IndexedParallelIterator<Item = (usize, &[T])> {
        (0..self.len.div_ceil(LEAF)).into_par_iter().with_min_len(BRANCH).map(|leaf| {
            let first = leaf * LEAF;
            let values = &self.branches[leaf / BRANCH][leaf % BRANCH][..LEAF.min(self.len - first)];
            (first, values)
        })
    }
}

impl<T: Default + Clone + Send + Sync> SharedList<T> {
    /// Of `len` values; `parallel`: by the threads of the present pool.
    pub fn new(len: usize, parallel: bool, value: impl Fn(usize) -> T + Sync) -> Self {
        Self::with(len, parallel, |position| (value(position), ())).0
    }

    /// The same, with a second result for each value.
    pub fn with<U: Send>(
        len: usize,
        parallel: bool,
        value: impl Fn(usize) -> (T, U) + Sync,
    ) -> (Self, Vec<U>) {
        let branch = |number: usize| -> (Arc<[Leaf<T>]>, Vec<U>) {
            let (first, end) = (number * SPAN, len.min((number + 1) * SPAN));
            let mut along = Vec::with_capacity(end - first);
            let leaf = |first: usize| {
                Arc::new(std::array::from_fn(|i| {
                    if first + i >= end {
                        return T::default();
                    }
                    let (value, with_it) = value(first + i);
                    along.push(with_it);
                    value
                }))
            };
            ((first..end).step_by(LEAF).map(leaf).collect(), along)
        };
        let count = len.div_ceil(SPAN);
        let (branches, along): (Vec<_>, Vec<_>) = match parallel {
            true => (0..count).into_par_iter().map(branch).unzip(),
            false => (0..count).map(branch).unzip(),
        };
        (Self { branches, len }, along.into_iter().flatten().collect())
    }

    /// Makes it shorter; never longer.
    pub fn truncate(&mut self, len: usize) {
        if len >= self.len {
            return;
        }
        self.branches.truncate(len.div_ceil(SPAN));
        if !len.is_multiple_of(SPAN)
            && let Some(last) = self.branches.last_mut()
        {
            let mut leaves: Vec<Leaf<T>> = last[..(len % SPAN).div_ceil(LEAF)].to_vec();
            if !len.is_multiple_of(LEAF)
                && let Some(leaf) = leaves.last_mut()
            {
                Arc::make_mut(leaf)[len % LEAF..].fill(T::default());
            }
            *last = leaves.into();
        }
        self.len = len;
    }

    /// A value for editing; the shared nodes on the path to it are copied first.
    ///
    /// # Panics
    /// Behind the end.
    pub fn edit(&mut self, position: usize) -> &mut T {
        assert!(position < self.len, "place {position} of {}", self.len);
        let branch = Arc::make_mut(&mut self.branches[position / SPAN]);
        &mut Arc::make_mut(&mut branch[position / LEAF % BRANCH])[position % LEAF]
    }

    /// Makes it longer by default values; never shorter.
    pub fn grow(&mut self, len: usize) {
        if len <= self.len {
            return;
        }
        let leaves = len.div_ceil(LEAF);
        let nothing = |_: usize| Arc::new(std::array::from_fn(|_| T::default()));
        let whole = self.branches.pop_if(|last| last.len() < BRANCH);
        let mut more: Vec<Leaf<T>> = whole.map_or(Vec::new(), |last| last.to_vec());
        while self.branches.len() * BRANCH < leaves {
            let target_len = BRANCH.min(leaves - self.branches.len() * BRANCH);
            more.extend((more.len()..target_len).map(nothing));
            self.branches.push(std::mem::take(&mut more).into());
        }
        self.len = len;
    }

    /// Puts `value(position)` into all `positions`, which ascend; `parallel`: by the threads of the present pool.
    ///
    /// # Panics
    /// Behind the end.
    pub fn set_all(&mut self, positions: &[u32], parallel: bool, value: impl Fn(usize) -> T + Sync) {
        /// Edits that are not worth a thread.
        const FEW: usize = 64;
        if let Some(last) = positions.last() {
            assert!((*last as usize) < self.len, "place {last} of {}", self.len);
        }
        let mut edited = Vec::new();
        let mut branches = self.branches.iter_mut().enumerate();
        for run in positions.chunk_by(|&a, &b| a as usize / SPAN == b as usize / SPAN) {
            let target_len = run[0] as usize / SPAN;
            let branch = branches.find(|(number, _)| *number == target_len);
            let (_, branch) = branch.unwrap_or_else(|| panic!("places do not ascend at {}", run[0]));
            edited.push((branch, run));
        }
        let set = |(branch, run): (&mut Arc<[Leaf<T>]>, &[u32])| {
            let branch = Arc::make_mut(branch);
            for &position in run {
                let position = position as usize;
                Arc::make_mut(&mut branch[position / LEAF % BRANCH])[position % LEAF] = value(position);
            }
        };
        if parallel && positions.len() > FEW {
            edited.into_par_iter().for_each(set);
        } else {
            edited.into_iter().for_each(set);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_share_what_was_not_edited() {
        let mut list = SharedList::default();
        for len in [0, 1, 15, 16, 17, 200, 511, 512, 513, 1000, 5000] {
            list.grow(len);
            assert_eq!((list.len(), list.iter().count()), (len, len), "as long as asked");
            assert!(list.iter().all(|&x| x == 0), "and of default values");
        }
        assert_eq!((list.get(4999), list.get(5000)), (Some(&0), None), "its end");
        let mut other = SharedList::new(5000, false, |position| position);
        for len in [4999, 4000, 513, 512, 511, 17, 16, 15, 0] {
            other.truncate(len);
            assert!(other.iter().copied().eq(0..len), "{len} are left");
            let mut longer = other.clone();
            longer.grow(len + 20);
            assert!(longer.iter().skip(len).all(|&x| x == 0), "nothing comes back");
        }
        let before = list.clone();
        *list.edit(300) = 1;
        let positions: Vec<u32> = (1600..5000).filter(|position| position % 3 == 0).collect();
        list.set_all(&positions, false, |position| position);
        assert!(before.iter().all(|&x| x == 0), "a copy stays as it was");
        for (position, &x) in list.iter().enumerate() {
            let target_len = match position {
                300 => 1,
                1600.. if position % 3 == 0 => position,
                _ => 0,
            };
            assert_eq!((x, list[position]), (target_len, target_len), "at {position}");
        }
        let leaves = |list: &SharedList<usize>| -> Vec<Leaf<usize>> {
            list.branches.iter().flat_map(|branch| branch.to_vec()).collect()
        };
        let shared = leaves(&list).iter().zip(&leaves(&before)).filter(|(a, b)| Arc::ptr_eq(a, b)).count();
        assert_eq!(shared, 99, "of the first 100 leaves one was edited, and all others");
    }

    #[test]
    fn threads_do_not_show() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads start");
        for len in [0, 1, 16, 511, 10_000] {
            let list = SharedList::new(len, false, |position| position);
            let other = pool.install(|| SharedList::new(len, true, |position| position));
            assert!(list.iter().copied().eq(0..len) && other.iter().eq(list.iter()), "{len} values");
            let pieces = other.par_pieces().flat_map_iter(|(first, values)| {
                values.iter().enumerate().map(move |(i, &value)| (first + i, value))
            });
            let pieces: Vec<(usize, usize)> = pool.install(|| pieces.collect());
            assert!(pieces.into_iter().eq((0..len).map(|i| (i, i))), "pieces of {len} values");
        }
        let mut list = SharedList::new(10_000, false, |_| 0);
        let positions: Vec<u32> = (0..10_000).filter(|position| position % 7 == 2).collect();
        let mut other = list.clone();
        list.set_all(&positions, false, |position| position * 2);
        pool.install(|| other.set_all(&positions, true, |position| position * 2));
        assert!(list.iter().eq(other.iter()), "the same values");
    }

    #[test]
    #[should_panic(expected = "place 700 of 10")]
    fn indices_beyond_the_end_are_a_mistake() {
        let mut list: SharedList<u8> = SharedList::default();
        list.grow(10);
        list.set_all(&[3, 700], false, |_| 1);
    }
}
