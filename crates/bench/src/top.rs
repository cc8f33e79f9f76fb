// SPDX-License-Identifier: GPL-3.0-or-later
//! Cost of building and updating the tree over the instances of a scene, and the speed of rays in it, with
//! Embree's for comparison. Source: two levels after WBS03a (docs/papers.bib). Times are processor seconds of
//! the whole program. Ours includes all work for a list of instances: inverses, boxes, the tree. Embree's is
//! divided: `position` is the program's calls for each instance, `build` the commit of the scene. Both trace
//! the same rays, and must hit the same instances at the same distances, except for ties.
//! Tests: `tests::both_hit_the_same`.

use std::sync::Arc;
use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::accel::{
    BuildOptions, Coherence, HitBatch, Instance, ObjectTree, Query, Ray, RayBatch, Record, SceneTree,
    Threads, Triangles,
};
use gnurt::simd::Level;

use crate::clock::process_seconds;
use crate::dynamic_row::DynamicRow;
use crate::embree::EmbreeLibrary;
use crate::error::Error;
use crate::ffi_embree::Scene;
use crate::ffi_instances::Instances;
use crate::random::Random;
use crate::row::median;
use crate::single::{agree, closest, hit_count};

/// One measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct TopRow {
    /// The work: `build`, `position`, `move-all`, `move-1000` or `move-one`.
    pub what: &'static str,
    /// `gnurt` or `embree4`.
    pub engine: &'static str,
    /// Threads of the pool; 1: only the calling thread.
    pub threads: usize,
    /// Median of the processor time of all threads, in milliseconds.
    pub cpu_ms: f64,
    /// Median of the time on the wall, in milliseconds.
    pub wall_ms: f64,
    /// Millions of rays in a second of one thread's processor time, through the result; 0 for `position`.
    pub mrays_cpu: f64,
    /// Of the rays.
    pub hits: u64,
    /// Of the tree, where the engine reports it.
    pub bytes: Option<u64>,
}

/// Rows as `bench dynamic` shows them, except for `position`.
#[must_use]
pub fn dynamic_rows(rows: &[TopRow], count: usize) -> Vec<DynamicRow> {
    let triangles = (count * ball().1.len()) as u64;
    let shown = rows.iter().filter(|row| row.what != PLACE);
    let dynamic = |row: &TopRow| DynamicRow {
        case: "top",
        scene: "balls".into(),
        strategy: row.what,
        engine: row.engine,
        threads: row.threads,
        triangles,
        instances: count as u64,
        update_ms_cpu: row.cpu_ms,
        trace_mrays_cpu: row.mrays_cpu,
        bytes: row.bytes,
        hits: row.hits,
        rebuilds: 0,
    };
    shown.map(dynamic).collect()
}

const BUILD: &str = "build";
const PLACE: &str = "place";

/// Columns of a map: rotated, between half and one and a half times as large.
pub(crate) fn somewhere(random: &mut Random, spread: f32) -> [[f32; 3]; 4] {
    let mut next = || random.unit();
    let (angle, size) = (std::f32::consts::TAU * next(), 0.5 + next());
    let (s, c) = angle.sin_cos();
    let position = [spread * next(), spread * next(), spread * next()];
    [[size * c, 0.0, -size * s], [0.0, size, 0.0], [size * s, 0.0, size * c], position]
}

/// A ball of 8 x 8 quadrangles.
pub(crate) fn ball() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let side = 8;
    let corner = |i: u32| {
        let (u, v) = ((i % (side + 1)) as f32 / side as f32, (i / (side + 1)) as f32 / side as f32);
        let (azimuth, polar) = (std::f32::consts::TAU * u, std::f32::consts::PI * v);
        [0.5 * polar.sin() * azimuth.cos(), 0.5 * polar.cos(), 0.5 * polar.sin() * azimuth.sin()]
    };
    let positions = (0..(side + 1) * (side + 1)).map(corner).collect();
    let quad = |i: u32| {
        let a = i / side * (side + 1) + i % side;
        [[a, a + 1, a + side + 1], [a + side + 1, a + 1, a + side + 2]]
    };
    (positions, (0..side * side).flat_map(quad).collect())
}

