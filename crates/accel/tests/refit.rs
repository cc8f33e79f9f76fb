// SPDX-License-Identifier: GPL-3.0-or-later
//! Trees refitted to moved primitives give the hits of new trees, bit for bit, and those of brute force: in
//! every structure that can be refitted, at every level, for any motion, and while some primitives are bad.

use crate::common::{Kind, WATERTIGHT, assert_hits, batch, build, options, run_queries};
use gnurt_accel::{
    BadPrimitives, BuildOptions, Geometry, ObjectTree, Quads, RefitError, Spheres, Structure, Threads,
    Triangles,
};
use gnurt_testkit::{OracleInstance, Random, Soup, rays};

fn triangles(meshes: &[Soup]) -> Vec<Triangles<'_>> {
    meshes.iter().map(|m| Triangles { positions: &m.positions, indices: &m.indices }).collect()
}

fn kinds() -> impl Iterator<Item = Kind> {
    WATERTIGHT.into_iter().filter(|kind| kind.0 == Structure::Bvh)
}

fn pool() -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool")
}

/// Moves every vertex by up to `far`.
fn move_all(mesh: &mut Soup, random: &mut Random, far: f32) {
    for p in &mut mesh.positions {
        let by = random.point();
        *p = [0, 1, 2].map(|k| p[k] + far * by[k]);
    }
}

#[test]
fn moved_soups() {
    let pool = pool();
    for kind in kinds() {
        let mut meshes = [Soup::random(1, 400, 0.3), Soup::default(), Soup::random(2, 200, 0.1)];
        let mut tree = build(&meshes, kind);
        let mut random = Random::new(3);
        let rays = batch(&rays::random(4, 80));
        for far in [0.0, 0.05, 1.0] {
            meshes.iter_mut().for_each(|mesh| move_all(mesh, &mut random, far));
            let joint = tree.clone().refit(&triangles(&meshes), Threads::Pool(&pool)).expect("it can be");
            tree = tree.refit(&triangles(&meshes), Threads::Single).expect("it can be");
            assert!(tree.same_tree(&joint), "threads make no difference: {kind:?}");
            let fresh = build(&meshes, kind);
            assert_eq!(tree.bad_primitives(), fresh.bad_primitives(), "{kind:?}, {far}");
            assert_eq!(tree.stats().primitives, fresh.stats().primitives, "{kind:?}, {far}");
            let hits = run_queries(&tree, &rays);
            assert_eq!(hits, run_queries(&fresh, &rays), "a fresh tree's hits: {kind:?}, {far}");
            assert_hits(&[OracleInstance::identity(&meshes)], &rays, &hits, 2e-5);
            let point = random.point().map(f64::from);
            let (a, b) = (tree.closest_point(point, 9.0), fresh.closest_point(point, 9.0));
            assert_eq!(a.map(|a| a.distance), b.map(|b| b.distance), "the nearest point, too");
        }
        assert!(tree.cost_growth() > 1.5, "neighbours are far apart now: {}", tree.cost_growth());
        let again = build(&meshes, kind);
        assert_eq!(again.cost_growth(), 1.0, "nothing has moved since it was built");
    }
}

/// A build's own boxes come out again, and the cost is that of the build.
#[test]
fn what_has_not_moved_stays() {
    for kind in kinds().filter(|kind| kind.1 != gnurt_accel::Quality::High) {
        let meshes = [Soup::random(1, 900, 0.2)];
        let fresh = build(&meshes, kind);
        let tree = fresh.clone().refit(&triangles(&meshes), Threads::Single).expect("nothing has moved");
        assert!(tree.same_tree(&fresh), "node for node: {kind:?}");
        assert_eq!(tree.bounds(), fresh.bounds(), "{kind:?}");
        let (a, b) = (tree.stats().sah_cost, fresh.stats().sah_cost);
        assert!((a - b).abs() < 1e-5 * b, "the same cost: {a} and {b}, {kind:?}");
        assert!((tree.cost_growth() - 1.0).abs() < 1e-3, "{}", tree.cost_growth());
    }
}

