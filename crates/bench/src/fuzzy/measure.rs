// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench dynamic`, case `fuzzy`: fuzzy kd-trees of [GFSS06] and [GFW*06] beside refits and rebuilds. A tube moves as a limb with
//! two joints, and as one that is twisted and waves, through poses of which nine are given in advance. All follow each frame,
//! and trace the same rays in the last one, one by one. Times are processor time of one thread.
//! Tests: `tests::all_follow`.

use gnurt::accel::{
    BuildOptions, FuzzyTree, INVALID_ID, Motion, MovingTree, ObjectTree, Quality, RayBatch, Structure,
    Threads, Update,
};
use gnurt::scene::{Affine, Material, Mesh, Scene};

use crate::clock::process_seconds;
use crate::comparison::check;
use crate::dynamic::{Options, deformed};
use crate::dynamic_row::DynamicRow;
use crate::event::BenchEvent;
use crate::job::QueryKind;
use crate::options::Options as RayOptions;
use crate::own::OwnEngine;
use crate::ray_classes::RayMaker;
use crate::row::median;
use crate::stadium::tube;
use crate::timing::{Answers, Engine, Rays, time};
use crate::{Class, Contestant, Error, Subject};

/// Poses that are given in advance.
const GIVEN: usize = 9;

/// How far a joint of the limb turns, in radians.
const SWING: f32 = 1.8;

/// Height of the tube, whose radius is 1.
const HEIGHT: f32 = 8.0;

type Shape = fn(&Subject, f32, &mut [[f32; 3]]);

fn subject(name: &str, [rows, columns]: [u32; 2]) -> Subject {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::matte("", [0.5; 3]));
    let mesh = tube(rows, columns, |along, angle| {
        let radius = 1.0 + 0.1 * (5.0 * angle).sin();
        [radius * angle.cos(), HEIGHT * along, radius * angle.sin()]
    });
    let mesh = scene.add_mesh(Mesh { material, ..mesh });
    let object = scene.add_object_of("", vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
    Subject::new(name, &scene)
}

/// Bones along the axis, whose joints swing. A vertex near a joint goes with both, as skins do.
fn limb(subject: &Subject, share: f32, to: &mut [[f32; 3]]) {
    let turned = |[x, y, z]: [f32; 3], joint: f32, angle: f32| {
        let ((sin, cos), y) = (angle.sin_cos(), y - joint);
        [cos * x - sin * y, sin * x + cos * y + joint, z]
    };
    let angle = SWING * share;
    for (p, &rest) in to.iter_mut().zip(&subject.padded) {
        *p = rest;
        // From the outer joint to the inner one.
        for (joint, angle) in [(2.0 * HEIGHT / 3.0, -angle), (HEIGHT / 3.0, angle)] {
            let weight = ((rest[1] - joint) / 0.8 + 0.5).clamp(0.0, 1.0);
            let with = turned(*p, joint, angle);
            *p = [0, 1, 2].map(|k| (1.0 - weight) * p[k] + weight * with[k]);
        }
    }
}

/// Takes rays one by one.
struct FuzzyEngine<'a>(&'a FuzzyTree);

impl Engine for FuzzyEngine<'_> {
    fn make_ready(&self, rays: &RayBatch, answers: &mut Answers) {
        answers.own_rays.clear();
        answers.own_rays.extend((0..rays.len()).map(|i| rays.get(i)));
    }

    fn closest(&self, rays: &RayBatch, answers: &mut Answers) {
        answers.resize(rays.len());
        for i in 0..rays.len() {
            let hit = self.0.intersect(&answers.own_rays[i]);
            (answers.hits.t[i], answers.hits.prim_id[i]) =
                hit.map_or((f32::INFINITY, INVALID_ID), |hit| (hit.t, hit.prim_id));
        }
    }

    fn any(&self, rays: &RayBatch, answers: &mut Answers) {
        answers.resize(rays.len());
        let Answers { own_rays, occluded, .. } = answers;
        for (ray, occluded) in own_rays.iter().zip(occluded) {
            *occluded = self.0.occluded(ray);
        }
    }
}

/// Something that follows the frames.
enum Follower {
    Fuzzy(Box<FuzzyTree>),
    Moving(MovingTree),
    Rebuilt(BuildOptions, Box<ObjectTree>),
}

impl Follower {
    /// Brings it up to date; how many trees were built for that.
    fn follow(&mut self, subject: &Subject) -> usize {
        let triangles = subject.triangles();
        match self {
            Self::Fuzzy(tree) => tree.update(triangles.positions).unwrap_or_default(),
            Self::Moving(tree) => {
                let update = tree.update(&[triangles.into()], &BuildOptions::default(), Threads::Single);
                usize::from(update == Update::Rebuilt)
            }
            Self::Rebuilt(options, tree) => {
                **tree = ObjectTree::build(&[triangles], options, Threads::Single);
                1
            }
        }
    }

    fn bytes(&self) -> u64 {
        let stats = match self {
            Self::Fuzzy(tree) => tree.stats(),
            Self::Moving(tree) => tree.tree().stats(),
            Self::Rebuilt(_, tree) => tree.stats(),
        };
        stats.tree_bytes + stats.primitive_bytes
    }
}

