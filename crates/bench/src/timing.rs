// SPDX-License-Identifier: GPL-3.0-or-later
//! Times a job: threads take chunks of rays until none is left, each on its own clock of processor time.
//! Tests: `tests::every_chunk_is_traced_once`.

use std::hint::black_box;
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use gnurt::accel::{HitBatch, INVALID_ID, Ray, RayBatch, Record, Triangles};

use crate::clock::thread_seconds;
use crate::ffi_embree::OneRay;
use crate::pin::Pinned;

/// Something that answers rays.
pub trait Engine: Sync {
    /// Makes rays ready that are asked about one by one. This and [`read_back`](Self::read_back) are not counted: a program has its
    /// rays in the form of the engine that it uses.
    fn make_ready(&self, _rays: &RayBatch, _answers: &mut Answers) {}
    /// Reads back the answers to such rays.
    fn read_back(&self, _any: bool, _answers: &mut Answers) {}
    /// Closest hits: fills `t` and `prim_id` of `answers.hits`; [`INVALID_ID`] for a hit where it does not
    /// know which.
    fn closest(&self, rays: &RayBatch, answers: &mut Answers);
    /// Any hits: fills `answers.occluded`.
    fn any(&self, rays: &RayBatch, answers: &mut Answers);
}

/// Where a thread's answers go: used again and again, as a program does.
#[derive(Debug, Default)]
pub struct Answers {
    /// Closest hits; only `t` and `prim_id` are read.
    pub hits: HitBatch,
    /// Whether anything is hit.
    pub occluded: Vec<bool>,
    pub(crate) record: Record,
    /// Rays of calls for one ray each, in the form of either side.
    pub(crate) own_rays: Vec<Ray>,
    pub(crate) embree_rays: Vec<OneRay>,
}

impl Answers {
    /// Space for `n` answers with undefined contents.
    pub fn resize(&mut self, n: usize) {
        if self.hits.len() != n {
            self.hits.reset(n);
        }
        self.occluded.resize(n, false);
    }
}

/// The rays of a class, in chunks.
pub(crate) struct Rays<'a> {
    pub(crate) chunks: Vec<RayBatch>,
    /// Whether any hit will do.
    pub(crate) any: bool,
    /// The target of the rays.
    pub(crate) triangles: Triangles<'a>,
}

impl<'a> Rays<'a> {
    pub(crate) fn new(chunks: Vec<RayBatch>, any: bool, triangles: Triangles<'a>) -> Self {
        Self { chunks, any, triangles }
    }

    pub(crate) fn len(&self) -> usize {
        self.chunks.iter().map(RayBatch::len).sum()
    }

    /// Ray `i`, counted through all chunks.
    pub(crate) fn get(&self, mut i: usize) -> Option<Ray> {
        for chunk in &self.chunks {
            if i < chunk.len() {
                return Some(chunk.get(i));
            }
            i -= chunk.len();
        }
        None
    }
}

/// Seconds of one run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seconds {
    /// Mean over the threads of their processor time.
    pub(crate) cpu: f64,
    pub(crate) wall_time: f64,
}

fn run_query(engine: &dyn Engine, any: bool, chunk: &RayBatch, answers: &mut Answers) {
    if any {
        engine.any(chunk, answers);
        black_box((&answers.occluded, &answers.embree_rays));
    } else {
        engine.closest(chunk, answers);
        black_box((&answers.hits, &answers.embree_rays));
    }
}

/// All of a query, for its answers.
pub(crate) fn ask(engine: &dyn Engine, any: bool, chunk: &RayBatch, answers: &mut Answers) {
    engine.make_ready(chunk, answers);
    run_query(engine, any, chunk, answers);
    engine.read_back(any, answers);
}

