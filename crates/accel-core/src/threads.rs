// SPDX-License-Identifier: GPL-3.0-or-later
//! Threads of a build. Invariant: the result is the same for any number of threads.
//!
//! Loops over pieces, pairs of jobs and runs on a pool go through one function each that is not generic. Otherwise the
//! library's code to share work is compiled again for each of them: it was a third of the builders' code.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// Threads of a build. The tree is the same, bit for bit, for any choice.
#[derive(Clone, Copy, Default)]
pub enum Threads<'a> {
    /// The calling thread only.
    #[default]
    Single,
    /// The threads of this pool; may be called from inside it.
    Pool(&'a rayon::ThreadPool),
}

impl Threads<'_> {
    /// Runs a job on these threads; its argument tells whether there are several.
    pub fn run<R: Send>(self, job: impl FnOnce(bool) -> R + Send) -> R {
        match self {
            Self::Single => job(false),
            Self::Pool(pool) => {
                let (mut job, mut result) = (Some(job), None);
                on_pool(pool, &mut || result = job.take().map(|job| job(true)));
                result.expect("the pool ran it")
            }
        }
    }
}

fn on_pool(pool: &rayon::ThreadPool, job: &mut (dyn FnMut() + Send)) {
    pool.install(job);
}

/// Runs two jobs, at the same time where there are threads.
pub fn both<A: Send, B: Send>(
    parallel: bool,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if !parallel {
        return (a(), b());
    }
    let (mut a, mut b, mut of_a, mut of_b) = (Some(a), Some(b), None, None);
    join(&mut || of_a = a.take().map(|a| a()), &mut || of_b = b.take().map(|b| b()));
    (of_a.expect("the first ran"), of_b.expect("the second ran"))
}

fn join(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}

/// Runs `job` with each number below `count`; several threads may take part. For jobs of a millisecond or so, not for
/// single values.
pub fn for_each(parallel: bool, count: usize, job: &(dyn Fn(usize) + Sync)) {
    if parallel && count > 1 {
        (0..count).into_par_iter().for_each(job);
    } else {
        (0..count).for_each(job);
    }
}

/// The results of such jobs, in order.
pub fn map<T: Send>(parallel: bool, count: usize, job: impl Fn(usize) -> T + Sync) -> Vec<T> {
    if !parallel || count < 2 {
        return (0..count).map(job).collect();
    }
    let mut results: Vec<Option<T>> = (0..count).map(|_| None).collect();
    let pieces = Pieces::new(&mut results, 1);
    for_each(true, count, &|i| pieces.lock(i)[0] = Some(job(i)));
    results.into_iter().map(|result| result.expect("each job ran")).collect()
}

/// As [`map`], for jobs that need something made before: each thread makes one, and uses it for all of its jobs.
pub fn map_with<S: Send, T: Send>(
    parallel: bool,
    count: usize,
    make: impl Fn() -> S + Sync,
    job: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    let spare = Mutex::new(Vec::new());
    let lock = || spare.lock().unwrap_or_else(PoisonError::into_inner);
    map(parallel, count, |i| {
        let made = lock().pop();
        let mut made = made.unwrap_or_else(&make);
        let result = job(&mut made, i);
        lock().push(made);
        result
    })
}

/// A slice in pieces, each for one of the jobs above.
pub struct Pieces<'a, T>(Vec<Mutex<&'a mut [T]>>);

impl<'a, T> Pieces<'a, T> {
    /// Pieces of `size`; the last may be shorter.
    pub fn new(all: &'a mut [T], size: usize) -> Self {
        Self(all.chunks_mut(size).map(Mutex::new).collect())
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// One of them. Each job takes its own, so that none waits.
    pub fn lock(&self, piece: usize) -> MutexGuard<'_, &'a mut [T]> {
        self.0[piece].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Appends `count` values to `all`; several threads may work on it.
pub fn extend<T: Send>(
    parallel: bool,
    all: &mut Vec<T>,
    count: usize,
    value: impl Fn(usize) -> T + Send + Sync,
) {
    if parallel {
        all.par_extend((0..count).into_par_iter().with_min_len(1024).map(value));
    } else {
        all.extend((0..count).map(value));
    }
}

/// Puts `count` pairs of values into `first` and `second`, which are empty; several threads may work on it.
pub fn extend_two<A: Send, B: Send>(
    parallel: bool,
    first: &mut Vec<A>,
    second: &mut Vec<B>,
    count: usize,
    pair: impl Fn(usize) -> (A, B) + Send + Sync,
) {
    if parallel {
        (0..count).into_par_iter().with_min_len(1024).map(pair).unzip_into_vecs(first, second);
    } else {
        for (a, b) in (0..count).map(pair) {
            first.push(a);
            second.push(b);
        }
    }
}
