// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench dynamic`, case `stadium`: a small object of many triangles in the middle of a large one, at several
//! ratios of their sizes. \[SIP06\], section 6, names it as the slow case of interval hierarchies. Each
//! structure traces the same rays, one by one: those of a camera that faces the small object, and one in a
//! random direction from each of their hits. `update` is a refit, or a build if there is none. Times are
//! processor time of one thread.
//! Tests: `tests::all_see_the_same`.

use gnurt::accel::{BuildOptions, Coherence, ObjectTree, Structure, Threads};
use gnurt::scene::{Affine, Camera, Material, Mesh, Scene};
use gnurt::simd::Level;

use crate::clock::process_seconds;
use crate::comparison::check;
use crate::dynamic_row::DynamicRow;
use crate::event::BenchEvent;
use crate::job::QueryKind;
use crate::options::Options as RayOptions;
use crate::own::OwnEngine;
use crate::ray_classes::RayMaker;
use crate::row::median;
use crate::timing::{Rays, time};
use crate::{Class, Contestant, Error, Subject, research};

/// Size of the stadium relative to its contents.
pub const RATIOS: [f32; 4] = [10.0, 100.0, 1000.0, 10_000.0];

/// The scenes to measure, and the method.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Updates of each structure, and runs over the rays.
    pub rounds: usize,
    /// Columns and rows of primary rays.
    pub size: u32,
    /// Instruction set of rays.
    pub level: Level,
}

/// Of the feature `research`; a BVH comes last.
const OTHERS: [&str; 4] = ["bih-plain", "bih", "b-kd", "kd"];

/// A surface of `rows` by `columns` quads, the last column being the first again.
pub(crate) fn tube(rows: u32, columns: u32, at: impl Fn(f32, f32) -> [f32; 3]) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..columns {
            let angle = std::f32::consts::TAU * column as f32 / columns as f32;
            mesh.positions.push(at(row as f32 / rows as f32, angle));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let position = |row: u32, column: u32| row * columns + column % columns;
            let [a, b] = [position(row, column), position(row, column + 1)];
            let [c, d] = [position(row + 1, column), position(row + 1, column + 1)];
            mesh.indices.extend([[a, b, d], [a, d, c]]);
        }
    }
    mesh
}

/// A stadium `ratio` times as large as the pot of 12,800 triangles in its middle, which is two wide.
fn stadium(ratio: f32) -> Scene {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::matte("", [0.5; 3]));
    let pot = tube(80, 80, |along, angle| {
        let (sin, cos) = angle.sin_cos();
        let height = 1.6 * along;
        let radius = (0.35 + 0.65 * (2.6 * along + 0.3).sin()) * (1.0 + 0.02 * (9.0 * angle).sin());
        [radius * cos, height, radius * sin]
    });
    // Steps, whose treads and risers are long and thin.
    let steps = 48;
    let bowl = tube(2 * steps, 96, |along, angle| {
        let row = (along * 2.0 * steps as f32).round();
        let (out, up) = (((row + 1.0) / 2.0).floor(), (row / 2.0).floor());
        let radius = ratio * (0.55 + 0.45 * out / steps as f32);
        [1.3 * radius * angle.cos(), 0.4 * ratio * up / steps as f32, radius * angle.sin()]
    });
    let field = tube(1, 4, |along, angle| {
        let radius = ratio * (0.001 + 0.75 * along);
        [1.3 * radius * angle.cos(), -1e-3, radius * angle.sin()]
    });
    for mesh in [pot, bowl, field] {
        let mesh = scene.add_mesh(Mesh { material, ..mesh });
        let object = scene.add_object_of("", vec![mesh]);
        scene.instantiate(object, Affine::IDENTITY);
    }
    scene.add_camera(Camera {
        name: String::new(),
        eye: [2.5, 1.6, 3.0],
        target: [0.0, 0.8, 0.0],
        up: [0.0, 1.0, 0.0],
        fov_y: 45.0,
        ..Camera::default()
    });
    scene
}

