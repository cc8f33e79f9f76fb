// SPDX-License-Identifier: GPL-3.0-or-later
//! Answers to many queries: one each, or lists of different lengths side by side; and threads that share the
//! work.
//! Invariant: results do not depend on the threads. Tests: `tests/surfaces/inside.rs`,
//! `tests/surfaces/overlaps.rs`.

use std::ops::Range;

use gnurt_accel_core::threads::map;

use crate::Threads;

/// Questions that a thread takes at a time.
const SHARE: usize = 128;

/// Answers `questions` one by one into `answers`, which is emptied first; each share gets a `scratch`.
pub(crate) fn answer_each<Q: Sync, A: Send, T>(
    threads: Threads,
    questions: &[Q],
    answers: &mut Vec<A>,
    scratch: impl Fn() -> T + Send + Sync,
    answer: impl Fn(&mut T, &Q) -> A + Send + Sync,
) {
    answer_shares(threads, SHARE, questions, answers, scratch, answer);
}

/// Answers questions share by share; `answer` adds one answer for each question.
pub(crate) fn answer_by_shares<Q: Sync, A: Send>(
    threads: Threads,
    questions: &[Q],
    answer: impl Fn(&[Q], &mut Vec<A>) + Send + Sync,
) -> Vec<A> {
    let mut answers = Vec::with_capacity(questions.len());
    threads.run(|parallel| {
        if !parallel {
            return answer(questions, &mut answers);
        }
        let shares: Vec<&[Q]> = questions.chunks(SHARE).collect();
        let of_share = |i: usize| {
            let mut answers = Vec::with_capacity(SHARE);
            answer(shares[i], &mut answers);
            answers
        };
        map(true, shares.len(), of_share).into_iter().for_each(|share| answers.extend(share));
    });
    answers
}

/// [`answer_each`] in shares of this size.
fn answer_shares<Q: Sync, A: Send, T>(
    threads: Threads,
    least: usize,
    questions: &[Q],
    answers: &mut Vec<A>,
    scratch: impl Fn() -> T + Send + Sync,
    answer: impl Fn(&mut T, &Q) -> A + Send + Sync,
) {
    answers.clear();
    threads.run(|parallel| {
        if !parallel {
            let mut scratch = scratch();
            answers.extend(questions.iter().map(|question| answer(&mut scratch, question)));
            return;
        }
        let shares: Vec<&[Q]> = questions.chunks(least).collect();
        let of_share = |i: usize| -> Vec<A> {
            let mut scratch = scratch();
            shares[i].iter().map(|question| answer(&mut scratch, question)).collect()
        };
        map(true, shares.len(), of_share).into_iter().for_each(|share| answers.extend(share));
    });
}

/// Lists of different lengths, one for each question, in one array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lists<T> {
    /// Where each list starts, and the end of the last.
    ends: Vec<usize>,
    items: Vec<T>,
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Self { ends: vec![0], items: Vec::new() }
    }
}

impl<T> Lists<T> {
    /// Number of lists.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len() - 1
    }

    /// Whether there are no lists.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// List `i`. Panics if `i >= len()`.
    #[must_use]
    pub fn get(&self, i: usize) -> &[T] {
        &self.items[self.range(i)]
    }

    /// Where list `i` is in [`items`](Self::items). Panics if `i >= len()`.
    #[must_use]
    pub fn range(&self, i: usize) -> Range<usize> {
        self.ends[i]..self.ends[i + 1]
    }

    /// All lists, one behind the other.
    #[must_use]
    pub fn items(&self) -> &[T] {
        &self.items
    }

    /// Each list.
    pub fn iter(&self) -> impl Iterator<Item = &[T]> {
        (0..self.len()).map(|i| self.get(i))
    }
}

impl<T: Copy + Send + Sync> Lists<T> {
    /// Fills it with lists, one for each question.
    pub(crate) fn answer_each<Q: Sync>(
        &mut self,
        threads: Threads,
        questions: &[Q],
        answer: impl Fn(&Q, &mut Vec<T>) + Send + Sync,
    ) {
        let mut shares: Vec<(Vec<usize>, Vec<T>)> = Vec::new();
        let chunks: Vec<&[Q]> = questions.chunks(SHARE).collect();
        let one = |list: &mut Vec<T>, chunk: &&[Q]| {
            let (mut lengths, mut items) = (Vec::with_capacity(chunk.len()), Vec::new());
            for question in *chunk {
                answer(question, list);
                lengths.push(list.len());
                items.extend_from_slice(list);
            }
            (lengths, items)
        };
        answer_shares(threads, 1, &chunks, &mut shares, Vec::new, one);
        self.ends.clear();
        self.ends.push(0);
        self.items.clear();
        for (lengths, items) in shares {
            let mut end = self.items.len();
            self.ends.extend(lengths.into_iter().map(|length| {
                end += length;
                end
            }));
            self.items.extend(items);
        }
    }
}