/// Measures both motions.
///
/// # Errors
/// As [`rays::run`](crate::rays::run).
pub fn run(
    quads: [u32; 2],
    options: &Options,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<DynamicRow>, Error> {
    let mut rows = Vec::new();
    for (name, shape) in [("limb", limb as Shape), ("twist", deformed)] {
        rows.extend(measure(&subject(name, quads), shape, options, report)?);
    }
    Ok(rows)
}

fn measure(
    rest: &Subject,
    shape: Shape,
    options: &Options,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<DynamicRow>, Error> {
    let count = rest.padded.len() - 1;
    let pose = |share: f32| {
        let mut posed = rest.clone();
        shape(rest, share, &mut posed.padded[..count]);
        posed
    };
    let given: Vec<Subject> = (0..GIVEN).map(|i| pose(i as f32 / (GIVEN - 1) as f32)).collect();
    let poses: Vec<&[[f32; 3]]> = given.iter().map(|pose| pose.triangles().positions).collect();
    let before = process_seconds();
    let fuzzy = FuzzyTree::build(&poses, &rest.indices)
        .map_err(|error| Error::Scene { scene: rest.name.clone(), why: error.to_string() })?;
    let built_in = process_seconds() - before;
    let medium = BuildOptions::default();
    let quick = |structure| BuildOptions { structure, quality: Quality::Fast, ..medium };
    let moving = MovingTree::build(&[rest.triangles().into()], &medium, Motion::Known, Threads::Single);
    let build = |options: BuildOptions| {
        Follower::Rebuilt(
            options,
            Box::new(ObjectTree::build(&[rest.triangles()], &options, Threads::Single)),
        )
    };
    let mut followers = vec![
        ("fuzzy", Follower::Fuzzy(Box::new(fuzzy))),
        ("refit", Follower::Moving(moving)),
        (
            "b-kd",
            Follower::Moving(MovingTree::build(
                &[rest.triangles().into()],
                &BuildOptions { structure: Structure::BKd, ..medium },
                Motion::Known,
                Threads::Single,
            )),
        ),
        ("kd-fast", build(quick(Structure::Kd))),
        ("fast", build(quick(Structure::Bvh))),
    ];
    let mut times = vec![Vec::new(); followers.len()];
    let mut rebuilds = vec![0; followers.len()];
    let mut last = rest.clone();
    for frame in 1..=options.frames {
        shape(rest, frame as f32 / options.frames as f32, &mut last.padded[..count]);
        for turn in 0..followers.len() {
            let i = (turn + frame) % followers.len();
            let before = process_seconds();
            rebuilds[i] += followers[i].1.follow(&last);
            times[i].push(process_seconds() - before);
        }
    }
    let mut rows = trace(&last, &followers, options, report)?;
    for (i, row) in rows.iter_mut().enumerate() {
        (row.update_ms_cpu, row.rebuilds) = (1e3 * median(&times[i]), rebuilds[i]);
    }
    // What is done once, in advance.
    let once =
        DynamicRow { strategy: "in-advance", update_ms_cpu: 1e3 * built_in, rebuilds: 1, ..rows[0].clone() };
    rows.insert(1, once);
    Ok(rows)
}

/// The same rays in all of them; rows without updates.
fn trace(
    last: &Subject,
    followers: &[(&'static str, Follower)],
    options: &Options,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<DynamicRow>, Error> {
    let reference = ObjectTree::build(&[last.triangles()], &BuildOptions::default(), Threads::Single);
    let maker = RayMaker::new(last, options.size, &reference, options.level)?;
    let own = |tree| OwnEngine { tree, query_kind: QueryKind::One, level: options.level };
    let contestants: Vec<Contestant> = followers
        .iter()
        .map(|(strategy, follower)| Contestant {
            engine: "gnurt",
            mode: (*strategy).into(),
            isa: options.level.name(),
            tracer: match follower {
                Follower::Fuzzy(tree) => Box::new(FuzzyEngine(tree)),
                Follower::Moving(tree) => Box::new(own(tree.tree())),
                Follower::Rebuilt(_, tree) => Box::new(own(tree)),
            },
        })
        .collect();
    let ray_options = RayOptions::default();
    let rays = Rays::new(maker.rays(Class::Diffuse, ray_options.batch), false, last.triangles());
    let sums = check(&format!("{} moved", last.name), &rays, &contestants, ray_options.tolerance, report)?;
    let mut seconds = vec![Vec::new(); followers.len()];
    for round in 0..options.rounds {
        for turn in 0..followers.len() {
            let i = (turn + round) % followers.len();
            seconds[i].push(time(&*contestants[i].tracer, &rays, 1).cpu);
        }
    }
    let row = |(i, (strategy, follower)): (usize, &(&'static str, Follower))| DynamicRow {
        case: "fuzzy",
        scene: last.name.clone(),
        strategy,
        engine: "gnurt",
        threads: 1,
        triangles: last.triangle_count() as u64,
        instances: 1,
        update_ms_cpu: 0.0,
        trace_mrays_cpu: rays.len() as f64 / 1e6 / median(&seconds[i]).max(1e-9),
        bytes: Some(follower.bytes()),
        hits: sums[i].hits,
        rebuilds: 0,
    };
    Ok(followers.iter().enumerate().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::simd::Level;

    #[test]
    fn all_follow() {
        let options = Options { frames: 5, rounds: 1, size: 48, level: Level::best() };
        let rows = run([30, 12], &options, &mut |_| {}).expect("they agree");
        assert_eq!(rows.len(), 12, "two motions, five that follow and what is done in advance");
        for rows in rows.chunks(6) {
            assert!(rows.iter().all(|row| row.hits == rows[0].hits && row.hits > 20), "{rows:?}");
            assert_eq!(rows[4].rebuilds, 5, "one a frame: {rows:?}");
        }
    }
}
