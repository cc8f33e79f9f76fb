// SPDX-License-Identifier: GPL-3.0-or-later
//! Quads, spheres, discs and curves that move while the shutter is open have the hits of a static tree over all of them
//! at the ray's time; so have ranges of times, and transforms whose entries go straight.

use std::sync::Arc;

use gnurt_accel::{
    BuildOptions, CurveBasis, CurveForm, Curves, Discs, Geometry, Hit, Instance, KeyInterval, MotionPath,
    MovingQuads, ObjectTree, Quads, Query, Ray, SceneTree, Spheres, Threads,
};
use gnurt_testkit::{Random, rays};

use crate::common::QueryTarget;

const TIMES: [f32; 5] = [0.0, 0.3, 0.5, 0.81, 1.0];

type Row = [f32; 4];

/// Positions and radii at three keys.
fn drifting(seed: u64, count: usize) -> Vec<Vec<Row>> {
    let mut random = Random::new(seed);
    let mut key: Vec<Row> = Vec::new();
    for i in 0..count {
        // Every four are near to each other, for curves and quads.
        let (near, from) = (random.point(), if i % 4 == 0 { None } else { key.last().copied() });
        let at = |k: usize| from.map_or(near[k], |from| from[k] + 0.3 * (near[k] - 0.5));
        key.push([at(0), at(1), at(2), random.between(0.02, 0.08)]);
    }
    let mut moved = |key: &[Row]| -> Vec<Row> {
        let drift = |row: &Row| {
            let by = random.point();
            [0, 1, 2, 3]
                .map(|k| if k < 3 { row[k] + 0.5 * (by[k] - 0.5) } else { row[3] * (0.7 + 0.3 * by[0]) })
        };
        key.iter().map(drift).collect()
    };
    let second = moved(&key);
    let third = moved(&second);
    vec![key, second, third]
}

fn between(keys: &[Vec<Row>], time: f32) -> Vec<Row> {
    let interval = KeyInterval::of(time, keys.len());
    let (from, to) = (&keys[interval.key], &keys[interval.next]);
    from.iter().zip(to).map(|(from, to)| [0, 1, 2, 3].map(|k| interval.mix(from[k], to[k]))).collect()
}

/// Arrays of one key.
struct Arrays {
    rows: Vec<Row>,
    positions: Vec<[f32; 3]>,
    radii: Vec<f32>,
}

impl Arrays {
    fn new(rows: &[Row]) -> Self {
        let positions = rows.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
        Self { rows: rows.to_vec(), positions, radii: rows.iter().map(|row| row[3]).collect() }
    }
}

fn tree(geometry: Geometry) -> Arc<ObjectTree> {
    Arc::new(ObjectTree::build_from(&[geometry], &BuildOptions::default(), Threads::Single))
}

/// Rays that aim at the unit cube.
fn some_rays() -> Vec<Ray> {
    rays::random(9, 600).into_iter().map(|(org, dir)| Ray::new(org, dir)).collect()
}

fn same(a: Option<Hit>, b: Option<Hit>, allowed: f32) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => {
            let close = |x: f32, y: f32| (x - y).abs() <= allowed * (1.0 + x.abs());
            a.primitive() == b.primitive() && close(a.t, b.t) && close(a.u, b.u) && close(a.v, b.v)
        }
        (None, None) => true,
        _ => false,
    }
}