/// One run over all rays, each thread on its own core.
pub(crate) fn time(engine: &dyn Engine, rays: &Rays, threads: usize) -> Seconds {
    let next = AtomicUsize::new(0);
    let barrier = Barrier::new(threads);
    let work = |thread: usize| {
        let _pinned = Pinned::thread(thread, threads);
        let mut answers = Answers::default();
        barrier.wait();
        let (mut cpu, mut wall_time) = (0.0, 0.0);
        while let Some(chunk) = rays.chunks.get(next.fetch_add(1, Ordering::Relaxed)) {
            engine.make_ready(chunk, &mut answers);
            let (start, before) = (Instant::now(), thread_seconds());
            run_query(engine, rays.any, chunk, &mut answers);
            cpu += thread_seconds() - before;
            wall_time += start.elapsed().as_secs_f64();
            engine.read_back(rays.any, &mut answers);
        }
        (cpu, wall_time)
    };
    let times: Vec<(f64, f64)> = if threads == 1 {
        vec![work(0)]
    } else {
        std::thread::scope(|scope| {
            let work = &work;
            let running: Vec<_> = (0..threads).map(|thread| scope.spawn(move || work(thread))).collect();
            // A panic of a thread is a bug: let it be seen.
            let joined = running.into_iter().map(|thread| thread.join());
            joined.map(|result| result.unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
        })
    };
    let cpu = times.iter().map(|(cpu, _)| cpu).sum::<f64>() / threads as f64;
    Seconds { cpu, wall_time: times.iter().fold(0.0, |longest, (_, wall_time)| wall_time.max(longest)) }
}

/// The answers to all rays: the input of [`compare`](crate::agreement::compare).
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Answered {
    /// Infinite for a miss; of any-hit rays 1 for a hit.
    pub(crate) t: Vec<f32>,
    /// Which triangle; [`INVALID_ID`] for a miss, for any-hit rays, and of engines that do not say.
    pub(crate) prim_id: Vec<u32>,
}

/// Traces all rays.
pub(crate) fn answers(engine: &dyn Engine, rays: &Rays) -> Answered {
    let mut all = Answered::default();
    let mut answers = Answers::default();
    for chunk in &rays.chunks {
        ask(engine, rays.any, chunk, &mut answers);
        if rays.any {
            all.t.extend(answers.occluded.iter().map(|&occluded| if occluded { 1.0 } else { f32::INFINITY }));
            all.prim_id.resize(all.t.len(), INVALID_ID);
        } else {
            all.t.extend_from_slice(&answers.hits.t);
            all.prim_id.extend_from_slice(&answers.hits.prim_id);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts rays; its "hits" are at the ray's own far end. It takes long to make them ready.
    struct Counter(AtomicUsize);

    impl Engine for Counter {
        fn make_ready(&self, rays: &RayBatch, answers: &mut Answers) {
            answers.own_rays.clear();
            answers.own_rays.extend((0..rays.len()).map(|i| rays.get(i)));
            let start = thread_seconds();
            while thread_seconds() - start < 0.02 {}
        }
        fn read_back(&self, _: bool, answers: &mut Answers) {
            assert_eq!(answers.own_rays.len(), answers.hits.len(), "those that were made ready");
        }
        fn closest(&self, rays: &RayBatch, answers: &mut Answers) {
            answers.resize(rays.len());
            answers.hits.t.copy_from_slice(&rays.t_far);
            self.0.fetch_add(rays.len(), Ordering::Relaxed);
        }
        fn any(&self, rays: &RayBatch, answers: &mut Answers) {
            answers.resize(rays.len());
            self.0.fetch_add(rays.len(), Ordering::Relaxed);
        }
    }

    #[test]
    fn every_chunk_is_traced_once() {
        let ray = |i: usize| Ray::new([0.0; 3], [1.0; 3]).within(0.0, i as f32);
        let chunks: Vec<RayBatch> = [0..100, 100..200, 200..207].map(|part| part.map(ray).collect()).into();
        let rays = Rays::new(chunks, false, Triangles::default());
        for threads in [1, 2, 5] {
            let counter = Counter(AtomicUsize::new(0));
            let seconds = time(&counter, &rays, threads);
            assert_eq!(counter.0.into_inner(), 207, "all rays by {threads} threads");
            assert!(seconds.cpu >= 0.0 && seconds.wall_time > 0.0, "it takes time: {seconds:?}");
            assert!(seconds.cpu < 0.01, "what makes rays ready does not count: {seconds:?}");
        }
        let t = answers(&Counter(AtomicUsize::new(0)), &rays);
        assert!(t.t.iter().copied().eq((0..207).map(|i| i as f32)), "in the order of the rays");
    }
}
