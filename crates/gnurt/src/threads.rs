// SPDX-License-Identifier: GPL-3.0-or-later
//! Pools of threads. The system never makes one of its own accord and never touches a global one: a pool is passed in.
//! Source: original. The number of threads changes no bit of a picture.

use std::num::NonZero;

use crate::Error;

/// Bytes of stack per thread. Shaders recurse, about 2.5 KiB per bounce, and shaders of others may take more; memory
/// that is not touched costs nothing.
const STACK: usize = 16 << 20;

/// A pool of `threads` threads; 0 = one per core that this process may use.
///
/// # Errors
/// [`Error::Threads`] if the system refuses them.
pub fn thread_pool(threads: usize) -> Result<rayon::ThreadPool, Error> {
    let threads = if threads == 0 { cores() } else { threads };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("gnurt-{i}"))
        .stack_size(STACK)
        .build()
        .map_err(|error| Error::Threads { threads, why: error.to_string() })
}

/// How many cores this process may use; at least 1.
#[must_use]
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}
