// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench dynamic`: cost of following a deforming mesh, and the speed of rays afterwards, with Embree's for
//! comparison. The scene is twisted and waves more and more from frame to frame. Times are processor time of
//! one thread, runs of engines alternate, and all trace the same rays, whose answers must agree.
//! Tests: `tests::a_box_is_twisted`.

use gnurt::ThreadPool;
use gnurt::accel::{
    BuildOptions, Coherence, Geometry, Motion, MovingTree, ObjectTree, Quality, Structure, Threads,
    Triangles, Update,
};
use gnurt::simd::Level;

use crate::clock::process_seconds;
use crate::comparison::check;
use crate::dynamic_row::DynamicRow;
use crate::embree::EmbreeEngine;
use crate::event::BenchEvent;
use crate::ffi_embree::{MovingScene, Scene};
use crate::job::{OwnKind, Packets, QueryKind};
use crate::options::Options as RayOptions;
use crate::own::OwnEngine;
use crate::ray_classes::RayMaker;
use crate::row::median;
use crate::timing::{Rays, time};
use crate::{Class, Contestant, EmbreeLibrary, Error, Subject, research};

/// The scenes to measure, and the method.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Frames of deformation; each is an update.
    pub frames: usize,
    /// Builds of each quality, and runs over the rays.
    pub rounds: usize,
    /// Columns and rows of primary rays.
    pub size: u32,
    /// Instruction set of rays.
    pub level: Level,
}

/// Vertices at a frame out of all: the scene twists around its axis and waves.
pub(crate) fn deformed(subject: &Subject, share: f32, to: &mut [[f32; 3]]) {
    let rest = &subject.padded[..to.len()];
    let bounds = gnurt::accel::Aabb::around(rest);
    let middle = [0, 1, 2].map(|k| 0.5 * (bounds.min[k] + bounds.max[k]));
    let size = bounds.extent().into_iter().fold(f64::MIN_POSITIVE, f64::max) as f32;
    for (p, rest) in to.iter_mut().zip(rest) {
        let [x, y, z] = [0, 1, 2].map(|k| (rest[k] - middle[k]) / size);
        let (sin, cos) = (3.0 * share * y).sin_cos();
        let wave = 0.05 * share * (20.0 * x + 9.0 * share).sin();
        let moved = [cos * x - sin * z, y + wave, sin * x + cos * z];
        *p = [0, 1, 2].map(|k| middle[k] + size * moved[k]);
    }
}

/// Rebuilt structures: BVHs, and with the feature `research` grids and the quick kd-tree.
fn rebuilt() -> impl Iterator<Item = OwnKind> {
    let of = |name| research::find(name).map(|structure| OwnKind::new(structure, Quality::Fast));
    of("grid").into_iter().chain([OwnKind::FAST, OwnKind::MEDIUM, OwnKind::HIGH]).chain(of("kd"))
}

/// Something that follows the frames.
enum Follower<'a> {
    Refit(Box<ObjectTree>),
    Moving(Motion, MovingTree),
    Build(OwnKind, Box<ObjectTree>),
    EmbreeRefit(MovingScene<'a>),
    EmbreeBuild(i32, Scene<'a>),
}

impl Follower<'_> {
    fn names(&self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Refit(_) => ("refit", "refit", "gnurt"),
            Self::Moving(Motion::Auto, _) => ("refit", "auto", "gnurt"),
            Self::Moving(..) => ("refit", "known", "gnurt"),
            Self::Build(kind, _) => {
                let strategy = match (research::name(kind.structure), kind.quality) {
                    ("grid", _) => "grid",
                    ("kd", _) => "kd-fast",
                    (_, Quality::Fast) => "fast",
                    (_, Quality::Medium) => "medium",
                    (_, Quality::High) => "high",
                };
                ("rebuild", strategy, "gnurt")
            }
            Self::EmbreeRefit(_) => ("refit", "refit", "embree4"),
            Self::EmbreeBuild(0, _) => ("rebuild", "low", "embree4"),
            Self::EmbreeBuild(1, _) => ("rebuild", "medium", "embree4"),
            Self::EmbreeBuild(..) => ("rebuild", "high", "embree4"),
        }
    }
}

