// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays through many instances of a tiny object, compared with Embree's packets through the same instances,
//! and with the same triangles as one mesh.
//! Source: two levels after WBS03a (docs/papers.bib). The instances are those of [`top`](crate::top), but smaller;
//! rays are those of `bench rays`. Times are processor time of one thread; all alternate.
//! Tests: `tests::all_hit_the_same`.

use std::sync::Arc;

use gnurt::accel::{
    BuildOptions, Coherence, Instance, ObjectTree, Query, RayBatch, SceneTree, Threads, Triangles,
};
use gnurt::scene::{Mesh, Scene};
use gnurt::simd::Level;

use crate::embree::{EmbreeEngine, EmbreeLibrary};
use crate::error::Error;
use crate::ffi_embree::Scene as EmbreeScene;
use crate::ffi_instances::Instances;
use crate::job::{Packets, QueryKind};
use crate::own::OwnEngine;
use crate::random::Random;
use crate::ray_classes::RayMaker;
use crate::row::median;
use crate::single::agree;
use crate::timing::{Answers, Engine, Rays, ask, time};
use crate::top::somewhere;
use crate::{Class, Contestant, Subject};

/// The scenes to measure, and the method.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Instances.
    pub count: usize,
    /// Triangles of the object: 1, or 12 of a box.
    pub triangles: usize,
    /// Columns and rows of primary rays.
    pub size: u32,
    /// Runs over the rays.
    pub rounds: usize,
}

/// One measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct TinyRow {
    /// The class of rays.
    pub class: Class,
    /// `gnurt` or `embree4`.
    pub engine: &'static str,
    /// The kind of query; `mesh` where all triangles are in one object.
    pub mode: String,
    /// Millions of rays in a second of the thread's processor time; the median.
    pub mrays_cpu: f64,
}

/// A scene, queried in batches.
struct SceneEngine<'a> {
    scene: &'a SceneTree,
    coherence: Coherence,
}

impl SceneEngine<'_> {
    fn query(&self) -> Query {
        Query { coherence: self.coherence, ..Query::default() }
    }
}

impl Engine for SceneEngine<'_> {
    fn closest(&self, rays: &RayBatch, answers: &mut Answers) {
        self.scene.intersect_batch(&self.query(), rays, &mut answers.hits, &mut answers.record);
    }

    fn any(&self, rays: &RayBatch, answers: &mut Answers) {
        self.scene.occluded_batch(&self.query(), rays, &mut answers.occluded, &mut answers.record);
    }
}

/// A triangle, or a box, half a unit wide.
fn object(triangles: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 / 2.0 - 0.25);
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    ((0..8).map(corner).collect(), quads.into_iter().flat_map(halves).take(triangles).collect())
}

