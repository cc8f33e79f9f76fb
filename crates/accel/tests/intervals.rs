// SPDX-License-Identifier: GPL-3.0-or-later
//! Interval hierarchies: hits are those of the other structures, bit for bit, and those of brute force, at every level, built and
//! refitted; and a small thing in a large one costs rays little.

use gnurt_accel::{
    BuildOptions, Memory, ObjectTree, Quality, Ray, RefitError, Structure, Threads, TriangleTest, Triangles,
};
use gnurt_testkit::{OracleInstance, Random, Soup, closed, rays};

use crate::common::{Kind, WATERTIGHT, assert_hits, batch, build, run_queries};

const fn kind(structure: Structure) -> Kind {
    Kind(structure, Quality::Medium, TriangleTest::Watertight, Memory::Fast)
}

const KINDS: [Kind; 3] = [kind(Structure::PlainBih), kind(Structure::Bih), kind(Structure::BKd)];

pub(crate) fn triangles(meshes: &[Soup]) -> Vec<Triangles<'_>> {
    meshes.iter().map(|m| Triangles { positions: &m.positions, indices: &m.indices }).collect()
}

/// Something small of many triangles in a box that is `ratio` times as large.
pub(crate) fn stadium(ratio: f32) -> [Soup; 2] {
    let mut small = closed::torus(40);
    small.positions.iter_mut().for_each(|p| *p = p.map(|x| 0.3 * x));
    let mut space = closed::cube(12);
    let (low, high) = space
        .positions
        .iter()
        .flatten()
        .fold((f32::MAX, f32::MIN), |(low, high), &x| (low.min(x), high.max(x)));
    let middle = 0.5 * (low + high);
    space.positions.iter_mut().for_each(|p| *p = p.map(|x| ratio * (x - middle) / (high - low)));
    [small, space]
}

pub(crate) fn check(tree: &ObjectTree, meshes: &[Soup], kind: Kind, seed: u64) {
    let mut all = rays::random(seed, 40);
    all.extend(rays::axis_parallel(seed, 2));
    let rays = batch(&all);
    let bvh = build(meshes, WATERTIGHT[0]);
    let hits = run_queries(tree, &rays);
    assert_eq!(hits, run_queries(&bvh, &rays), "those of a BVH: {kind:?}");
    assert_hits(&[OracleInstance::identity(meshes)], &rays, &hits, 2e-5);
    assert_eq!(tree.bad_primitives(), bvh.bad_primitives(), "{kind:?}");
    assert_eq!((tree.bounds(), tree.stats().primitives), (bvh.bounds(), bvh.stats().primitives), "{kind:?}");
    let mut random = Random::new(seed);
    for _ in 0..20 {
        let point = random.point().map(|x| 2.0 * f64::from(x));
        let nearest = |tree: &ObjectTree| tree.closest_point(point, f64::INFINITY).map(|near| near.distance);
        assert_eq!(nearest(tree), nearest(&bvh), "the nearest point to {point:?}: {kind:?}");
    }
    for i in 0..rays.len().min(40) {
        assert_eq!(tree.crossings(&rays.get(i)), bvh.crossings(&rays.get(i)), "what it crosses: {kind:?}");
    }
    for hit in hits.iter().flatten() {
        assert_eq!(tree.normal(hit), bvh.normal(hit), "and normals: {kind:?}");
    }
}

#[test]
fn hits_are_those_of_others() {
    let soups = [
        vec![Soup::random(1, 500, 0.3), Soup::random(2, 100, 0.02)],
        vec![Soup::grid(3, 12)],
        vec![Soup::slivers(4, 150)],
        vec![Soup::degenerate(5, 60)],
        vec![Soup::copies(40)],
        vec![Soup::random(6, 1, 1.0)],
        vec![Soup::default()],
        stadium(100.0).to_vec(),
    ];
    for (i, meshes) in soups.iter().enumerate() {
        for kind in KINDS {
            check(&build(meshes, kind), meshes, kind, i as u64);
        }
    }
}

#[test]
fn threads_make_no_difference() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    let meshes = [Soup::random(7, 9000, 0.05)];
    for Kind(structure, ..) in KINDS {
        let options = BuildOptions { structure, ..BuildOptions::default() };
        let of = |threads| ObjectTree::build(&triangles(&meshes), &options, threads);
        let single = of(Threads::Single);
        assert!(of(Threads::Pool(&pool)).same_tree(&single), "{structure:?}");
        let refitted =
            |threads| single.clone().refit(&triangles(&meshes), threads).expect("nothing has moved");
        assert!(refitted(Threads::Pool(&pool)).same_tree(&single), "{structure:?}");
        assert!(refitted(Threads::Single).same_tree(&single), "node for node: {structure:?}");
        assert_eq!(refitted(Threads::Single).cost_growth(), 1.0, "{structure:?}");
    }
}

#[test]
fn they_follow_what_moves() {
    for kind in KINDS {
        let mut meshes = [Soup::random(1, 300, 0.2), closed::torus(12)];
        let mut tree = build(&meshes, kind);
        let mut random = Random::new(3);
        for far in [0.02, 0.5] {
            for p in meshes.iter_mut().flat_map(|mesh| &mut mesh.positions) {
                let by = random.point();
                *p = [0, 1, 2].map(|k| p[k] + far * by[k]);
            }
            tree = tree.refit(&triangles(&meshes), Threads::Single).expect("it can be");
            check(&tree, &meshes, kind, 5);
        }
        assert!(tree.cost_growth() > 1.5, "neighbours are far apart now: {}, {kind:?}", tree.cost_growth());
        meshes[0].positions[7] = [f32::NAN; 3];
        let refused = tree.refit(&triangles(&meshes), Threads::Single).expect_err("one cannot be traced");
        assert_eq!(refused, RefitError::OtherPrimitives, "{refused}");
        let tree = build(&meshes, kind);
        let refused = tree.refit(&triangles(&meshes), Threads::Single).expect_err("one was left out");
        assert_eq!(refused, RefitError::OtherPrimitives, "{refused}");
        let mut file = Vec::new();
        let refused = build(&meshes, kind).save(&mut file).expect_err("not these");
        assert!(refused.to_string().contains("interval"), "{refused}");
    }
}

/// Rays that pass a small object in a large room do about as much work as under a kd-tree: boxes are compared
/// with their regions.
#[test]
fn a_small_thing_in_a_large_one() {
    let meshes = stadium(10.0);
    let visited = |kind: Kind| {
        let tree = build(&meshes, kind);
        let mut random = Random::new(9);
        let mut record = gnurt_accel::Record::default();
        let near = |random: &mut Random| random.point().map(|x| 3.0 * x);
        let rays = (0..2000).map(|_| Ray::new(near(&mut random), random.point())).collect();
        let (query, mut hits) = (gnurt_accel::Query::default(), gnurt_accel::HitBatch::default());
        tree.intersect_batch(&query, &rays, &mut hits, &mut record);
        record.counters.nodes as f64 / rays.len() as f64
    };
    let [plain, bih, bkd] = KINDS.map(visited);
    let kd = visited(WATERTIGHT[3]);
    assert!(bih < 1.3 * kd && bkd < 1.3 * kd, "{bih:.1} and {bkd:.1} nodes a ray, kd {kd:.1}");
    assert!(plain > bih, "{plain:.1} nodes a ray, {bih:.1} with clips");
}
