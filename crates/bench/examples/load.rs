// SPDX-License-Identifier: GPL-3.0-or-later
//! How long saved trees take to load, compared with building them. Run: `cargo run --release -p gnurt-bench
//! --example load -- SCENE...` One thread, median of five; the files were written just before, so that no
//! disk access is needed. Seconds of the processor, and on the wall. Both trees trace the same rays and must
//! agree, bit for bit.
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::error::Error;
use std::fs::File;
use std::path::Path;
use std::time::Instant;

use gnurt::accel::{
    BuildOptions, Coherence, Hit, HitBatch, Memory, ObjectTree, Query, Ray, RayBatch, Record, Threads,
};
use gnurt_bench::{Subject, thread_seconds};

const RUNS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    println!("| scene | triangles | tree | build CPU s | wall s | load CPU s | wall s | MB | build / load |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for scene in std::env::args().skip(1) {
        let name = Path::new(&scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let subject = Subject::new(&name, &gnurt::load_scene(&scene)?.scene);
        for memory in [Memory::Fast, Memory::Compact] {
            measure(&subject, memory)?;
        }
    }
    Ok(())
}

/// Prints one line of the table.
fn measure(subject: &Subject, memory: Memory) -> Result<(), Box<dyn Error>> {
    let options = BuildOptions { memory, ..BuildOptions::default() };
    let path = std::env::temp_dir().join(format!("gnurt-load-{}", std::process::id()));
    let build = || ObjectTree::build(&[subject.triangles()], &options, Threads::Single);
    let tree = build();
    tree.save(&mut File::create(&path)?)?;
    let bytes = std::fs::metadata(&path)?.len();
    let load = || ObjectTree::load(&mut File::open(&path)?).map_err(Box::<dyn Error>::from);
    let loaded = load();
    let times = loaded.and_then(|loaded| {
        let rays = rays_through(&tree);
        assert!(answers(&loaded, &rays) == answers(&tree, &rays), "a loaded tree answers as it did");
        let (mut builds, mut loads) = (Vec::new(), Vec::new());
        for _ in 0..RUNS {
            builds.push(timed(build).1);
            let (loaded, seconds) = timed(load);
            loaded?;
            loads.push(seconds);
        }
        Ok((median(builds), median(loads)))
    });
    std::fs::remove_file(&path)?;
    let ([build_cpu, build_wall], [load_cpu, load_wall]) = times?;
    println!(
        "| {} | {} | {memory:?} | {build_cpu:.4} | {build_wall:.4} | {load_cpu:.4} | {load_wall:.4} | {:.1} | {:.1} |",
        subject.name,
        subject.triangle_count(),
        bytes as f64 / 1e6,
        build_cpu / load_cpu
    );
    Ok(())
}

/// The result of a job, and its seconds of the processor and on the wall. The result is dropped later.
fn timed<T>(job: impl FnOnce() -> T) -> (T, [f64; 2]) {
    let (start, before) = (Instant::now(), thread_seconds());
    let result = job();
    (result, [thread_seconds() - before, start.elapsed().as_secs_f64()])
}

/// Each number's own median.
fn median(times: Vec<[f64; 2]>) -> [f64; 2] {
    [0, 1].map(|which| {
        let mut times: Vec<f64> = times.iter().map(|time| time[which]).collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    })
}

/// Between points all over a tree's box, which a sequence of low discrepancy spreads.
fn rays_through(tree: &ObjectTree) -> RayBatch {
    let bounds = tree.bounds();
    let point =
        |i: u32| [0.819_172_5_f64, 0.671_043_6, 0.549_700_5].map(|step| (f64::from(i) * step).fract() as f32);
    let position = |at: [f32; 3]| [0, 1, 2].map(|k| bounds.min[k] + at[k] * (bounds.max[k] - bounds.min[k]));
    let ray = |i: u32| {
        let (from, to) = (position(point(2 * i)), position(point(2 * i + 1).map(|x| 1.0 - x)));
        Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]))
    };
    (0..100_000).map(ray).collect()
}

/// Closest hits, ray by ray and in packets.
fn answers(tree: &ObjectTree, rays: &RayBatch) -> Vec<Option<(Hit, [u32; 3])>> {
    let mut all = Vec::new();
    for coherence in [Coherence::Incoherent, Coherence::Coherent, Coherence::Fanned] {
        let (mut hits, mut record) = (HitBatch::default(), Record::default());
        let query = Query { coherence, ..Query::default() };
        tree.intersect_batch(&query, rays, &mut hits, &mut record);
        let bits = |hit: Hit| (hit, [hit.t, hit.u, hit.v].map(f32::to_bits));
        all.extend((0..hits.len()).map(|i| hits.get(i).map(bits)));
    }
    let found = all.iter().flatten().count();
    assert!(found > 0, "{found} of {} rays hit something", all.len());
    all
}
