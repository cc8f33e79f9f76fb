// SPDX-License-Identifier: GPL-3.0-or-later
//! Nearest points equal brute force over all primitives, in every structure and at every level, through instances that
//! turn, scale, shear and mirror, in nested scenes, within a radius, by masks.

use std::sync::Arc;

use crate::common::{TESTS, WATERTIGHT, build, options, scene_of};
use gnurt_accel::{
    Geometry, Instance, Level, ObjectTree, PointHit, Quads, Query, Spheres, Threads, Triangles,
};
use gnurt_testkit::{Random, Soup, closed};

type Columns = [[f64; 3]; 4];

/// The distance from the origin to a triangle by plain reasoning: the plane where it is met inside, else the edges.
fn distance(corners: [[f64; 3]; 3]) -> f64 {
    let [a, b, c] = corners;
    let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let n = cross(minus(b, a), minus(c, a));
    let inside =
        [(a, b), (b, c), (c, a)].iter().all(|&(p, q)| dot(cross(minus(q, p), p.map(|x| -x)), n) >= 0.0);
    if inside {
        return dot(a, n).abs() / dot(n, n).sqrt();
    }
    let edge = |(p, q): ([f64; 3], [f64; 3])| {
        let along = minus(q, p);
        let f = (-dot(along, p) / dot(along, along)).clamp(0.0, 1.0);
        let at = [0, 1, 2].map(|k| p[k] + f * along[k]);
        dot(at, at).sqrt()
    };
    [(a, b), (b, c), (c, a)].map(edge).into_iter().fold(f64::INFINITY, f64::min)
}

fn carry(columns: &Columns, p: [f32; 3], point: [f64; 3]) -> [f64; 3] {
    let p = p.map(f64::from);
    [0, 1, 2].map(|k| {
        columns[0][k] * p[0] + columns[1][k] * p[1] + columns[2][k] * p[2] + columns[3][k] - point[k]
    })
}

/// Distances to all triangles of all instances, with their ids: instance, mesh, triangle.
fn distances(instances: &[(&[Soup], Columns)], point: [f64; 3]) -> Vec<(f64, [u32; 3])> {
    let mut all = Vec::new();
    for (i, (meshes, columns)) in instances.iter().enumerate() {
        for (g, mesh) in meshes.iter().enumerate() {
            for p in 0..mesh.indices.len() {
                let corners =
                    mesh.corners(p).expect("a triangle").map(|corner| carry(columns, corner, point));
                all.push((distance(corners), [i, g, p].map(|id| id as u32)));
            }
        }
    }
    all
}

/// The same answer at every level; it is as near as the nearest of `all`, and on the primitive that it names.
fn check(
    run_queries: impl Fn(&Query, f64) -> Option<PointHit>,
    all: &[(f64, [u32; 3])],
    point: [f64; 3],
    tolerance: f64,
) {
    let nearest = all.iter().map(|(d, _)| *d).fold(f64::INFINITY, f64::min);
    let mut first = None;
    for level in Level::available() {
        let query = Query { level, ..Query::default() };
        let hit = run_queries(&query, f64::INFINITY).expect("something is nearest");
        assert_eq!(*first.get_or_insert(hit), hit, "{point:?} at {level}");
        assert!((hit.distance - nearest).abs() < tolerance, "{hit:?} of {point:?}, not {nearest}");
        let off = [0, 1, 2].map(|k| hit.point[k] - point[k]).iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((off - hit.distance).abs() < 1e-9 * (1.0 + off), "{hit:?} is that far from {point:?}");
        let ids = [hit.inst_id, hit.geom_id, hit.prim_id];
        let own = all.iter().find(|(_, known)| *known == ids).expect("a known triangle").0;
        assert!((own - hit.distance).abs() < tolerance, "{hit:?} is {own} away from {point:?}");
        assert_eq!(
            run_queries(&query, hit.distance * (1.0 + 1e-9)),
            Some(hit),
            "within a radius that is just enough"
        );
        assert_eq!(
            run_queries(&query, hit.distance * (1.0 - 1e-9) - 1e-300),
            None,
            "and not within a smaller one"
        );
    }
}

