// SPDX-License-Identifier: GPL-3.0-or-later
//! The speed of rays with times in a mesh that moves while the shutter is open, compared with Embree's motion
//! blur and with the same mesh at rest. The scene twists and waves as `bench dynamic` deforms it, by a small
//! part. Rays are traced one by one, by one thread, each at its own time; times are its processor seconds,
//! engines alternate, and results must agree.
//! Tests: `tests::both_hit_the_same`.

use gnurt::accel::{
    BuildOptions, Coherence, HitBatch, MovingTriangles, ObjectTree, Query, RayBatch, Record, Threads,
    TreeStats,
};
use gnurt::simd::Level;

use crate::clock::{process_seconds, thread_seconds};
use crate::dynamic::deformed;
use crate::embree::EmbreeLibrary;
use crate::error::Error;
use crate::ffi_embree::Scene;
use crate::random::Random;
use crate::ray_classes::{Class, RayMaker};
use crate::row::median;
use crate::single::{agree, closest, hit_count};
use crate::subject::Subject;

/// One measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct BlurRow {
    /// Class of rays.
    pub class: &'static str,
    /// `gnurt`, `gnurt still`, `embree4` or `embree4 robust`.
    pub engine: &'static str,
    /// Median of millions of rays in a second.
    pub mrays_cpu: f64,
    /// Seconds that the build took.
    pub build_seconds: f64,
    /// Bytes of tree and triangles; `None` where the engine does not report them.
    pub bytes: Option<u64>,
    /// Rays that hit something.
    pub hits: usize,
}

/// Embree's flags: none, and RTC_SCENE_FLAG_ROBUST.
const REFERENCES: [(&str, i32); 2] = [("embree4", 0), ("embree4 robust", 4)];

enum Engine<'a> {
    Ours(Box<ObjectTree>),
    Theirs(Scene<'a>),
}

/// Measures a scene with a number of keys, moved by `share` of the twist in all, with `size` x `size` primary
/// rays.
///
/// # Errors
/// [`Error`] if the scene has no view, Embree fails, or its answers are others than ours.
pub fn run(
    subject: &Subject,
    keys: usize,
    share: f32,
    size: u32,
    rounds: usize,
    embree: Option<&EmbreeLibrary>,
) -> Result<Vec<BlurRow>, Error> {
    let count = subject.padded.len() - 1;
    let key = |k: usize| {
        let mut positions = subject.padded.clone();
        deformed(subject, share * k as f32 / (keys - 1).max(1) as f32, &mut positions[..count]);
        positions
    };
    let lists: Vec<Vec<[f32; 3]>> = (0..keys).map(key).collect();
    let slices: Vec<&[[f32; 3]]> = lists.iter().map(|list| &list[..count]).collect();
    let moving = MovingTriangles { keys: &slices, indices: &subject.indices };
    let device = embree.map(|library| library.device(Level::best(), 1)).transpose()?;
    let mut engines: Vec<(&'static str, Engine, f64)> = Vec::new();
    let options = BuildOptions::default();
    for (name, geometry) in [("gnurt", moving.into()), ("gnurt still", subject.triangles().into())] {
        let before = process_seconds();
        let tree = Box::new(ObjectTree::build_from(&[geometry], &options, Threads::Single));
        engines.push((name, Engine::Ours(tree), process_seconds() - before));
    }
    if let (Some(device), Some(library)) = (&device, embree) {
        for (name, flags) in REFERENCES {
            let before = process_seconds();
            let scene = Scene::build_moving(device, &lists, &subject.indices, flags);
            let scene = scene.map_err(|why| library.failed(why))?;
            engines.push((name, Engine::Theirs(scene), process_seconds() - before));
        }
    }
    let Engine::Ours(still) = &engines[1].1 else { unreachable!("ours come first") };
    let maker = RayMaker::new(subject, size, still, Level::best())?;
    let mut rows = Vec::new();
    for class in [Class::Primary, Class::Diffuse] {
        let mut batches = maker.rays(class, 4096);
        let mut random = Random::new(7);
        for batch in &mut batches {
            batch.time = (0..batch.len()).map(|_| random.unit()).collect();
        }
        let rays: usize = batches.iter().map(RayBatch::len).sum();
        let mut seconds = vec![Vec::new(); engines.len()];
        let mut found = vec![vec![HitBatch::default(); batches.len()]; engines.len()];
        for round in 0..rounds {
            for engine_index in 0..engines.len() {
                let i = (engine_index + round) % engines.len();
                let before = thread_seconds();
                for (rays, hits) in batches.iter().zip(&mut found[i]) {
                    run_query(&engines[i].1, rays, hits);
                }
                seconds[i].push(thread_seconds() - before);
            }
        }
        for (i, (name, engine, build_seconds)) in engines.iter().enumerate() {
            if let (Engine::Theirs(_), Some(library)) = (engine, embree) {
                for (ours, theirs) in found[0].iter().zip(&found[i]) {
                    agree(ours, theirs, 1e-3, 200).map_err(|why| library.failed(format!("{name}: {why}")))?;
                }
            }
            let bytes = |stats: TreeStats| stats.tree_bytes + stats.primitive_bytes;
            rows.push(BlurRow {
                class: class.name(),
                engine: name,
                mrays_cpu: rays as f64 / 1e6 / median(&seconds[i]).max(1e-9),
                build_seconds: *build_seconds,
                bytes: match engine {
                    Engine::Ours(tree) => Some(bytes(tree.stats())),
                    Engine::Theirs(_) => None,
                },
                hits: found[i].iter().map(hit_count).sum(),
            });
        }
    }
    Ok(rows)
}

/// Closest hits, ray by ray.
fn run_query(engine: &Engine, rays: &RayBatch, hits: &mut HitBatch) {
    match engine {
        Engine::Ours(tree) => {
            let query = Query { coherence: Coherence::Incoherent, ..Query::default() };
            tree.intersect_batch(&query, rays, hits, &mut Record::default());
        }
        Engine::Theirs(scene) => closest(scene, rays, hits),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embree::embree_of_tests;

    #[test]
    fn both_hit_the_same() {
        let library = embree_of_tests();
        let scene = gnurt::load_scene("builtin:materials").expect("it is built in").scene;
        let subject = Subject::new("materials", &scene);
        for keys in [2, 4] {
            let rows = run(&subject, keys, 0.1, 32, 1, library.as_ref()).expect("they agree");
            assert_eq!(rows.len(), if library.is_some() { 8 } else { 4 }, "{rows:?}");
            assert!(rows.iter().all(|row| row.hits > 100), "{rows:?}");
        }
    }
}
