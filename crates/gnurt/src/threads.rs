// SPDX-License-Identifier: GPL-3.0-or-later
//! Pools of threads. The system neither makes a pool implicitly nor uses a global one: a pool is passed in.
//! The number of threads changes no bit of a picture.

use std::num::NonZero;
use std::ops::Deref;
use std::thread::JoinHandle;

use rayon::prelude::*;

use crate::Error;

/// Bytes of stack per thread. Shaders recurse, about 2.5 KiB per bounce, and shaders of others may take more; memory
/// that is not touched costs nothing.
const STACK: usize = 16 << 20;

/// A pool of `threads` threads; 0 = one per core that this process may use.
///
/// # Errors
/// [`Error::Threads`] if the system refuses them.
pub fn thread_pool(threads: usize) -> Result<rayon::ThreadPool, Error> {
    let threads = number(threads);
    builder(threads).build().map_err(|error| refused(threads, &error))
}

/// The threads of a pool as the [workers](crate::image::Workers) of a picture's file; without one, the calling thread.
pub fn workers(pool: Option<&rayon::ThreadPool>) -> impl Fn(usize, &(dyn Fn(usize) + Sync)) {
    move |count, job| match pool {
        Some(pool) => pool.install(|| (0..count).into_par_iter().for_each(job)),
        None => (0..count).for_each(job),
    }
}

/// A pool whose threads have ended when it is dropped: for libraries that a program may unload. The threads of others end a
/// little later. It must not be dropped by one of its own threads.
#[derive(Debug)]
pub struct JoinedPool {
    /// None while it is dropped.
    pool: Option<rayon::ThreadPool>,
    threads: Vec<JoinHandle<()>>,
}

impl JoinedPool {
    /// As [`thread_pool`].
    ///
    /// # Errors
    /// As [`thread_pool`].
    pub fn new(threads: usize) -> Result<Self, Error> {
        let count = number(threads);
        let mut threads = Vec::with_capacity(count);
        let spawn = |thread: rayon::ThreadBuilder| {
            let mut new = std::thread::Builder::new();
            if let Some(name) = thread.name() {
                new = new.name(name.to_owned());
            }
            threads.push(new.stack_size(STACK).spawn(|| thread.run())?);
            Ok(())
        };
        let pool = builder(count).spawn_handler(spawn).build().map_err(|error| refused(count, &error))?;
        Ok(Self { pool: Some(pool), threads })
    }
}

impl Deref for JoinedPool {
    type Target = rayon::ThreadPool;

    fn deref(&self) -> &rayon::ThreadPool {
        self.pool.as_ref().expect("there until it is dropped")
    }
}

impl Drop for JoinedPool {
    fn drop(&mut self) {
        // Requests them to end.
        self.pool = None;
        // A panic of a thread was reported where it happened.
        self.threads.drain(..).for_each(|thread| drop(thread.join()));
    }
}

fn number(threads: usize) -> usize {
    if threads == 0 { cores() } else { threads }
}

fn builder(threads: usize) -> rayon::ThreadPoolBuilder {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("gnurt-{i}"))
        .stack_size(STACK)
}

fn refused(threads: usize, error: &rayon::ThreadPoolBuildError) -> Error {
    Error::Threads { threads, why: error.to_string() }
}

/// How many cores this process may use; at least 1.
#[must_use]
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn joined_threads_have_ended() {
        let pool = JoinedPool::new(3).expect("three threads");
        assert_eq!(pool.current_num_threads(), 3);
        // Each thread holds this until it ends.
        thread_local!(static HELD: std::cell::RefCell<Option<Arc<()>>> = const { std::cell::RefCell::new(None) });
        let held = Arc::new(());
        pool.broadcast(|_| HELD.with_borrow_mut(|slot| *slot = Some(held.clone())));
        assert_eq!(Arc::strong_count(&held), 4, "each has one");
        drop(pool);
        assert_eq!(Arc::strong_count(&held), 1, "all threads are gone");
    }
}
