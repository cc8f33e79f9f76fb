// SPDX-License-Identifier: GPL-3.0-or-later
//! Pools of threads by their number, for both APIs.
//! Invariant: after a fork the child makes its own pools, for threads of its parent are not in it; it waits
//! for no lock, because a thread of its parent may have held it. A process keeps the pools that it used last.
//! Tests: `tests/c/edits.c`.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use gnurt_accel::Threads;
use rayon::ThreadPool;

/// The largest number of threads.
const MOST: usize = 1024;

/// Limit of stored pools. Each is some sleeping threads.
const KEPT: usize = 4;

/// The pools of a process. A child of a fork finds its ancestors' in the list before its own, and never uses them.
struct Process {
    id: u32,
    /// With their numbers of threads, the most recently used first.
    pools: Mutex<Vec<(usize, Arc<ThreadPool>)>>,
    child: OnceLock<Box<Self>>,
}

static FIRST: OnceLock<Process> = OnceLock::new();

impl Process {
    fn new() -> Self {
        Self { id: std::process::id(), pools: Mutex::default(), child: OnceLock::new() }
    }

    /// The calling one.
    fn this() -> &'static Self {
        let id = std::process::id();
        let mut process = FIRST.get_or_init(Self::new);
        while process.id != id {
            process = process.child.get_or_init(|| Box::new(Self::new()));
        }
        process
    }
}

/// The threads: the calling thread, or a pool.
pub(crate) struct Workers(Option<Arc<ThreadPool>>);

impl Workers {
    /// A number of threads; 0 is one for each processor. Only the calling thread where no more can be
    /// started.
    pub(crate) fn new(threads: usize) -> Self {
        let count = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            count => count.min(MOST),
        };
        Self(if count == 1 { None } else { pool(count) })
    }

    /// The calling thread.
    pub(crate) fn single() -> Self {
        Self(None)
    }

    pub(crate) fn threads(&self) -> Threads<'_> {
        self.0.as_deref().map_or(Threads::Single, Threads::Pool)
    }
}

/// The process's pool of `count` threads.
fn pool(count: usize) -> Option<Arc<ThreadPool>> {
    let mut pools = Process::this().pools.lock().unwrap_or_else(PoisonError::into_inner);
    let found = match pools.iter().position(|(threads, _)| *threads == count) {
        Some(index) => pools.remove(index).1,
        None => {
            let name = |i| format!("gnurt-{i}");
            Arc::new(rayon::ThreadPoolBuilder::new().num_threads(count).thread_name(name).build().ok()?)
        }
    };
    pools.insert(0, (count, Arc::clone(&found)));
    // Its threads end when the last query of another thread has left it.
    let last = (pools.len() > KEPT).then(|| pools.pop());
    drop(pools);
    drop(last);
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg_attr(
        miri,
        ignore = "queues of crossbeam-epoch, which rayon uses, break the rules of Stacked Borrows"
    )]
    fn few_pools_are_kept() {
        for threads in 2..20 {
            let workers = Workers::new(threads);
            let got = workers.threads().run(|_| rayon::current_num_threads());
            assert_eq!(got, threads, "as many as were asked for");
        }
        let pools = Process::this().pools.lock().unwrap_or_else(PoisonError::into_inner);
        let retained: Vec<usize> = pools.iter().map(|(threads, _)| *threads).collect();
        assert_eq!(retained, [19, 18, 17, 16], "those that were used last");
    }
}
