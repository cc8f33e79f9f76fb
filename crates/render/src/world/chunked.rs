// SPDX-License-Identifier: GPL-3.0-or-later
//! A long array whose copies share what they have in common: after an edit only the chunk around it is copied.
//! Source: original (persistent arrays of depth two). A world of a million instances is copied by each commit, because
//! frames in flight keep the one before.
//! Cost: reading follows one pointer more than a vector; a copy is one per chunk; an edit copies a chunk.
//! Proof: `tests::copies_share_what_was_not_edited`.

use std::ops::Index;
use std::sync::Arc;

use rayon::prelude::*;

/// Values per chunk; a power of two, so that places are split by shifts.
const CHUNK: usize = 256;

/// The array. All chunks but the last one are full.
#[derive(Clone)]
pub(crate) struct Chunked<T> {
    chunks: Vec<Arc<[T]>>,
    len: usize,
}

impl<T> Default for Chunked<T> {
    fn default() -> Self {
        Self { chunks: Vec::new(), len: 0 }
    }
}

impl<T> Index<usize> for Chunked<T> {
    type Output = T;

    #[inline]
    fn index(&self, place: usize) -> &T {
        &self.chunks[place / CHUNK][place % CHUNK]
    }
}

impl<T> Chunked<T> {
    #[inline]
    pub(crate) fn get(&self, place: usize) -> Option<&T> {
        self.chunks.get(place / CHUNK)?.get(place % CHUNK)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.chunks.iter().flat_map(|chunk| chunk.iter())
    }

    /// Its chunks, and the place of the first value of each.
    pub(crate) fn par_chunks(&self) -> impl IndexedParallelIterator<Item = (usize, &[T])>
    where
        T: Send + Sync,
    {
        self.chunks.par_iter().enumerate().map(|(number, chunk)| (number * CHUNK, &**chunk))
    }
}

impl<T: Clone> Chunked<T> {
    /// A value, to be changed; its chunk is copied first if somebody else has it, too.
    pub(crate) fn edit(&mut self, place: usize) -> &mut T {
        &mut Arc::make_mut(&mut self.chunks[place / CHUNK])[place % CHUNK]
    }

    /// Makes it longer by copies of a value; never shorter.
    pub(crate) fn grow(&mut self, len: usize, value: &T) {
        if len <= self.len {
            return;
        }
        let whole = self.len / CHUNK;
        let mut rest: Vec<T> = self.chunks.drain(whole..).flat_map(|chunk| chunk.to_vec()).collect();
        while self.chunks.len() < len.div_ceil(CHUNK) {
            rest.resize(CHUNK.min(len - self.chunks.len() * CHUNK), value.clone());
            self.chunks.push(std::mem::take(&mut rest).into());
        }
        self.len = len;
    }
}

impl<T: Clone + Send + Sync> Chunked<T> {
    /// Puts `value(place)` into all `places`, which ascend; on the threads of the present pool where they are many.
    pub(crate) fn set_all(&mut self, places: &[u32], value: impl Fn(usize) -> T + Sync) {
        /// Chunks that are not worth a thread.
        const FEW: usize = 8;
        let mut runs = places.chunk_by(|&a, &b| a as usize / CHUNK == b as usize / CHUNK).peekable();
        let mut due = Vec::new();
        for (number, chunk) in self.chunks.iter_mut().enumerate() {
            if let Some(run) = runs.next_if(|run| run[0] as usize / CHUNK == number) {
                due.push((chunk, run));
            }
            if runs.peek().is_none() {
                break;
            }
        }
        assert!(runs.peek().is_none(), "place {:?} of {}", runs.peek(), self.len);
        let set = |(chunk, run): (&mut Arc<[T]>, &[u32])| {
            let chunk = Arc::make_mut(chunk);
            run.iter().for_each(|&place| chunk[place as usize % CHUNK] = value(place as usize));
        };
        if due.len() > FEW && rayon::current_thread_index().is_some() {
            due.into_par_iter().for_each(set);
        } else {
            due.into_iter().for_each(set);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_share_what_was_not_edited() {
        let mut array = Chunked::default();
        for len in [0, 1, 200, 256, 257, 1000, 5000] {
            array.grow(len, &7);
            assert_eq!((array.len, array.iter().count()), (len, len), "as long as asked");
            assert!(array.iter().all(|&x| x == 7), "and full");
        }
        assert_eq!((array.get(4999), array.get(5000)), (Some(&7), None), "its end");
        let before = array.clone();
        *array.edit(300) = 1;
        let places: Vec<u32> = (1000..5000).filter(|place| place % 3 == 0).collect();
        array.set_all(&places, |place| place);
        assert!(before.iter().all(|&x| x == 7), "a copy stays as it was");
        for (place, &x) in array.iter().enumerate() {
            let wanted = if place == 300 {
                1
            } else if place >= 1000 && place % 3 == 0 {
                place
            } else {
                7
            };
            assert_eq!((x, array[place]), (wanted, wanted), "at {place}");
        }
        let shared = array.chunks.iter().zip(&before.chunks).filter(|(a, b)| Arc::ptr_eq(a, b)).count();
        assert_eq!(shared, 2, "of 20 chunks the first and the third were not edited");
    }

    #[test]
    fn threads_do_not_show() {
        let mut array = Chunked::default();
        array.grow(10_000, &0);
        let places: Vec<u32> = (0..10_000).filter(|place| place % 7 == 2).collect();
        let mut other = array.clone();
        array.set_all(&places, |place| place * 2);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads start");
        pool.install(|| other.set_all(&places, |place| place * 2));
        assert!(array.iter().eq(other.iter()), "the same values");
    }

    #[test]
    #[should_panic(expected = "of 10")]
    fn places_beyond_the_end_are_a_mistake() {
        let mut array = Chunked::default();
        array.grow(10, &0);
        array.set_all(&[3, 700], |place| place);
    }
}