/// Measures one scene: all strategies of refitting over all frames, builds of all qualities of the last one.
///
/// # Errors
/// As [`rays::run`](crate::rays::run).
pub fn run(
    subject: &Subject,
    options: &Options,
    embree: Option<&EmbreeLibrary>,
    pool: &ThreadPool,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<DynamicRow>, Error> {
    let failed = |why: String| Error::Embree { library: "embree4".into(), why };
    let count = subject.padded.len() - 1;
    // The last frame outlives the scenes that are built over it.
    let mut last_frame = subject.clone();
    deformed(subject, 1.0, &mut last_frame.padded[..count]);
    let last_frame = last_frame;
    let device = embree.map(|library| library.device(options.level, 1)).transpose()?;
    let mut moved = subject.clone();
    let build = |subject: &Subject, kind: OwnKind| {
        Box::new(ObjectTree::build(&[subject.triangles()], &kind.options(), Threads::Single))
    };
    let medium = BuildOptions::default();
    let rest: [Geometry; 1] = [subject.triangles().into()];
    let moving =
        |motion| Follower::Moving(motion, MovingTree::build(&rest, &medium, motion, Threads::Pool(pool)));
    let mut followers =
        vec![Follower::Refit(build(subject, OwnKind::MEDIUM)), moving(Motion::Auto), moving(Motion::Known)];
    if let Some(device) = &device {
        let scene = MovingScene::build(device, subject.padded.clone(), &subject.indices);
        followers.push(Follower::EmbreeRefit(scene.map_err(failed)?));
    }
    let mut times: Vec<Vec<f64>> = followers.iter().map(|_| Vec::new()).collect();
    let mut rebuilds = vec![0; followers.len()];
    for frame in 1..=options.frames {
        deformed(subject, frame as f32 / options.frames as f32, &mut moved.padded[..count]);
        for engine_index in 0..followers.len() {
            let i = (engine_index + frame) % followers.len();
            if let Follower::EmbreeRefit(scene) = &mut followers[i] {
                scene.move_to(&moved.padded);
            }
            let triangles = moved.triangles();
            let before = process_seconds();
            let update = follow(&mut followers[i], triangles, &medium);
            times[i].push(process_seconds() - before);
            rebuilds[i] += usize::from(update.is_some_and(|update| update != Update::Refitted));
        }
    }

    // Builds of the last frame.
    for kind in rebuilt() {
        let mut taken = Vec::new();
        let mut last = None;
        for _ in 0..options.rounds {
            let before = process_seconds();
            last = Some(build(&last_frame, kind));
            taken.push(process_seconds() - before);
        }
        followers.extend(last.map(|tree| Follower::Build(kind, tree)));
        times.push(taken);
        let Some(device) = &device else { continue };
        if kind.structure != Structure::Bvh {
            continue;
        }
        let embree = match kind.quality {
            Quality::Fast => 0,
            Quality::Medium => 1,
            Quality::High => 2,
        };
        let mut taken = Vec::new();
        let mut last = None;
        for _ in 0..options.rounds {
            drop(last.take());
            let before = process_seconds();
            last = Some(
                Scene::build(device, &last_frame.padded, &last_frame.indices, embree, 0).map_err(failed)?,
            );
            taken.push(process_seconds() - before);
        }
        followers.extend(last.map(|scene| Follower::EmbreeBuild(embree, scene)));
        times.push(taken);
    }
    rebuilds.resize(followers.len(), 0);
    rows(&last_frame, options, &followers, &times, &rebuilds, report)
}

/// Brings one up to date.
fn follow(follower: &mut Follower, triangles: Triangles, options: &BuildOptions) -> Option<Update> {
    match follower {
        Follower::Refit(tree) => {
            let old = std::mem::replace(&mut **tree, ObjectTree::build(&[], options, Threads::Single));
            match old.refit(&[triangles], Threads::Single) {
                Ok(refitted) => **tree = refitted,
                Err(_) => {
                    **tree = ObjectTree::build(&[triangles], options, Threads::Single);
                    return Some(Update::Rebuilt);
                }
            }
            Some(Update::Refitted)
        }
        Follower::Moving(_, moving) => Some(moving.update(&[triangles.into()], options, Threads::Single)),
        Follower::EmbreeRefit(scene) => {
            scene.refit();
            None
        }
        Follower::Build(..) | Follower::EmbreeBuild(..) => None,
    }
}

/// Traces the same rays in all of them.
fn rows(
    moved: &Subject,
    options: &Options,
    followers: &[Follower],
    times: &[Vec<f64>],
    rebuilds: &[usize],
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<DynamicRow>, Error> {
    let reference = ObjectTree::build(&[moved.triangles()], &BuildOptions::default(), Threads::Single);
    let maker = RayMaker::new(moved, options.size, &reference, options.level)?;
    let query_kind = QueryKind::Batch(Coherence::Incoherent);
    let contestants: Vec<Contestant> = followers
        .iter()
        .map(|follower| {
            let (_, strategy, engine) = follower.names();
            let own = |tree| OwnEngine { tree, query_kind, level: options.level };
            let reference_engine =
                |scene| EmbreeEngine { scene, packets: Packets { size: 1, coherent: false } };
            Contestant {
                engine,
                mode: strategy.into(),
                isa: options.level.name(),
                tracer: match follower {
                    Follower::Refit(tree) | Follower::Build(_, tree) => Box::new(own(tree)),
                    Follower::Moving(_, moving) => Box::new(own(moving.tree())),
                    Follower::EmbreeRefit(scene) => Box::new(reference_engine(scene.scene())),
                    Follower::EmbreeBuild(_, scene) => Box::new(reference_engine(scene)),
                },
            }
        })
        .collect();
    let ray_options = RayOptions::default();
    let rays = Rays::new(maker.rays(Class::Diffuse, ray_options.batch), false, moved.triangles());
    let sums =
        check(&format!("{} deformed", moved.name), &rays, &contestants, ray_options.tolerance, report)?;
    let mut seconds = vec![Vec::new(); contestants.len()];
    for round in 0..options.rounds {
        for engine_index in 0..contestants.len() {
            let i = (engine_index + round) % contestants.len();
            seconds[i].push(time(&*contestants[i].tracer, &rays, 1).cpu);
        }
    }
    let row = |(i, follower): (usize, &Follower)| {
        let (case, strategy, engine) = follower.names();
        let bytes = |tree: &ObjectTree| tree.stats().tree_bytes + tree.stats().primitive_bytes;
        DynamicRow {
            case,
            scene: moved.name.clone(),
            strategy,
            engine,
            threads: 1,
            triangles: moved.triangle_count() as u64,
            instances: 1,
            update_ms_cpu: 1e3 * median(&times[i]),
            trace_mrays_cpu: rays.len() as f64 / 1e6 / median(&seconds[i]).max(1e-9),
            bytes: match follower {
                Follower::Refit(tree) | Follower::Build(_, tree) => Some(bytes(tree)),
                Follower::Moving(_, moving) => Some(bytes(moving.tree())),
                Follower::EmbreeRefit(_) | Follower::EmbreeBuild(..) => None,
            },
            hits: sums[i].hits,
            rebuilds: rebuilds[i],
        }
    };
    Ok(followers.iter().enumerate().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamic_row::{table, to_json};

    #[test]
    fn a_box_is_twisted() {
        let scene = gnurt::load_scene("builtin:cornell").expect("it is built in").scene;
        let subject = Subject::new("cornell", &scene);
        let pool = gnurt::thread_pool(2).expect("threads");
        let options = Options { frames: 5, rounds: 1, size: 32, level: Level::best() };
        let rows = run(&subject, &options, None, &pool, &mut |_| {}).expect("it can be followed");
        assert_eq!(rows.len(), 8, "three that follow, five that are built: {rows:?}");
        assert!(rows.iter().all(|row| row.hits == rows[0].hits && row.hits > 100), "{rows:?}");
        assert_eq!(table(&rows).lines().count(), 10, "a title, a head, a line each");
        assert_eq!(to_json(&rows).as_array().map(Vec::len), Some(8), "an object each");
    }
}
