// SPDX-License-Identifier: GPL-3.0-or-later
//! Threads and instruction set of a command. Tests: `tests/program/arguments.rs`.

use std::cell::OnceCell;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use gnurt::image::{self, Picture, Workers};

use crate::arguments::MachineArguments;
use crate::environment::Environment;
use crate::failure::Failure;

/// The number that the command was given.
static THREADS: AtomicUsize = AtomicUsize::new(1);

/// Reads a picture by the command's threads.
pub(crate) fn read_picture(path: &Path) -> Result<Picture, image::Error> {
    with_workers(|workers| image::read_with(path, workers))
}

/// The number of threads of a command, before [`machine`] finds it; 0 = one per core.
pub(crate) fn use_threads(threads: Option<usize>) {
    THREADS.store(threads.unwrap_or(0), Ordering::Relaxed);
}

/// That number; 0 = one per core.
pub(crate) fn threads() -> usize {
    THREADS.load(Ordering::Relaxed)
}

/// Calls a function with workers: as many threads as [`machine`] found, once it uses them. The calling thread is enough for a
/// picture that is done, if the system refuses more.
pub(crate) fn with_workers<T>(f: impl FnOnce(Workers) -> T) -> T {
    let pool = OnceCell::new();
    let threads = threads();
    let begin = || if threads == 1 { None } else { gnurt::thread_pool(threads).ok() };
    f(&|count, job| gnurt::workers(pool.get_or_init(begin).as_ref())(count, job))
}

/// Options take precedence over the environment, which takes precedence over the machine's properties.
pub(crate) fn machine(
    arguments: &MachineArguments,
    environment: &Environment,
) -> Result<(gnurt::ThreadPool, gnurt::simd::Level), Failure> {
    let threads = arguments.threads.or(environment.threads).unwrap_or(0);
    THREADS.store(threads, Ordering::Relaxed);
    let pool = gnurt::thread_pool(threads).map_err(Failure::data)?;
    Ok((pool, arguments.isa.or(environment.isa).unwrap_or_default()))
}
