// SPDX-License-Identifier: GPL-3.0-or-later
//! Threads that reading a file may use: a number that the caller sets. They live as long as a call.
//! A job that gets fewer threads than requested, because the system has no more, does the same. Tests: `tests`.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::{Builder, available_parallelism, scope};

/// The number of cores. The system reads files to tell it, which takes as long as reading a small mesh.
static CORES: OnceLock<usize> = OnceLock::new();

/// The number of threads for a request, where 0 is one for each core.
pub(crate) fn count(requested: usize) -> usize {
    match requested {
        0 => *CORES.get_or_init(|| available_parallelism().map_or(1, usize::from)),
        some => some,
    }
}

/// Calls a job once for each number below `count`, in any order, on at most this many threads, the calling one included.
pub(crate) fn for_each(threads: usize, count: usize, job: &(dyn Fn(usize) + Sync)) {
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                break;
            }
            job(number);
        }
    };
    beside(threads.min(count), &work, work);
}

/// Fills a list from another one of the same length, piece by piece: `job` is called with pieces that belong together.
pub fn fill<A: Send, B: Sync>(
    threads: usize,
    to: &mut [A],
    from: &[B],
    job: &(dyn Fn(&mut [A], &[B]) + Sync),
) {
    /// Bytes that are worth a thread, about.
    const PIECE: usize = 1 << 19;
    let pieces = (size_of_val(to) / PIECE).clamp(1, threads);
    if pieces == 1 {
        return job(to, from);
    }
    let size = from.len().div_ceil(pieces).max(1);
    let pairs = to.chunks_mut(size).zip(from.chunks(size));
    let pairs: Vec<Mutex<(&mut [A], &[B])>> = pairs.map(Mutex::new).collect();
    for_each(threads, pairs.len(), &|i| {
        let (to, from) = &mut *pairs[i].lock().unwrap_or_else(PoisonError::into_inner);
        job(to, from);
    });
}

/// Runs `work` on the calling thread, and `helper` on up to `threads - 1` others.
pub(crate) fn beside<R>(threads: usize, helper: &(dyn Fn() + Sync), work: impl FnOnce() -> R) -> R {
    scope(|scope| {
        for _ in 1..threads {
            if Builder::new().name("gnurt read".into()).spawn_scoped(scope, helper).is_err() {
                break;
            }
        }
        work()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_is_called_once() {
        for threads in [1, 2, 7] {
            for size in [0, 1, 5, 1000] {
                let calls: Vec<AtomicUsize> = (0..size).map(|_| AtomicUsize::new(0)).collect();
                for_each(threads, size, &|number| {
                    calls[number].fetch_add(1, Ordering::Relaxed);
                });
                assert!(calls.iter().all(|calls| calls.load(Ordering::Relaxed) == 1), "{threads} of {size}");
            }
        }
        let seen = Mutex::new(std::collections::HashSet::new());
        for_each(3, 1000, &|_| {
            seen.lock().unwrap_or_else(PoisonError::into_inner).insert(std::thread::current().id());
        });
        let seen = seen.into_inner().unwrap_or_else(PoisonError::into_inner).len();
        assert!((1..=3).contains(&seen), "{seen} threads");
        let from: Vec<u32> = (0..1_000_003).collect();
        let mut to = vec![0; from.len()];
        fill(3, &mut to, &from, &|to, from| to.iter_mut().zip(from).for_each(|(to, from)| *to = from + 1));
        assert!(to.iter().zip(&from).all(|(to, from)| *to == from + 1), "each from its own");
        assert_eq!(count(3), 3);
        assert!(count(0) > 0);
    }
}
