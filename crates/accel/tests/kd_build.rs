// SPDX-License-Identifier: GPL-3.0-or-later
//! The builder: one tree for any number of threads, bounded depth and size.

use crate::common::build_with;
use gnurt_accel::{BuildOptions, Structure, Threads};
use gnurt_testkit::{Soup, closed};

#[test]
fn any_number_of_threads_builds_the_same_tree() {
    for soup in [Soup::random(1, 20_000, 0.05), Soup::grid(2, 8_000), closed::torus(90)] {
        let meshes = [soup];
        let options = BuildOptions { structure: Structure::Kd, ..BuildOptions::default() };
        let single = build_with(&meshes, &options, Threads::Single);
        for threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let joint = build_with(&meshes, &options, Threads::Pool(&pool));
            assert!(single.same_tree(&joint), "{threads} threads build {:?}", joint.stats());
            let from_inside = pool.install(|| build_with(&meshes, &options, Threads::Pool(&pool)));
            assert!(single.same_tree(&from_inside), "called from inside a pool of {threads}");
        }
    }
}

#[test]
fn depth_and_references_are_bounded() {
    let options = BuildOptions {
        structure: Structure::Kd,
        triangle_cost: 1e6,
        reference_budget: 2.0,
        max_depth: 1000,
        ..BuildOptions::default()
    };
    for soup in [Soup::copies(1000), Soup::random(3, 3000, 1.0), Soup::slivers(4, 2000)] {
        let n = soup.indices.len() as u64;
        let stats = build_with(&[soup], &options, Threads::Single).stats();
        assert!(stats.depth < 64, "{stats:?} fits a traversal stack");
        assert!(stats.references <= 2 * n, "{stats:?} keeps the budget");
    }
}

#[test]
fn a_tree_is_cheaper_than_no_tree() {
    let options = BuildOptions { structure: Structure::Kd, ..BuildOptions::default() };
    let stats = build_with(&[closed::sphere(60)], &options, Threads::Single).stats();
    let flat = f64::from(BuildOptions::default().triangle_cost) * stats.primitives as f64;
    assert!(stats.sah_cost < flat / 20.0, "{stats:?} against {flat} without a tree");
    assert!(stats.nodes == 2 * stats.leaves - 1, "{stats:?} is binary");
}