/// Measures stadiums of these ratios.
///
/// # Errors
/// [`Error::NoResearch`] without the other structures; as [`rays::run`](crate::rays::run).
pub fn run(
    ratios: &[f32],
    options: &Options,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<DynamicRow>, Error> {
    let mut rows = Vec::new();
    for &ratio in ratios {
        let subject = Subject::new(&format!("stadium-{ratio}"), &stadium(ratio));
        rows.extend(measure(&subject, options, report)?);
    }
    Ok(rows)
}

fn measure(
    subject: &Subject,
    options: &Options,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<DynamicRow>, Error> {
    let mut structures = OTHERS
        .into_iter()
        .map(|name| Ok((name, research::require(name)?)))
        .collect::<Result<Vec<_>, Error>>()?;
    structures.push(("bvh", Structure::Bvh));
    let build = |structure| {
        let options = BuildOptions { structure, ..BuildOptions::default() };
        ObjectTree::build(&[subject.triangles()], &options, Threads::Single)
    };
    let mut trees: Vec<ObjectTree> = structures.iter().map(|&(_, structure)| build(structure)).collect();
    let mut updates = vec![Vec::new(); trees.len()];
    for _ in 0..options.rounds {
        for (i, tree) in trees.iter_mut().enumerate() {
            let old = tree.clone();
            let before = process_seconds();
            *tree =
                old.refit(&[subject.triangles()], Threads::Single).unwrap_or_else(|_| build(structures[i].1));
            updates[i].push(process_seconds() - before);
        }
    }
    let reference = &trees[trees.len() - 1];
    let maker = RayMaker::new(subject, options.size, reference, options.level)?;
    let query_kind = QueryKind::Batch(Coherence::Incoherent);
    let contestants: Vec<Contestant> = trees
        .iter()
        .zip(&structures)
        .map(|(tree, &(strategy, _))| Contestant {
            engine: "gnurt",
            mode: strategy.into(),
            isa: options.level.name(),
            tracer: Box::new(OwnEngine { tree, query_kind, level: options.level }),
        })
        .collect();
    let ray_options = RayOptions::default();
    let mut seconds = vec![vec![0.0; options.rounds]; trees.len()];
    let (mut count, mut hits) = (0, vec![0; trees.len()]);
    for class in [Class::Primary, Class::Diffuse] {
        let rays = Rays::new(maker.rays(class, ray_options.batch), false, subject.triangles());
        let what = format!("{} {class}", subject.name);
        let sums = check(&what, &rays, &contestants, ray_options.tolerance, report)?;
        count += rays.len();
        for (hits, sums) in hits.iter_mut().zip(sums) {
            *hits += sums.hits;
        }
        for angle in 0..options.rounds * trees.len() {
            let round = angle / trees.len();
            let i = (angle + round) % trees.len();
            seconds[i][round] += time(&*contestants[i].tracer, &rays, 1).cpu;
        }
    }
    let row = |(i, tree): (usize, &ObjectTree)| {
        let stats = tree.stats();
        let is_refitted = structures[i].0 != "kd";
        DynamicRow {
            case: "stadium",
            scene: subject.name.clone(),
            strategy: structures[i].0,
            engine: "gnurt",
            threads: 1,
            triangles: subject.triangle_count() as u64,
            instances: 1,
            update_ms_cpu: 1e3 * median(&updates[i]),
            trace_mrays_cpu: count as f64 / 1e6 / median(&seconds[i]).max(1e-9),
            bytes: Some(stats.tree_bytes + stats.primitive_bytes),
            hits: hits[i],
            rebuilds: if is_refitted { 0 } else { options.rounds },
        }
    };
    Ok(trees.iter().enumerate().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_see_the_same() {
        let options = Options { rounds: 1, size: 48, level: Level::best() };
        let rows = run(&[50.0], &options, &mut |_| {}).expect("they agree");
        assert_eq!(rows.len(), OTHERS.len() + 1, "a row each");
        assert!(rows.iter().all(|row| row.hits == rows[0].hits && row.hits > 1000), "{rows:?}");
    }
}
