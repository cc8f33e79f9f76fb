// SPDX-License-Identifier: GPL-3.0-or-later
//! Threads of a build. Invariant: the result is the same for any number of threads.

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
            Self::Pool(pool) => pool.install(|| job(true)),
        }
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