/// Temporarily untraceable primitives are missed and counted, and return afterwards.
#[test]
fn triangles_go_bad_and_come_back() {
    let rays = batch(&rays::random(7, 80));
    let good = [Soup::random(5, 400, 0.4)];
    for kind in kinds() {
        let mut went_bad = 0;
        let mut tree = build(&good, kind);
        let mut random = Random::new(6);
        for round in 0..4 {
            let mut meshes = good.clone();
            if round % 3 != 2 {
                for _ in 0..40 {
                    // A corner of its own for each triangle.
                    let at = random.below(meshes[0].positions.len());
                    let other = meshes[0].positions[at / 3 * 3];
                    let p = &mut meshes[0].positions[at];
                    *p = random.pick(&[
                        other,
                        [f32::NAN, 0.0, 0.0],
                        [0.0, f32::INFINITY, 0.0],
                        [0.0, 0.0, -2e18],
                        [3e18, f32::NEG_INFINITY, f32::NAN],
                    ]);
                }
            }
            let fresh = build(&meshes, kind);
            tree = match tree.refit(&triangles(&meshes), Threads::Single) {
                Ok(tree) => tree,
                // A leaf has lost all of its triangles, or is compact and knows none that are bad.
                Err(error) => {
                    assert_eq!(error, RefitError::OtherPrimitives, "{kind:?}");
                    tree = build(&good, kind);
                    continue;
                }
            };
            went_bad += usize::from(fresh.bad_primitives().total() > 0);
            assert_eq!(tree.bad_primitives(), fresh.bad_primitives(), "round {round} of {kind:?}");
            assert_eq!(tree.stats().primitives, fresh.stats().primitives, "round {round} of {kind:?}");
            assert_eq!(run_queries(&tree, &rays), run_queries(&fresh, &rays), "round {round} of {kind:?}");
        }
        let may_go_bad = kind.3 == gnurt_accel::Memory::Fast && kind.1 != gnurt_accel::Quality::Fast;
        assert!(went_bad >= 2 || !may_go_bad, "{went_bad} rounds of {kind:?}");
    }
}

