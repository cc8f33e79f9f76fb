// SPDX-License-Identifier: GPL-3.0-or-later
//! Sides of points, at corners, on edges and faces and beside them, equal those of integer arithmetic; signed
//! distances; batches with threads; solids that overlap.

use std::sync::Arc;

use gnurt_accel::{BuildOptions, Instance, Level, ObjectTree, Query, Ray64, Side, Spheres, Threads};
use gnurt_testkit::{Random, Soup, Voxels, Where, closed};

use crate::common::{WATERTIGHT, build, scene_of};

fn expected(placement: Where) -> Side {
    match placement {
        Where::Outside => Side::Outside,
        Where::Surface => Side::Surface,
        Where::Inside => Side::Inside,
    }
}

#[test]
fn solids_of_cubes_equal_whole_numbers() {
    for (round, kind) in WATERTIGHT.iter().cycle().take(14).enumerate() {
        let n = 1 + round as i64 % 4;
        let voxels = Voxels::random(round as u64, n as u32, [0.3, 0.6, 0.9][round % 3]);
        let (from, side) = [(0.0, 1.0), (65536.0, 0.25), (0.0, 2f32.powi(-90))][round % 3];
        let tree = build(&[voxels.mesh(round % 2 == 1, [from; 3], side)], *kind);
        let count = 2 * n + 3;
        let (mut points, mut sides) = (Vec::new(), Vec::new());
        for i in 0..count * count * count {
            let point = [i % count - 1, i / count % count - 1, i / count / count - 1];
            points.push(point.map(|x| f64::from(from) + 0.5 * f64::from(side) * x as f64));
            sides.push(expected(voxels.locate(point)));
            // By the least that a double can be off the surface, to either side.
            for towards in [1i64, -1] {
                let offset = point.map(|x| 4 * x + if x % 2 == 0 { towards } else { 0 });
                let cube = offset.map(|x| x.div_euclid(8));
                points.push([0, 1, 2].map(|k| {
                    let x: f64 = points[points.len() - if towards == 1 { 1 } else { 2 }][k];
                    if point[k] % 2 != 0 {
                        x
                    } else if towards == 1 {
                        x.next_up()
                    } else {
                        x.next_down()
                    }
                }));
                sides.push(expected(voxels.locate(cube.map(|x| 2 * x + 1))));
            }
        }
        let mut found = Vec::new();
        tree.side_batch(&Query::default(), &points, Threads::Single, &mut found);
        for ((point, side), found) in points.iter().zip(&sides).zip(&found) {
            assert_eq!(found, side, "{point:?} in {kind:?}, solid {round}");
        }
    }
}

#[test]
fn distances_are_negative_inside() {
    for kind in WATERTIGHT {
        let tree = build(&[closed::cube(2)], kind);
        for (point, distance) in [
            ([0.0, 0.0, 0.0], -1.0),
            ([0.75, 0.5, 0.0], -0.25),
            ([2.5, 0.0, 0.0], 1.5),
            ([4.0, 5.0, 0.5], 5.0),
            ([1.0, 0.3, 0.3], 0.0),
            ([1.0, 1.0, -1.0], 0.0),
        ] {
            for level in Level::available() {
                let query = Query { level, ..Query::default() };
                let found = tree.signed_distance_with(&query, point);
                assert!((found - distance).abs() < 1e-15, "{found} from {point:?}, not {distance}, {kind:?}");
            }
        }
        assert!(tree.signed_distance([f64::NAN, 0.0, 0.0]).is_nan(), "no point has no distance");
    }
    let empty = build(&[Soup::default()], WATERTIGHT[0]);
    assert_eq!(empty.signed_distance([0.0; 3]), f64::INFINITY, "nothing is near");
    assert!(!empty.contains([0.0; 3]), "nothing contains anything");
}

