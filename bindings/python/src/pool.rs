// SPDX-License-Identifier: GPL-3.0-or-later
//! Threads by their number. Source: original. Invariant: after a fork the child makes pools of its own, for threads of its
//! parent are not in it. Proof: `tests/test_rays.py::test_after_fork`.

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

/// Those of a parent are never dropped: there is nobody to join.
static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

/// Who works: the calling thread, or a pool.
#[derive(Clone)]
pub(crate) struct Workers {
    count: usize,
    pool: Option<Arc<ThreadPool>>,
}

impl Workers {
    /// So many threads; 0 is one for each core.
    pub(crate) fn new(threads: usize) -> PyResult<Self> {
        if threads > MOST {
            return Err(PyValueError::new_err(format!("threads: at most {MOST}, not {threads}")));
        }
        let count = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        Ok(Self { count, pool: if count == 1 { None } else { Some(pool(count)?) } })
    }

    /// A pool, of one thread if need be: for what is never done by the calling one.
    pub(crate) fn pool(&self) -> PyResult<Arc<ThreadPool>> {
        self.pool.clone().map_or_else(|| pool(self.count), Ok)
    }

    pub(crate) fn threads(&self) -> Threads<'_> {
        self.pool.as_deref().map_or(Threads::Single, Threads::Pool)
    }
}

/// The process's pool of so many threads.
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
