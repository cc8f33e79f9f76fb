// SPDX-License-Identifier: GPL-3.0-or-later
//! Thread pools, by number of threads. Invariant: after a fork the child makes its own pools, because it
//! lacks the parent's threads; an object that outlives a call keeps a [`ThreadCount`] and takes its
//! [`Workers`] for each work.
//! Tests: `tests/test_rays.py::test_after_fork`, `tests/test_pictures.py::test_growing_after_a_fork`.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use gnurt::ThreadPool;
use gnurt_accel::Threads;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// More than that is a slip.
const MOST: usize = 1024;

/// By process and number of threads.
type Pools = HashMap<(u32, usize), Arc<ThreadPool>>;

/// Those of a parent are never dropped, because their threads cannot be joined.
static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

/// How many threads work, 1 or more.
#[derive(Clone, Copy)]
pub(crate) struct ThreadCount(usize);

impl ThreadCount {
    /// A number of threads; 0 is one for each core.
    pub(crate) fn new(threads: usize) -> PyResult<Self> {
        match threads {
            0 => Ok(Self(std::thread::available_parallelism().map_or(1, usize::from))),
            1..=MOST => Ok(Self(threads)),
            _ => Err(PyValueError::new_err(format!("threads: at most {MOST}, not {threads}"))),
        }
    }

    /// Those of this process.
    pub(crate) fn workers(self) -> PyResult<Workers> {
        Ok(Workers { count: self, pool: if self.0 == 1 { None } else { Some(self.pool()?) } })
    }

    /// This process's pool, even for one thread: for work that the calling thread never does.
    pub(crate) fn pool(self) -> PyResult<Arc<ThreadPool>> {
        pool(self.0)
    }
}

/// The threads of one call: the calling thread, or a pool.
pub(crate) struct Workers {
    count: ThreadCount,
    pool: Option<Arc<ThreadPool>>,
}

impl Workers {
    /// How many they are.
    pub(crate) fn count(&self) -> ThreadCount {
        self.count
    }

    pub(crate) fn threads(&self) -> Threads<'_> {
        self.pool.as_deref().map_or(Threads::Single, Threads::Pool)
    }
}

/// Calls a function with one thread per core for a picture's file, once it uses them; with the calling thread, if the system
/// refuses them.
pub(crate) fn with_all_threads<T>(f: impl FnOnce(gnurt::image::Workers) -> T) -> T {
    let threads = std::cell::OnceCell::new();
    let begin = || ThreadCount::new(0).and_then(ThreadCount::pool).ok();
    f(&|count, job| gnurt::workers(threads.get_or_init(begin).as_deref())(count, job))
}

/// The process's pool of `count` threads.
fn pool(count: usize) -> PyResult<Arc<ThreadPool>> {
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let pools = pools.get_or_insert_default();
    let key = (std::process::id(), count);
    if let Some(pool) = pools.get(&key) {
        return Ok(pool.clone());
    }
    let pool = gnurt::thread_pool(count);
    let pool = Arc::new(pool.map_err(|error| PyValueError::new_err(format!("threads: {error}")))?);
    pools.insert(key, pool.clone());
    Ok(pool)
}