#[test]
fn batches_and_threads_agree() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
    let tree = build(&[closed::torus(24)], WATERTIGHT[0]);
    let mut random = Random::new(9);
    let points: Vec<[f64; 3]> = (0..3000).map(|_| random.point().map(|x| 1.6 * f64::from(x))).collect();
    let query = Query::default();
    for threads in [Threads::Single, Threads::Pool(&pool)] {
        let (mut sides, mut contained, mut occupied) = (Vec::new(), Vec::new(), Vec::new());
        let (mut distances, mut hits) = (Vec::new(), Vec::new());
        tree.side_batch(&query, &points, threads, &mut sides);
        tree.contains_batch(&query, &points, threads, &mut contained);
        tree.occupancy_batch(&query, &points, threads, &mut occupied);
        tree.signed_distance_batch(&query, &points, threads, &mut distances);
        tree.closest_points(&query, &points, 0.2, threads, &mut hits);
        let mut inside = 0;
        for (i, &point) in points.iter().enumerate() {
            // The ring itself, without the parts that its corners cut off.
            let from_ring = (point[0].hypot(point[1]) - 1.0).hypot(point[2]);
            if (from_ring - 0.4).abs() > 0.02 {
                assert_eq!(contained[i], from_ring < 0.4, "{point:?}");
            }
            assert_eq!(sides[i], tree.side(point), "{point:?}");
            assert_eq!(contained[i], tree.contains(point), "{point:?}");
            assert_eq!(occupied[i], tree.occupancy(point), "{point:?}");
            assert_eq!(distances[i], tree.signed_distance(point), "{point:?}");
            assert_eq!(distances[i] < 0.0, sides[i] == Side::Inside, "{point:?}");
            assert_eq!(hits[i], tree.closest_point(point, 0.2), "{point:?}");
            inside += usize::from(contained[i]);
        }
        assert!(inside > 200, "{inside} points are inside");
        let rays: Vec<Ray64> = points.iter().map(|&point| Ray64::new(point, [0.3, -0.2, 0.1])).collect();
        let mut counts = Vec::new();
        tree.crossings_batch(&query, &rays, threads, &mut counts);
        for (count, side) in counts.iter().zip(&sides) {
            assert_eq!(count % 2 == 1, *side == Side::Inside, "odd inside");
        }
    }
}

#[test]
fn objects_are_solids_of_their_own() {
    let at = |x: f64| [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [x, 0.0, 0.0]];
    let cube = Arc::new(build(&[closed::cube(1)], WATERTIGHT[0]));
    let balls = Spheres { centers: &[[0.0; 3], [0.5, 0.0, 0.0]], radii: &[1.0, 1.0] };
    let balls = ObjectTree::build_from(&[balls.into()], &BuildOptions::default(), Threads::Single);
    assert_eq!(balls.side([0.25, 0.0, 0.0]), Side::Inside, "in two balls");
    assert_eq!(balls.side([-1.0, 0.0, 0.0]), Side::Surface, "on one");
    assert_eq!(balls.side([1.0, 0.0, 0.0]), Side::Inside, "on one, in the other");
    let scene = scene_of(&[
        Instance::new(Arc::clone(&cube), at(0.0)),
        Instance::new(cube, at(1.0)),
        Instance::new(Arc::new(balls), at(9.0)),
    ]);
    for (point, side) in [
        ([0.5, 0.0, 0.0], Side::Inside),
        ([0.0, 0.0, 0.0], Side::Inside),
        ([2.0, 0.0, 0.0], Side::Surface),
        ([-0.5, 0.0, 0.0], Side::Inside),
        ([3.0, 0.0, 0.0], Side::Outside),
        ([9.5, 0.0, 0.0], Side::Inside),
    ] {
        assert_eq!(scene.side(point), side, "{point:?}");
        assert_eq!(scene.contains(point), side != Side::Outside, "{point:?}");
    }
    let meshes = [closed::cube(4), closed::cube(1)];
    let [outer, mut inner] = meshes;
    inner.positions.iter_mut().flatten().for_each(|x| *x *= 0.5);
    let hollow = build(&[outer, inner], WATERTIGHT[0]);
    assert_eq!(hollow.side([0.0; 3]), Side::Outside, "a hollow in the same object");
    assert_eq!(hollow.side([0.75, 0.0, 0.0]), Side::Inside, "between the two");
}