/// A triangle that lies in several leaves is one triangle, also while it cannot be traced.
#[test]
fn slivers_in_many_leaves_count_once() {
    let mut random = Random::new(11);
    let mut mesh = Soup::default();
    // Long and thin, across each other: splits pay.
    for i in 0..4000_u32 {
        let (from, to) = (random.point(), random.point());
        let by = random.point();
        let offset = [0, 1, 2].map(|k| from[k] + 0.001 * by[k]);
        mesh.positions.extend([from, to, offset]);
        mesh.indices.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    let good = [mesh];
    let tree = build(&good, WATERTIGHT[1]);
    let stats = tree.stats();
    assert!(stats.references > stats.primitives + 100, "splits have won: {stats:?}");
    let mut meshes = good.clone();
    for i in [30, 31, 32, 200, 3999] {
        meshes[0].positions[3 * i + 1] = [f32::NAN, 0.0, 0.0];
    }
    let moved = tree.refit(&triangles(&meshes), Threads::Single).expect("no leaf has lost all");
    let fresh = build(&meshes, WATERTIGHT[1]);
    assert_eq!(moved.bad_primitives(), fresh.bad_primitives(), "each once");
    assert_eq!(moved.stats().primitives, fresh.stats().primitives, "and missing once");
    let back = moved.refit(&triangles(&good), Threads::Single).expect("they come back");
    assert_eq!((back.bad_primitives().total(), back.stats().primitives), (0, 4000), "all of them");
    let rays = batch(&rays::random(7, 80));
    assert_eq!(
        run_queries(&back, &rays),
        run_queries(&build(&good, WATERTIGHT[1]), &rays),
        "where they were"
    );
}

#[test]
fn what_was_bad_and_is_good_asks_for_a_build() {
    let mut meshes = [Soup::random(5, 100, 0.4)];
    let good = meshes[0].positions[3];
    meshes[0].positions[3] = [f32::NAN; 3];
    let tree = build(&meshes, WATERTIGHT[0]);
    let again = tree.refit(&triangles(&meshes), Threads::Single).expect("it is as bad as before");
    assert_eq!(again.bad_primitives(), BadPrimitives { nan: 1, ..BadPrimitives::default() }, "one");
    meshes[0].positions[3] = good;
    let refused = again.refit(&triangles(&meshes), Threads::Single).expect_err("the tree lacks it");
    assert_eq!(refused, RefitError::OtherPrimitives, "{refused}");
}

#[test]
fn other_geometry_is_refused() {
    let meshes = [Soup::random(5, 100, 0.4), Soup::random(6, 10, 0.4)];
    let tree = build(&meshes, WATERTIGHT[0]);
    let refused = |geometries: &[Geometry]| tree.clone().refit_from(geometries, Threads::Single).err();
    let [a, b] = [0, 1].map(|i: usize| Geometry::from(triangles(&meshes)[i]));
    assert_eq!(refused(std::slice::from_ref(&a)), Some(RefitError::OtherGeometry), "fewer meshes");
    assert_eq!(
        refused(&[b.clone(), a.clone()]),
        Some(RefitError::OtherGeometry),
        "other numbers of triangles"
    );
    assert_eq!(
        refused(&[a.clone(), b.clone().with_mask(1)]),
        Some(RefitError::OtherGeometry),
        "another mask"
    );
    let balls = Spheres { centers: &meshes[1].positions[..10], radii: &[1.0; 10] };
    assert_eq!(refused(&[a.clone(), balls.into()]), Some(RefitError::OtherGeometry), "another kind");
    assert_eq!(refused(&[a, b]), None, "these are the ones");
    let kd = BuildOptions { structure: Structure::Kd, ..BuildOptions::default() };
    let tree = ObjectTree::build(&triangles(&meshes), &kd, Threads::Single);
    let error = tree.refit(&triangles(&meshes), Threads::Single).expect_err("a kd-tree");
    assert_eq!(error, RefitError::Structure, "{error}");
}

/// Quads, spheres, and trees that come from a file.
#[test]
fn other_kinds() {
    let rays = batch(&rays::random(8, 80));
    let soup = Soup::random(9, 300, 0.3);
    let quads: Vec<[u32; 4]> = (0..299).map(|i| [3 * i, 3 * i + 1, 3 * i + 3, 3 * i + 2]).collect();
    let (mut positions, mut radii) = (soup.positions.clone(), vec![0.05; 200]);
    let mut random = Random::new(10);
    for kind in kinds() {
        fn all<'a>(positions: &'a [[f32; 3]], quads: &'a [[u32; 4]], radii: &'a [f32]) -> [Geometry<'a>; 3] {
            let balls = Spheres { centers: positions, radii };
            let triangles = Triangles { positions, indices: &[[0, 1, 2], [7, 8, 9], [5, 5, 5]] };
            [Quads { positions, indices: quads }.into(), balls.into(), triangles.into()]
        }
        let options = options(kind);
        let mut tree = ObjectTree::build_from(&all(&positions, &quads, &radii), &options, Threads::Single);
        for _ in 0..2 {
            positions.iter_mut().for_each(|p| *p = random.point());
            radii.iter_mut().for_each(|r| *r = random.between(0.01, 0.1));
            let geometries = all(&positions, &quads, &radii);
            let mut file = Vec::new();
            tree.save(&mut file).expect("a list of bytes takes all");
            let loaded = ObjectTree::load(&mut &file[..]).expect("it was saved");
            let loaded = loaded.refit_from(&geometries, Threads::Single).expect("it can be");
            tree = tree.refit_from(&geometries, Threads::Single).expect("it can be");
            assert!(tree.same_tree(&loaded), "from a file, too: {kind:?}");
            let fresh = ObjectTree::build_from(&geometries, &options, Threads::Single);
            assert_eq!(tree.bad_primitives(), fresh.bad_primitives(), "{kind:?}");
            assert_eq!(run_queries(&tree, &rays), run_queries(&fresh, &rays), "{kind:?}");
        }
    }
}
