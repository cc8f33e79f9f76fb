// SPDX-License-Identifier: GPL-3.0-or-later
//! Every tree hit equals brute force: all soups, both triangle tests, single rays and packets at every level.
//! Source: original.

mod common;

use common::{TESTS, ask, assert_hits, batch, build};
use gnurt_testkit::{OracleInstance, Soup, rays};

fn check(name: &str, meshes: &[Soup], rays: &[rays::PlainRay]) {
    for (test, margin) in TESTS {
        let object = build(meshes, test);
        let rays = batch(rays);
        let hits = ask(&object, &rays);
        let found = hits.iter().flatten().count();
        assert!(found > 0, "{name}: no ray of {} hits anything with {test:?}", rays.len());
        assert_hits(&[OracleInstance::identity(meshes)], &rays, &hits, margin);
    }
}

#[test]
fn random_soups() {
    for (seed, n, size) in [(1, 1, 1.0), (2, 7, 0.8), (3, 60, 0.5), (4, 400, 0.1), (5, 800, 0.4)] {
        check("random", &[Soup::random(seed, n, size)], &rays::random(seed, 400));
    }
}

#[test]
fn several_meshes() {
    let meshes = [Soup::random(6, 50, 0.3), Soup::default(), Soup::grid(7, 50), Soup::random(8, 1, 0.9)];
    check("several", &meshes, &rays::random(9, 400));
}

#[test]
fn grids_of_axis_aligned_triangles() {
    check("grid", &[Soup::grid(10, 300)], &rays::random(11, 600));
}

#[test]
fn degenerate_soups() {
    for seed in 12..18 {
        let soup = Soup::degenerate(seed, 120);
        let bad = build(std::slice::from_ref(&soup), TESTS[0].0).bad_primitives();
        assert!(bad.total() > 10, "bad triangles are counted: {bad:?}");
        check("degenerate", &[soup], &rays::random(seed, 300));
    }
}

#[test]
fn slivers() {
    let meshes = [Soup::slivers(19, 300)];
    for (test, _) in TESTS {
        // Weights across a sliver are as uncertain as it is thin: only places are compared.
        let object = build(&meshes, test);
        let rays = batch(&rays::aimed(&meshes[0], [0.1, 0.2, 3.0], 1));
        let hits = ask(&object, &rays);
        for hit in hits.iter().flatten() {
            assert!(hit.t > 0.0 && hit.t < 10.0, "{hit:?} lies in the soup");
        }
    }
}

#[test]
fn copies_of_one_triangle() {
    let object = build(&[Soup::copies(1000)], TESTS[0].0);
    let hits = ask(&object, &batch(&[([0.1, 0.0, 3.0], [0.0, 0.0, -1.0]), ([3.0; 3], [0.0, 1.0, 0.0])]));
    let hit = hits[0].expect("it aims at all of them");
    assert_eq!((hit.prim_id, hits[1]), (0, None), "the first of equals is reported");
    assert!(object.stats().references <= 6000, "{:?} keeps the budget", object.stats());
}

#[test]
fn nothing_is_hit_in_nothing() {
    for meshes in [vec![], vec![Soup::default()], vec![Soup { positions: vec![], indices: vec![[0, 1, 2]] }]]
    {
        let object = build(&meshes, TESTS[0].0);
        assert!(object.bounds().is_empty(), "no triangle, no box");
        let hits = ask(&object, &batch(&rays::random(20, 20)));
        assert!(hits.iter().all(Option::is_none), "and no hit");
    }
}

#[test]
fn far_from_the_origin() {
    // Coordinates near a million are multiples of 1/16: that is the soup which is traced, and the oracle sees it too.
    let offset = [1e6, -1e6, 5e5];
    let soup = Soup::random(21, 200, 30.0).moved(offset);
    let rays: Vec<_> = rays::random(22, 200)
        .into_iter()
        .map(|(org, dir)| ([0, 1, 2].map(|k| 40.0 * org[k] + offset[k]), dir))
        .collect();
    let meshes = [soup];
    let object = build(&meshes, TESTS[0].0);
    let rays = batch(&rays);
    assert_hits(&[OracleInstance::identity(&meshes)], &rays, &ask(&object, &rays), 1e-4);
}
