// SPDX-License-Identifier: GPL-3.0-or-later
//! Guarantees of a traversal: it skips no triangle that the test by itself would hit, not by one rounding,
//! and it stops at the first leaf with a hit.

use crate::common::{GRID, Kind, TESTS, WATERTIGHT, batch, build_with, options, queries, run_queries};
use gnurt_accel::{
    BuildOptions, HitBatch, ObjectTree, Ray, RayBatch, Record, Structure, Threads, TriangleTest,
};
use gnurt_testkit::{Soup, closed, rays};

/// The tree of a soup; a kd-tree so deep that planes lie everywhere.
fn deep(soup: &Soup, kind: Kind) -> ObjectTree {
    let options = BuildOptions { max_depth: 40, triangle_cost: 4.0, ..options(kind) };
    build_with(std::slice::from_ref(soup), &options, Threads::Single)
}

/// A single leaf that tests every triangle.
fn flat(soup: &Soup, triangle_test: TriangleTest) -> ObjectTree {
    let options =
        BuildOptions { structure: Structure::Kd, triangle_test, max_depth: 0, ..BuildOptions::default() };
    build_with(std::slice::from_ref(soup), &options, Threads::Single)
}

#[test]
fn a_tree_hits_what_testing_every_triangle_hits() {
    // Rays at corners and edges, which is where the builder puts its planes. Far away, roundings are the largest.
    let soups = [closed::sphere(9), closed::cube(4), Soup::grid(1, 120), Soup::random(2, 150, 0.3)];
    for (soup, distance) in soups.iter().flat_map(|soup| [(soup, 0.0), (soup, 30.0), (soup, 1000.0)]) {
        let offset = [distance, -distance, 0.5 * distance];
        let soup = soup.clone().moved(offset);
        let views = [[0.1, 0.2, 0.05], [3.0, 1.0, -2.0], [-40.0, 90.0, 70.0]];
        let views =
            views.map(|from: [f32; 3]| batch(&rays::aimed(&soup, [0, 1, 2].map(|k| from[k] + offset[k]), 1)));
        for test in [TriangleTest::Watertight, TriangleTest::Projected] {
            let flat = flat(&soup, test);
            assert_eq!(flat.stats().depth, 0, "{:?}", flat.stats());
            let truth = views.each_ref().map(|rays| run_queries(&flat, rays));
            let kinds = TESTS.into_iter().map(|(kind, _)| kind).chain([GRID]);
            for kind in kinds.filter(|kind| kind.2 == test) {
                let tree = deep(&soup, kind);
                assert!(tree.stats().depth > 1 || tree.stats().nodes > 20, "{:?}", tree.stats());
                for (rays, truth) in views.iter().zip(&truth) {
                    for (i, (a, b)) in run_queries(&tree, rays).iter().zip(truth).enumerate() {
                        assert_eq!(a, b, "tree and plain list, {kind:?}, {:?}", rays.get(i));
                    }
                }
            }
        }
    }
}

#[test]
fn a_stack_of_walls_is_left_at_the_first() {
    for axis in 0..3 {
        let mut walls = Soup::default();
        for level in 0..512 {
            let at = |x: f32, y: f32| {
                let mut corner = [level as f32; 3];
                (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (x, y);
                corner
            };
            walls.push([at(-9.0, -9.0), at(20.0, -9.0), at(-9.0, 20.0)]);
        }
        let tree = deep(&walls, WATERTIGHT[3]);
        for (start, towards, first) in
            [(-5.0, 1.0, 0), (600.0, -1.0, 511), (100.5, 1.0, 101), (100.5, -1.0, 100)]
        {
            let rays: RayBatch = (0..8)
                .map(|i| {
                    let (mut org, mut dir) = ([0.1 * i as f32; 3], [0.01; 3]);
                    (org[axis], dir[axis]) = (start, towards);
                    Ray::new(org, dir)
                })
                .collect();
            for query in queries() {
                let (mut hits, mut record) = (HitBatch::default(), Record::default());
                tree.intersect_batch(&query, &rays, &mut hits, &mut record);
                assert!(hits.prim_id.iter().all(|&id| id == first), "{:?}, not {first}", hits.prim_id);
                let per_ray = [record.counters.nodes, record.counters.triangles].map(|n| n / 8);
                let depth = u64::from(tree.stats().depth);
                // Two blocks of eight, and a chunk of sixteen lanes for eight rays.
                let few = per_ray[0] <= 4 * depth && per_ray[1] <= 16;
                assert!(few, "{per_ray:?} nodes and triangles along {axis}, {towards}, {query:?}");
            }
        }
    }
}