fn some_points(seed: u64, n: usize) -> Vec<[f64; 3]> {
    let mut random = Random::new(seed);
    (0..n)
        .map(|_| {
            let size = random.pick(&[0.2, 1.0, 1.0, 3.0, 50.0]);
            random.point().map(|x| f64::from(size * x))
        })
        .collect()
}

#[test]
fn objects_equal_brute_force() {
    for (kind, _) in TESTS {
        let tolerance = if kind.2 == gnurt_accel::TriangleTest::Projected { 1e-4 } else { 1e-12 };
        for meshes in [
            vec![Soup::random(1, 1, 1.0)],
            vec![Soup::random(2, 300, 0.3), Soup::random(3, 40, 0.8)],
            vec![closed::sphere(12)],
            vec![closed::cube(3)],
        ] {
            let object = build(&meshes, kind);
            let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
            for point in some_points(4, 60) {
                let all = distances(&[(&meshes, identity)], point);
                let scale = 1.0 + point[0].abs();
                check(
                    |query, radius| object.closest_point_with(query, point, radius),
                    &all,
                    point,
                    tolerance * scale,
                );
            }
        }
    }
}

/// Any affine map: turned, scaled, sheared, mirrored; `even` ones keep shapes.
fn any_map(random: &mut Random, even: bool) -> Columns {
    let (s, c) = random.between(0.0, 6.3).sin_cos();
    let size = random.between(0.2, 1.5);
    let mut columns = [[0.0; 3]; 4];
    for (column, axis) in columns.iter_mut().zip([[c, s, 0.0], [0.0, 0.0, 1.0], [s, -c, 0.0]]) {
        let stretch = if even { size } else { random.between(0.05, 2.0) };
        *column = axis.map(|x| f64::from(x * stretch));
    }
    if !even {
        columns[1][0] += f64::from(random.between(-0.5, 0.5));
    }
    columns[3] = random.point().map(|x| f64::from(2.0 * x));
    columns
}

#[test]
fn scenes_equal_brute_force() {
    for kind in WATERTIGHT {
        let shapes = [[closed::sphere(7)], [Soup::random(1, 60, 0.4)]];
        let objects: Vec<Arc<ObjectTree>> = shapes.iter().map(|s| Arc::new(build(s, kind))).collect();
        for (n, even) in [(1, false), (3, true), (40, false)] {
            let mut random = Random::new(n as u64);
            let maps: Vec<Columns> = (0..n).map(|_| any_map(&mut random, even)).collect();
            let instance = |(i, map): (usize, &Columns)| Instance::new(Arc::clone(&objects[i % 2]), *map);
            let instances: Vec<Instance> = maps.iter().enumerate().map(instance).collect();
            let scene = Arc::new(scene_of(&instances));
            let plain: Vec<(&[Soup], Columns)> =
                maps.iter().enumerate().map(|(i, map)| (&shapes[i % 2][..], *map)).collect();

            // The same scene in another one, by an uneven map.
            let outer = any_map(&mut random, false);
            let nested = scene_of(&[
                Instance::identity(Arc::new(scene_of(&[]))),
                Instance::new(Arc::clone(&scene), outer),
            ]);
            let outward = |map: &Columns| {
                let linear = |v: &[f64; 3]| {
                    [0, 1, 2].map(|k| outer[0][k] * v[0] + outer[1][k] * v[1] + outer[2][k] * v[2])
                };
                let placement = linear(&map[3]);
                let moved = [0, 1, 2].map(|k| placement[k] + outer[3][k]);
                [linear(&map[0]), linear(&map[1]), linear(&map[2]), moved]
            };
            let composed: Vec<(&[Soup], Columns)> =
                plain.iter().map(|(meshes, map)| (*meshes, outward(map))).collect();
            for point in some_points(5, 40) {
                let tolerance = 1e-10 * (1.0 + point[0].abs());
                let all = distances(&plain, point);
                check(|query, radius| scene.closest_point_with(query, point, radius), &all, point, tolerance);
                let all = distances(&composed, point);
                let run_queries = |query: &Query, radius: f64| {
                    let hit = nested.closest_point_with(query, point, radius)?;
                    assert_eq!(hit.inst_id, 1, "the outer instance");
                    Some(PointHit { inst_id: hit.leaf_id, ..hit })
                };
                check(run_queries, &all, point, tolerance);
            }
        }
    }
}

