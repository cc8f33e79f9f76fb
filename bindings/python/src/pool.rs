// SPDX-License-Identifier: GPL-3.0-or-later
//! Threads by their number. Source: original. Invariant: after a fork the child makes pools of its own, for threads of its
//! parent are not in it. Proof: `tests/test_rays.py::test_after_fork`.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use gnurt_accel::Threads;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// More than that is a slip.
const MOST: usize = 1024;

/// By process and number of threads.
type Pools = HashMap<(u32, usize), Arc<ThreadPool>>;

/// Those of a parent are never dropped: there is nobody to join.
static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

/// Who works: the calling thread, or a pool.
#[derive(Clone)]
pub(crate) struct Workers(Option<Arc<ThreadPool>>);

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
        if count == 1 {
            return Ok(Self(None));
        }
        let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
        let pools = pools.get_or_insert_default();
        let key = (std::process::id(), count);
        if let Some(pool) = pools.get(&key) {
            return Ok(Self(Some(pool.clone())));
        }
        let pool = ThreadPoolBuilder::new().num_threads(count).build();
        let pool = Arc::new(pool.map_err(|error| PyValueError::new_err(format!("threads: {error}")))?);
        pools.insert(key, pool.clone());
        Ok(Self(Some(pool)))
    }

    pub(crate) fn threads(&self) -> Threads<'_> {
        self.0.as_deref().map_or(Threads::Single, Threads::Pool)
    }
}
