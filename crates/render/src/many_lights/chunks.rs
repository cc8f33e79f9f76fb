// SPDX-License-Identifier: GPL-3.0-or-later
//! Work on many paths, shared out to threads in chunks. Results do not depend on the threads.

use gnurt_accel::threads::map;

use crate::job::Job;
use crate::stats::RenderStats;
use crate::tracer::BatchTracer;

/// Paths that one thread follows at a time.
const CHUNK: u32 = 256;

/// Results of `of_chunk` for chunks of `0..count`, in order; on all threads of the current pool, if there is one.
pub(super) fn in_chunks<T: Send>(
    job: &Job,
    count: u32,
    stats: &mut RenderStats,
    of_chunk: impl Fn(&mut BatchTracer, std::ops::Range<u32>) -> T + Sync,
) -> Vec<T> {
    in_chunks_of(CHUNK, job, count, stats, of_chunk)
}

/// The same, for chunks of a chosen size.
pub(super) fn in_chunks_of<T: Send>(
    size: u32,
    job: &Job,
    count: u32,
    stats: &mut RenderStats,
    of_chunk: impl Fn(&mut BatchTracer, std::ops::Range<u32>) -> T + Sync,
) -> Vec<T> {
    let one = |n: usize| {
        let n = n as u32;
        let mut tracer = job.tracer(false);
        let result = of_chunk(&mut tracer, n * size..((n + 1) * size).min(count));
        (result, tracer.take_stats())
    };
    map(rayon::current_thread_index().is_some(), count.div_ceil(size) as usize, one)
        .into_iter()
        .map(|(result, spent)| {
            stats.add(&spent);
            result
        })
        .collect()
}