/// Compares a moving tree with static ones. Of curves and spheres, which are tested by other code than static ones, a few
/// rays may touch or miss.
fn compare(name: &str, moving: &Arc<ObjectTree>, still: &dyn Fn(f32) -> Arc<ObjectTree>, exact: bool) {
    let rays = some_rays();
    let (mut hits, mut others) = (0, 0);
    for time in TIMES {
        let (still, stopped) = (still(time), moving.at(time));
        for ray in &rays {
            let ray = ray.with_time(time);
            let (found, expected) = (moving.intersect(&ray), still.intersect(&ray));
            hits += usize::from(expected.is_some());
            assert_eq!(found, stopped.intersect(&ray), "{name} stopped at {time}: {ray:?}");
            if !same(found, expected, if exact { 0.0 } else { 1e-4 }) {
                others += 1;
                continue;
            }
            assert_eq!(moving.occluded(&ray), still.occluded(&ray), "{name} at {time}: {ray:?}");
            let (Some(found), Some(expected)) = (found, expected) else { continue };
            let at = ray.at(found.t).map(f64::from);
            let normal = stopped.normal_at(&found, at);
            let same_normal = match (normal, still.normal_at(&expected, at)) {
                (Some(a), Some(b)) => (0..3).all(|k| (a[k] - b[k]).abs() < 1e-2),
                (a, b) => a.is_none() == b.is_none(),
            };
            assert!(same_normal, "{name} at {time}: {normal:?}");
            if exact {
                assert_eq!(moving.all(&ray), still.all(&ray), "all hits of {name} at {time}: {ray:?}");
            }
        }
    }
    assert!(hits > 200, "{name}: {hits} hits are enough to compare");
    assert!(others * 200 <= hits && (!exact || others == 0), "{name}: {others} of {hits} hits differ");
}

#[test]
fn quads() {
    let keys = drifting(1, 400);
    let indices: Vec<[u32; 4]> = (0..100).map(|i| [0, 1, 2, 3].map(|k| 4 * i + k)).collect();
    let arrays: Vec<Arrays> = keys.iter().map(|key| Arrays::new(key)).collect();
    let lists: Vec<&[[f32; 3]]> = arrays.iter().map(|one| &one.positions[..]).collect();
    let moving = tree(MovingQuads { keys: &lists, indices: &indices }.into());
    let still = |time: f32| {
        let now = Arrays::new(&between(&keys, time));
        tree(Quads { positions: &now.positions, indices: &indices }.into())
    };
    compare("quads", &moving, &still, true);
}

#[test]
fn spheres_and_discs() {
    let keys = drifting(2, 300);
    let arrays: Vec<Arrays> = keys.iter().map(|key| Arrays::new(key)).collect();
    fn spheres(one: &Arrays) -> Spheres<'_> {
        Spheres { centers: &one.positions, radii: &one.radii }
    }
    let moving = tree(Geometry::moving_spheres(&arrays.iter().map(spheres).collect::<Vec<_>>()));
    let still = |time: f32| tree(spheres(&Arrays::new(&between(&keys, time))).into());
    compare("spheres", &moving, &still, false);

    let directions = drifting(3, 300);
    let normals = |rows: &[Row]| -> Vec<[f32; 3]> { rows.iter().map(|&[x, y, z, _]| [x, y, z]).collect() };
    for has_normals in [false, true] {
        let all: Vec<Vec<[f32; 3]>> = directions.iter().map(|key| normals(key)).collect();
        let discs = |(one, normals): (&'_ Arrays, &'_ Vec<[f32; 3]>)| -> Geometry<'static> {
            let discs = Discs {
                centers: &one.positions,
                radii: &one.radii,
                normals: has_normals.then_some(&normals[..]),
            };
            Geometry::moving_discs(&[discs])
        };
        let lists: Vec<Discs> = arrays
            .iter()
            .zip(&all)
            .map(|(one, normals)| Discs {
                centers: &one.positions,
                radii: &one.radii,
                normals: has_normals.then_some(&normals[..]),
            })
            .collect();
        let moving = tree(Geometry::moving_discs(&lists));
        let still = |time: f32| {
            let (now, towards) = (Arrays::new(&between(&keys, time)), normals(&between(&directions, time)));
            let normals = has_normals.then_some(&towards[..]);
            tree(Discs { centers: &now.positions, radii: &now.radii, normals }.into())
        };
        compare("discs", &moving, &still, false);
        // One key stands still.
        let only = tree(discs((&arrays[0], &all[0])));
        compare("discs of one key", &only, &|_| still(0.0), false);
    }
}