/// Measures `count` instances of a sphere, each quantity `rounds` times, engines alternating.
///
/// # Errors
/// [`Error::Embree`] if Embree fails, or if its answers are others than ours.
pub fn run(
    count: usize,
    rounds: usize,
    embree: Option<&EmbreeLibrary>,
    pool: &ThreadPool,
) -> Result<Vec<TopRow>, Error> {
    let (positions, indices) = ball();
    let spread = 2.0 * (count as f32).cbrt();
    let mut random = Random::new(1);
    let matrices: Vec<[[f32; 3]; 4]> = (0..count).map(|_| somewhere(&mut random, spread)).collect();
    let rays = rays(&mut random, spread);
    let mesh = Triangles { positions: &positions, indices: &indices };
    let options = BuildOptions::default();
    let object = Arc::new(ObjectTree::build(&[mesh], &options, Threads::Single));
    let instance =
        |position: &[[f32; 3]; 4]| Instance::new(object.clone(), position.map(|c| c.map(f64::from)));
    let list: Vec<Instance> = matrices.iter().map(instance).collect();
    let mut padded = positions.clone();
    padded.push([0.0; 3]);

    let all_threads = pool.current_num_threads();
    let (mut table, mut traces) = (Table::default(), Table::default());
    for threads in if all_threads == 1 { vec![1] } else { vec![1, all_threads] } {
        let ours = if threads == 1 { Threads::Single } else { Threads::Pool(pool) };
        let device = embree.map(|library| library.device(Level::best(), threads)).transpose()?;
        let theirs = match (&device, embree) {
            (Some(device), Some(library)) => {
                let shown = Scene::build(device, &padded, &indices, 1, 0).map_err(|e| library.failed(e))?;
                Some(Instances::new(device, &shown, count, 1, 0))
            }
            _ => None,
        };
        let mut theirs = theirs;
        let (mut scene, mut updated) = (SceneTree::default(), Vec::new());
        for round in 0..rounds {
            scene = table.time(BUILD, "gnurt", threads, || SceneTree::build(&list, &options, ours));
            if let Some(theirs) = &mut theirs {
                table.time(PLACE, "embree4", threads, || theirs.set_matrices(&matrices));
                table.time(BUILD, "embree4", threads, || theirs.commit());
            }
            updated.clear();
            for (what, step) in [("move-all", 1), ("move-1000", count.div_ceil(1000)), ("move-one", count)] {
                let moved = |position: usize| {
                    let mut instance = list[position].clone();
                    instance.world_from_object[3][1] += 0.1 * (round + 1) as f64;
                    (position as u32, Some(instance))
                };
                let changed: Vec<_> = (0..count).step_by(step).map(moved).collect();
                let tree = table.time(what, "gnurt", threads, || scene.updated(count, &changed, ours));
                updated.push((what, tree));
            }
        }
        if threads == 1 {
            updated.insert(0, (BUILD, scene));
            let query = Query { coherence: Coherence::Incoherent, ..Query::default() };
            let (mut hits, mut found) = (HitBatch::default(), HitBatch::default());
            for _ in 0..rounds {
                for (what, tree) in &updated {
                    let run_query = || tree.intersect_batch(&query, &rays, &mut hits, &mut Record::default());
                    traces.time(what, "gnurt", 1, run_query);
                    let stats = tree.stats();
                    let bytes = stats.tree_bytes + stats.primitive_bytes;
                    traces.note(what, "gnurt", hit_count(&hits) as u64, Some(bytes));
                    if let (BUILD, Some(theirs), Some(library)) = (*what, &theirs, embree) {
                        let run_query = || closest(&theirs.scene, &rays, &mut found);
                        traces.time(BUILD, "embree4", 1, run_query);
                        agree(&hits, &found, 1e-4, 1000).map_err(|e| library.failed(e))?;
                        traces.note(BUILD, "embree4", hit_count(&found) as u64, None);
                    }
                }
            }
        }
        if let (Some(device), Some(library)) = (&device, embree) {
            device.check().map_err(|e| library.failed(e))?;
        }
    }
    let mut rows = table.rows();
    let traces = traces.rows();
    for row in &mut rows {
        let same = |trace: &&TopRow| (trace.what, trace.engine) == (row.what, row.engine);
        if let Some(trace) = traces.iter().find(same) {
            row.mrays_cpu = rays.len() as f64 / 1e3 / trace.cpu_ms.max(1e-6);
            (row.hits, row.bytes) = (trace.hits, trace.bytes);
        }
    }
    Ok(rows)
}

