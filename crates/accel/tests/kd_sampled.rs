// SPDX-License-Identifier: GPL-3.0-or-later
//! The sampled build: the same hits as the exact one, the same tree for any number of threads, few more references.

use crate::common::{batch, build_with};
use gnurt_accel::{BuildOptions, HitBatch, ObjectTree, Quality, Query, Record, Structure, Threads};
use gnurt_testkit::{Soup, closed, rays};

fn options(quality: Quality) -> BuildOptions {
    BuildOptions { structure: Structure::Kd, quality, ..BuildOptions::default() }
}

fn soups() -> [Soup; 5] {
    [
        closed::sphere(40),
        closed::cube(9),
        Soup::grid(1, 4000),
        Soup::random(2, 9000, 0.1),
        Soup::slivers(3, 800),
    ]
}

#[test]
fn it_hits_what_the_exact_tree_hits() {
    for soup in soups() {
        let hits = |quality: Quality| {
            let tree: ObjectTree =
                build_with(std::slice::from_ref(&soup), &options(quality), Threads::Single);
            let mut aimed = rays::aimed(&soup, [0.3, 2.5, -0.2], 1);
            aimed.truncate(6000);
            aimed.extend(rays::random(4, 3000));
            let mut hits = HitBatch::default();
            tree.intersect_batch(&Query::default(), &batch(&aimed), &mut hits, &mut Record::default());
            (0..hits.len()).map(|i| hits.get(i)).collect::<Vec<_>>()
        };
        let (exact, sampled) = (hits(Quality::Medium), hits(Quality::Fast));
        assert!(exact.iter().flatten().count() > 500, "enough is hit");
        for (i, (a, b)) in exact.iter().zip(&sampled).enumerate() {
            assert_eq!(a, b, "ray {i}");
        }
    }
}

#[test]
fn any_number_of_threads_builds_the_same_tree() {
    for soup in [Soup::random(1, 20_000, 0.05), Soup::grid(2, 8_000), closed::torus(90)] {
        let meshes = [soup];
        let single = build_with(&meshes, &options(Quality::Fast), Threads::Single);
        for threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let joint = build_with(&meshes, &options(Quality::Fast), Threads::Pool(&pool));
            assert!(single.same_tree(&joint), "{threads} threads build {:?}", joint.stats());
        }
    }
}

#[test]
fn it_costs_little_more_and_keeps_its_bounds() {
    let mut compared = 0;
    for soup in soups() {
        let n = soup.indices.len() as u64;
        let meshes = [soup];
        let [exact, sampled] = [Quality::Medium, Quality::Fast]
            .map(|quality| build_with(&meshes, &options(quality), Threads::Single).stats());
        // Large triangles all over the place use up the budget where they are not cut as they are.
        if sampled.references < 4 * n {
            compared += 1;
            assert!(sampled.sah_cost < 1.4 * exact.sah_cost, "{sampled:?} against {exact:?}");
        }
        let tight = BuildOptions { triangle_cost: 1e6, reference_budget: 2.0, ..options(Quality::Fast) };
        let stats = build_with(&meshes, &tight, Threads::Single).stats();
        assert!(stats.depth < 64 && stats.references <= 2 * n, "{stats:?} keeps the budget of {n}");
    }
    assert!(compared >= 3, "{compared} trees are enough to tell");
}