#[test]
fn curves() {
    let keys = drifting(4, 480);
    for basis in [CurveBasis::Linear, CurveBasis::Bezier, CurveBasis::BSpline, CurveBasis::CatmullRom] {
        for form in [CurveForm::Flat, CurveForm::Round] {
            let indices: Vec<u32> = (0..120).map(|i| 4 * i).collect();
            let curves = |key: &[Row]| -> (Vec<Row>, Vec<u32>) { (Arrays::new(key).rows, indices.clone()) };
            let owned: Vec<_> = keys.iter().map(|key| curves(key)).collect();
            let lists: Vec<Curves> =
                owned.iter().map(|(rows, indices)| Curves::new(basis, form, rows, indices)).collect();
            let moving = tree(Geometry::moving_curves(&lists));
            let still = |time: f32| {
                let (rows, indices) = curves(&between(&keys, time));
                tree(Curves::new(basis, form, &rows, &indices).into())
            };
            compare(&format!("{basis:?} {form:?}"), &moving, &still, false);
        }
    }
}

#[test]
fn ranges_of_times() {
    let keys = drifting(5, 400);
    let indices: Vec<[u32; 4]> = (0..100).map(|i| [0, 1, 2, 3].map(|k| 4 * i + k)).collect();
    let arrays: Vec<Arrays> = keys.iter().map(|key| Arrays::new(key)).collect();
    let lists: Vec<&[[f32; 3]]> = arrays.iter().map(|one| &one.positions[..]).collect();
    let quads = || -> Geometry { MovingQuads { keys: &lists, indices: &indices }.into() };
    let whole = tree(quads());
    // Powers of two, so that the arithmetic is exact.
    for times in [[0.25, 0.75], [-1.0, 1.0], [0.5, 2.5]] {
        let part = tree(quads().within(times));
        for time in [0.0, 0.25, 0.375, 0.5, 0.75, 1.0] {
            let is_there = time >= times[0] && time <= times[1];
            let local = (time - times[0]) / (times[1] - times[0]);
            for ray in some_rays() {
                let expected = whole.intersect(&ray.with_time(local)).filter(|_| is_there);
                let ray = ray.with_time(time);
                assert_eq!(part.intersect(&ray), expected, "{times:?} at {time}");
                assert_eq!(part.at(time).intersect(&ray), expected, "{times:?} stopped at {time}");
            }
        }
    }
}

#[test]
fn straight_transforms() {
    let keys = drifting(6, 400);
    let indices: Vec<[u32; 4]> = (0..100).map(|i| [0, 1, 2, 3].map(|k| 4 * i + k)).collect();
    let now = Arrays::new(&keys[0]);
    let object = tree(Quads { positions: &now.positions, indices: &indices }.into());
    let places = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]],
        [[0.25, 1.0, 0.0], [-1.0, 0.25, 0.5], [0.0, 0.0, 2.0], [1.0, 0.5, -0.5]],
        [[0.5, 0.0, 0.25], [0.0, 0.5, 0.0], [-0.25, 0.0, 0.5], [0.0, 0.0, 0.5]],
    ];
    let scene = |instance| SceneTree::build(&[instance], &BuildOptions::default(), Threads::Single);
    let (query, mut hits) = (Query::default(), 0);
    for times in [[0.0, 1.0], [0.25, 0.75], [-1.0, 3.0]] {
        let path = MotionPath::straight(&places).expect("they have inverses").within(times);
        let moving = scene(Instance::moving(Arc::clone(&object), Arc::new(path)));
        for time in [0.0, 0.25, 0.3, 0.5, 0.7, 1.0_f32] {
            let is_there = time >= times[0] && time <= times[1];
            let interval = KeyInterval::of((time - times[0]) / (times[1] - times[0]), 3);
            let (from, to, by) =
                (&places[interval.key], &places[interval.next], f64::from(interval.weights[1]));
            let mixed: [[f64; 3]; 4] =
                std::array::from_fn(|c| std::array::from_fn(|k| (1.0 - by) * from[c][k] + by * to[c][k]));
            let still = scene(Instance::new(Arc::clone(&object), mixed));
            for ray in some_rays() {
                let ray = ray.with_time(time);
                let expected = still.one(&query, &ray).filter(|_| is_there);
                hits += usize::from(expected.is_some());
                let found = moving.one(&query, &ray);
                assert!(same(found, expected, 1e-4), "{times:?} at {time}: {found:?}, not {expected:?}");
            }
        }
    }
    assert!(hits > 200, "{hits} hits are enough to compare");
}