/// Measures primary, shadow and diffuse rays.
///
/// # Errors
/// [`Error::Embree`] if Embree fails, or if answers are others than those of one mesh.
pub fn run(options: &Options, embree: Option<&EmbreeLibrary>) -> Result<Vec<TinyRow>, Error> {
    let (positions, indices) = object(options.triangles);
    let spread = 2.0 * (options.count as f32).cbrt();
    let mut random = Random::new(1);
    let matrices: Vec<[[f32; 3]; 4]> = (0..options.count).map(|_| somewhere(&mut random, spread)).collect();
    let mesh = Triangles { positions: &positions, indices: &indices };
    let build = BuildOptions::default();
    let shown = Arc::new(ObjectTree::build(&[mesh], &build, Threads::Single));
    let position = |columns: &[[f32; 3]; 4]| Instance::new(shown.clone(), columns.map(|c| c.map(f64::from)));
    let scene = SceneTree::build(&matrices.iter().map(position).collect::<Vec<_>>(), &build, Threads::Single);

    let subject = as_one_mesh(&positions, &indices, &matrices);
    let whole = ObjectTree::build(&[subject.triangles()], &build, Threads::Single);
    let maker = RayMaker::new(&subject, options.size, &whole, Level::best())?;

    let device = embree.map(|library| library.device(Level::best(), 1)).transpose()?;
    let mut padded = positions.clone();
    padded.push([0.0; 3]);
    let theirs = match (&device, embree) {
        (Some(device), Some(library)) => {
            let shown = EmbreeScene::build(device, &padded, &indices, 1, 0).map_err(|e| library.failed(e))?;
            let mut theirs = Instances::new(device, &shown, options.count, 1, 0);
            theirs.set_matrices(&matrices);
            theirs.commit();
            Some(theirs)
        }
        _ => None,
    };

    let mut contestants = Vec::new();
    let mut add = |engine, mode: String, tracer| {
        contestants.push(Contestant { engine, mode, isa: Level::best().name(), tracer });
    };
    let query_kind = QueryKind::Batch(Coherence::Coherent);
    add("gnurt", "mesh".into(), Box::new(OwnEngine { tree: &whole, query_kind, level: Level::best() }));
    for coherence in [Coherence::Coherent, Coherence::Fanned, Coherence::Incoherent] {
        let name = format!("{coherence:?}").to_lowercase();
        add("gnurt", name, Box::new(SceneEngine { scene: &scene, coherence }));
    }
    if let (Some(theirs), Some(device)) = (&theirs, &device) {
        for (size, coherent) in [(1, false), (8, false), (8, true), (16, false), (16, true)] {
            if device.has_packets(size) {
                let name = format!("{size}{}", if coherent { "-coherent" } else { "" });
                let packets = Packets { size, coherent };
                add("embree4", name, Box::new(EmbreeEngine { scene: &theirs.scene, packets }));
            }
        }
    }
    let mut rows = Vec::new();
    for class in [Class::Primary, Class::Shadow, Class::Diffuse] {
        let rays = Rays::new(maker.rays(class, 4096), class.is_any_hit(), subject.triangles());
        check(class, &rays, &contestants)?;
        let mut seconds = vec![Vec::new(); contestants.len()];
        for round in 0..options.rounds {
            for angle in 0..contestants.len() {
                let i = (angle + round) % contestants.len();
                seconds[i].push(time(&*contestants[i].tracer, &rays, 1).cpu);
            }
        }
        rows.extend(contestants.iter().zip(&seconds).map(|(contestant, seconds)| TinyRow {
            class,
            engine: contestant.engine,
            mode: contestant.mode.clone(),
            mrays_cpu: rays.len() as f64 / 1e6 / median(seconds).max(1e-9),
        }));
    }
    Ok(rows)
}

/// The instances copied, seen from outside.
fn as_one_mesh(positions: &[[f32; 3]], indices: &[[u32; 3]], matrices: &[[[f32; 3]; 4]]) -> Subject {
    let mut mesh = Mesh::default();
    for columns in matrices {
        let first = mesh.positions.len() as u32;
        let placed = |p: &[f32; 3]| {
            [0, 1, 2]
                .map(|k| columns[0][k] * p[0] + columns[1][k] * p[1] + columns[2][k] * p[2] + columns[3][k])
        };
        mesh.positions.extend(positions.iter().map(placed));
        mesh.indices.extend(indices.iter().map(|triangle| triangle.map(|i| first + i)));
    }
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh);
    let object = scene.add_object_of("", vec![mesh]);
    scene.instantiate(object, gnurt::scene::Affine::IDENTITY);
    Subject::new("tiny", &scene)
}

/// All hit at the distances of one mesh, except for one ray in a thousand: rays are rounded in the space of
/// each instance.
fn check(class: Class, rays: &Rays, contestants: &[Contestant]) -> Result<(), Error> {
    let Some((first, others)) = contestants.split_first() else { return Ok(()) };
    let (mut expected, mut found) = (Answers::default(), Answers::default());
    for chunk in &rays.chunks {
        ask(&*first.tracer, rays.any, chunk, &mut expected);
        for other in others {
            ask(&*other.tracer, rays.any, chunk, &mut found);
            let agreed = if rays.any {
                let differ = expected.occluded.iter().zip(&found.occluded).filter(|(a, b)| a != b).count();
                if differ * 500 > chunk.len() {
                    Err(format!("{differ} of {} rays differ", chunk.len()))
                } else {
                    Ok(())
                }
            } else {
                found.hits.inst_id.fill(gnurt::accel::INVALID_ID);
                agree(&expected.hits, &found.hits, 1e-4, 500)
            };
            agreed.map_err(|why| {
                Error::Differ(format!("tiny {class}: {} {}: {why}", other.engine, other.mode))
            })?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embree::embree_of_tests;

    #[test]
    fn all_hit_the_same() {
        let library = embree_of_tests();
        for triangles in [1, 12] {
            let options = Options { count: 500, triangles, size: 64, rounds: 1 };
            let rows = run(&options, library.as_ref()).expect("they agree");
            assert_eq!(rows.len() % 3, 0, "three classes: {rows:?}");
            assert!(rows.len() >= 12 && rows.iter().all(|row| row.mrays_cpu > 0.0), "{rows:?}");
        }
    }
}