#[test]
fn spheres_quads_and_masks() {
    let mut random = Random::new(6);
    let centers: Vec<[f32; 3]> = (0..80).map(|_| random.point()).collect();
    let radii: Vec<f32> = centers.iter().map(|_| random.between(0.02, 0.3)).collect();
    let positions = [[-2.0, -2.0, -2.0], [2.0, -2.0, -2.0], [2.0, 2.0, -2.0], [-2.0, 2.0, -2.0]];
    let flat = Triangles { positions: &positions, indices: &[[0, 1, 2]] };
    for kind in WATERTIGHT {
        let object = ObjectTree::build_from(
            &[
                Geometry::from(flat).with_mask(2),
                Spheres { centers: &centers, radii: &radii }.into(),
                Quads { positions: &positions, indices: &[[0, 1, 2, 3]] }.into(),
            ],
            &options(kind),
            Threads::Single,
        );
        for point in some_points(7, 200) {
            let to_sphere = |(c, r): (&[f32; 3], &f32)| {
                let square = (0..3).map(|k| (f64::from(c[k]) - point[k]).powi(2)).sum::<f64>();
                (square.sqrt() - f64::from(*r)).abs()
            };
            let spheres = centers.iter().zip(&radii).map(to_sphere).fold(f64::INFINITY, f64::min);
            let beyond = [0, 1].map(|k| point[k] - point[k].clamp(-2.0, 2.0));
            let quad = (beyond[0].powi(2) + beyond[1].powi(2) + (point[2] + 2.0).powi(2)).sqrt();
            for level in Level::available() {
                let query = Query { level, mask: 1, ..Query::default() };
                let hit = object.closest_point_with(&query, point, f64::INFINITY).expect("something");
                let expected = spheres.min(quad);
                assert!(
                    (hit.distance - expected).abs() < 1e-9 * (1.0 + expected),
                    "{hit:?}: {spheres}, {quad}"
                );
                assert_eq!(hit.geom_id, if spheres < quad { 1 } else { 2 }, "{hit:?}");
                if hit.geom_id == 2 {
                    let [u, v] = [hit.u, hit.v].map(|x| f64::from(4.0 * x - 2.0));
                    let off = (u - hit.point[0]).abs() + (v - hit.point[1]).abs();
                    assert!(off < 1e-5, "u and v of the quad tell the place of {hit:?}");
                }
            }
        }
    }
}

#[test]
fn nothing_is_near_nothing() {
    let empty = build(&[], WATERTIGHT[0]);
    assert_eq!(empty.closest_point([0.0; 3], f64::INFINITY), None, "an empty object");
    assert_eq!(scene_of(&[]).closest_point([0.0; 3], f64::INFINITY), None, "an empty scene");
    for kind in WATERTIGHT {
        let object = build(&[closed::cube(1)], kind);
        for point in [[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0]] {
            assert_eq!(object.closest_point(point, f64::INFINITY), None, "{point:?} is nowhere");
        }
        assert_eq!(object.closest_point([0.0; 3], f64::NAN), None, "no radius");
        assert_eq!(object.closest_point([5.0; 3], -1.0), None, "a negative radius");
        let far = object.closest_point([1e30, 0.0, 0.0], f64::INFINITY).expect("far away");
        assert!((far.distance - 1e30).abs() < 1e18, "{far:?}");
    }
}