/// Rays from one side of the cube to the other.
pub(crate) fn rays(random: &mut Random, spread: f32) -> RayBatch {
    (0..50_000)
        .map(|_| {
            let mut next = || spread * random.unit();
            let (from, to) = ([next(), next(), -1.0], [next(), next(), spread + 1.0]);
            Ray::new(from, [0, 1, 2].map(|k: usize| to[k] - from[k]))
        })
        .collect()
}

/// The measurements: processor and wall milliseconds of all runs.
#[derive(Default)]
struct Table(Vec<(TopRow, Vec<[f64; 2]>)>);

impl Table {
    fn time<T>(
        &mut self,
        what: &'static str,
        engine: &'static str,
        threads: usize,
        job: impl FnOnce() -> T,
    ) -> T {
        let (start, before) = (Instant::now(), process_seconds());
        let result = job();
        let times = [process_seconds() - before, start.elapsed().as_secs_f64()].map(|s| 1e3 * s);
        let same =
            |(row, _): &&mut (TopRow, _)| (row.what, row.engine, row.threads) == (what, engine, threads);
        match self.0.iter_mut().find(same) {
            Some((_, all)) => all.push(times),
            None => {
                let (mrays_cpu, hits, bytes) = (0.0, 0, None);
                let row = TopRow { what, engine, threads, cpu_ms: 0.0, wall_ms: 0.0, mrays_cpu, hits, bytes };
                self.0.push((row, vec![times]));
            }
        }
        result
    }

    /// Adds further data of a timed job.
    fn note(&mut self, what: &str, engine: &str, hits: u64, bytes: Option<u64>) {
        for (row, _) in self.0.iter_mut().filter(|(row, _)| (row.what, row.engine) == (what, engine)) {
            (row.hits, row.bytes) = (hits, bytes);
        }
    }

    fn rows(self) -> Vec<TopRow> {
        let middle = |(row, times): (TopRow, Vec<[f64; 2]>)| {
            let of = |which: usize| median(&times.iter().map(|times| times[which]).collect::<Vec<f64>>());
            TopRow { cpu_ms: of(0), wall_ms: of(1), ..row }
        };
        self.0.into_iter().map(middle).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embree::embree_of_tests;

    #[test]
    fn both_hit_the_same() {
        let library = embree_of_tests();
        let pool = gnurt::thread_pool(2).expect("threads start");
        let rows = run(3000, 1, library.as_ref(), &pool).expect("they agree");
        let engines = if library.is_some() { 2 } else { 1 };
        let builds = rows.iter().filter(|row| row.what == "build").count();
        assert_eq!(builds, 2 * engines, "{rows:?}");
        assert!(rows.iter().all(|row| row.cpu_ms >= 0.0), "{rows:?}");
        let shown = dynamic_rows(&rows, 3000);
        assert_eq!(
            shown.len(),
            2 * (3 + engines),
            "four of ours and one of theirs, by one thread and by two"
        );
        assert!(shown.iter().all(|row| row.hits > 1000 && row.trace_mrays_cpu > 0.0), "{shown:?}");
    }
}
