// SPDX-License-Identifier: GPL-3.0-or-later
//! Poses of one object that share their structure have the hits of separate trees, bit for bit, and those of
//! brute force: at every level, in scenes, for every way to make them, and after changes of other poses.

use std::sync::{Arc, mpsc};
use std::time::Duration;

use gnurt_accel::{
    Aabb, BuildOptions, Crowd, Geometry, Instance, Motion, MovingTree, ObjectTree, Quads, Ray, RefitError,
    Spheres, Structure, Threads, Triangles, Update, UserGeometry, UserHit,
};
use gnurt_testkit::{OracleInstance, Random, Soup, closed, rays};
use rayon::prelude::*;

use crate::common::{Kind, WATERTIGHT, assert_hits, batch, build, options, run_queries, scene_of};

fn triangles(meshes: &[Soup]) -> Vec<Triangles<'_>> {
    meshes.iter().map(|m| Triangles { positions: &m.positions, indices: &m.indices }).collect()
}

fn kinds() -> impl Iterator<Item = Kind> {
    WATERTIGHT.into_iter().filter(|kind| kind.0 == Structure::Bvh)
}

/// Bends everything around the y axis, the more the higher up.
fn bent(meshes: &[Soup], angle: f32) -> Vec<Soup> {
    let mut meshes = meshes.to_vec();
    for p in meshes.iter_mut().flat_map(|mesh| &mut mesh.positions) {
        let [x, y, z] = *p;
        let (sin, cos) = (angle * y).sin_cos();
        *p = [cos * x - sin * z, y + 0.1 * angle * x, sin * x + cos * z];
    }
    meshes
}

fn check(tree: &ObjectTree, meshes: &[Soup], kind: Kind, seed: u64) {
    let rays = batch(&rays::random(seed, 60));
    let fresh = build(meshes, kind);
    let hits = run_queries(tree, &rays);
    assert_eq!(hits, run_queries(&fresh, &rays), "a fresh tree's hits: {kind:?}");
    assert_hits(&[OracleInstance::identity(meshes)], &rays, &hits, 2e-5);
    assert_eq!(tree.bad_primitives(), fresh.bad_primitives(), "{kind:?}");
    assert_eq!(tree.stats().primitives, fresh.stats().primitives, "{kind:?}");
    assert_eq!(tree.bounds(), fresh.bounds(), "{kind:?}");
    let point = Random::new(seed).point().map(f64::from);
    let nearest = |tree: &ObjectTree| tree.closest_point(point, 9.0).map(|near| near.distance);
    assert_eq!(nearest(tree), nearest(&fresh), "the nearest point, too: {kind:?}");
    let crossings =
        |tree: &ObjectTree| (0..rays.len()).map(|i| tree.crossings(&rays.get(i))).collect::<Vec<_>>();
    assert_eq!(crossings(tree), crossings(&fresh), "and what lines cross: {kind:?}");
    for hit in hits.iter().flatten() {
        assert_eq!(tree.normal(hit), fresh.normal(hit), "and normals: {kind:?}");
    }
}

#[test]
fn poses_are_as_good_as_builds() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    for kind in kinds() {
        let rest = [Soup::random(1, 300, 0.3), Soup::default(), closed::torus(12)];
        let first = build(&rest, kind);
        let mut poses = Vec::new();
        for (i, angle) in [0.0, 0.5, 2.0].into_iter().enumerate() {
            let meshes = bent(&rest, angle);
            let tree = first.posed(&triangles(&meshes), Threads::Single).expect("it shares");
            let joint = first.posed(&triangles(&meshes), Threads::Pool(&pool)).expect("it shares");
            assert!(tree.same_tree(&joint), "threads make no difference: {kind:?}");
            check(&tree, &meshes, kind, 10 + i as u64);
            poses.push((meshes, tree));
        }
        // One that is made from another pose, one that is moved on, one from a file.
        let (meshes, last) = poses.pop().expect("there are three");
        let other = poses[0].1.posed(&triangles(&meshes), Threads::Single).expect("it shares");
        assert!(other.same_tree(&last), "whichever it is made from: {kind:?}");
        let moved = poses[1].1.clone().refit(&triangles(&meshes), Threads::Single).expect("it can be");
        assert!(moved.same_tree(&last) && moved.is_posed(), "moved on: {kind:?}");
        assert_eq!(moved.stats(), last.stats(), "{kind:?}");
        let mut file = Vec::new();
        last.save(&mut file).expect("to memory");
        let loaded = ObjectTree::load(&mut &file[..]).expect("it is sound");
        assert!(!loaded.is_posed(), "a tree by itself");
        let rays = batch(&rays::random(5, 60));
        assert_eq!(run_queries(&loaded, &rays), run_queries(&last, &rays), "of the same hits: {kind:?}");
        for (i, (meshes, tree)) in poses.iter().enumerate() {
            check(tree, meshes, kind, 20 + i as u64);
        }
    }
}

#[test]
fn a_pose_owns_little() {
    let mesh = [closed::torus(50)];
    let built = build(&mesh, WATERTIGHT[0]);
    let pose = built.posed(&triangles(&bent(&mesh, 1.0)), Threads::Single).expect("it shares");
    let bytes = |tree: &ObjectTree| tree.stats().tree_bytes + tree.stats().primitive_bytes;
    assert!(100 * bytes(&pose) < 16 * bytes(&built), "{} of {} bytes", bytes(&pose), bytes(&built));
    assert!(pose.shared_bytes() < bytes(&built), "{} are shared", pose.shared_bytes());
    assert_eq!((built.shared_bytes(), built.is_posed()), (0, false), "a tree by itself");
}

#[test]
fn a_crowd_in_a_scene() {
    let rest = [closed::torus(10), Soup::random(3, 40, 0.3)];
    let crowd = Crowd::default();
    let angles = [0.0, 1.0, 0.0, 0.4, 1.0];
    let bodies: Vec<Vec<Soup>> = angles.iter().map(|&angle| bent(&rest, angle)).collect();
    let default = BuildOptions::default();
    let trees: Vec<Arc<ObjectTree>> = bodies
        .iter()
        .map(|body| {
            let geometries: Vec<Geometry> = triangles(body).into_iter().map(Geometry::from).collect();
            crowd.pose(&geometries, &default, Threads::Single)
        })
        .collect();
    assert_eq!(crowd.poses(), 3, "equal poses are one");
    assert!(Arc::ptr_eq(&trees[0], &trees[2]) && Arc::ptr_eq(&trees[1], &trees[4]), "the same tree");
    let at = |i: usize| {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.5 * i as f64 - 3.0, 0.25 * i as f64, 0.0]]
    };
    let placed = |trees: &[Arc<ObjectTree>]| -> Vec<Instance> {
        trees.iter().enumerate().map(|(i, tree)| Instance::new(Arc::clone(tree), at(i))).collect()
    };
    let separate: Vec<Arc<ObjectTree>> =
        bodies.iter().map(|body| Arc::new(build(body, WATERTIGHT[0]))).collect();
    let rays = batch(&rays::random(4, 150));
    let hits = run_queries(&scene_of(&placed(&trees)), &rays);
    assert_eq!(hits, run_queries(&scene_of(&placed(&separate)), &rays), "those of separate trees");
    assert!(hits.iter().flatten().count() > 20, "there is something to hit");
    drop((trees, hits));
    assert_eq!(crowd.poses(), 0, "nobody shows them");
}

/// A thread that waits for its share of a build takes up other work of the pool meanwhile. Here it certainly
/// does so during the callback for boxes: the other work is another pose of the crowd, and it must not wait
/// for the unfinished work of its own thread.
#[test]
fn a_pose_is_asked_for_within_the_build_of_another() {
    #[derive(Debug)]
    struct Yielding;

    impl UserGeometry for Yielding {
        fn count(&self) -> u32 {
            1
        }

        fn bounds(&self, _: u32) -> Aabb {
            rayon::yield_now();
            Aabb::around(&[[9.0; 3]])
        }

        fn intersect(&self, _: u32, _: &Ray, _: &mut dyn FnMut(UserHit)) {}
    }

    let (done, ended) = mpsc::channel();
    // A static object cannot be joined.
    std::thread::spawn(move || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
        let rest = [closed::torus(8)];
        let poses: Vec<Vec<Soup>> = (0..8).map(|i| bent(&rest, 0.1 * i as f32)).collect();
        let crowd = Crowd::default();
        let user: Arc<dyn UserGeometry> = Arc::new(Yielding);
        let pose = |meshes: &Vec<Soup>| {
            let mut geometries: Vec<Geometry> = triangles(meshes).into_iter().map(Geometry::from).collect();
            geometries.push(Geometry::user(Arc::clone(&user)));
            crowd.pose(&geometries, &BuildOptions::default(), Threads::Pool(&pool))
        };
        let trees: Vec<Arc<ObjectTree>> =
            pool.install(|| poses.par_iter().with_max_len(1).map(pose).collect());
        let share = trees.iter().all(|tree| tree.is_posed());
        done.send(share).expect("somebody waits");
    });
    let share = ended.recv_timeout(Duration::from_secs(30)).expect("no thread waits for itself");
    assert!(share, "and all share");
}

#[test]
fn what_cannot_share_is_built() {
    let rest = [closed::torus(6)];
    let crowd = Crowd::default();
    let options = options(WATERTIGHT[0]);
    let pose = |meshes: &[Soup]| {
        let geometries: Vec<Geometry> = triangles(meshes).into_iter().map(Geometry::from).collect();
        crowd.pose(&geometries, &options, Threads::Single)
    };
    assert!(pose(&rest).is_posed(), "the first shares with those to come");
    // Another number of triangles, others of as many, and the same in a heap.
    let mut turned = rest.clone();
    turned[0].indices.iter_mut().for_each(|corners| corners.rotate_left(1));
    let mut heap = rest.clone();
    let mut random = Random::new(1);
    heap[0].positions.iter_mut().for_each(|p| *p = random.point());
    let mut flat = rest.clone();
    flat[0].positions.iter_mut().for_each(|p| p[1] = 0.0);
    let mut lost = rest.clone();
    lost[0].positions[7] = [f32::NAN; 3];
    for (what, meshes) in [
        ("other triangles", vec![closed::torus(7)]),
        ("turned triangles", turned.to_vec()),
        ("a heap", heap.to_vec()),
        ("a corner that is no number", lost.to_vec()),
        ("nothing", vec![Soup::default()]),
        ("two of them", vec![rest[0].clone(), rest[0].clone()]),
    ] {
        let tree = pose(&meshes);
        assert!(!tree.is_posed(), "{what}");
        let rays = batch(&rays::random(4, 40));
        assert_eq!(run_queries(&*tree, &rays), run_queries(&build(&meshes, WATERTIGHT[0]), &rays), "{what}");
    }
    let rays = batch(&rays::random(4, 40));
    assert_eq!(
        run_queries(&*pose(&flat), &rays),
        run_queries(&build(&flat, WATERTIGHT[0]), &rays),
        "all in one plane"
    );
    assert!(pose(&rest).is_posed(), "those that came between make no difference");

    let kd = build(&rest, WATERTIGHT[3]);
    let refused = kd.posed(&triangles(&rest), Threads::Single).expect_err("kd-trees do not share");
    assert_eq!(refused, RefitError::Structure, "{refused}");
    let built = build(&rest, WATERTIGHT[0]);
    let mut beyond = rest.clone();
    beyond[0].positions.truncate(5);
    assert_eq!(
        built.posed(&triangles(&beyond), Threads::Single).expect_err("vertices are missing"),
        RefitError::OtherGeometry,
        "vertices that are not there"
    );
}

/// Triangles that were untraceable in the first pose are counted in all others, and must not return.
#[test]
fn bad_triangles_stay_bad() {
    let mut rest = [Soup::random(5, 80, 0.4)];
    rest[0].positions[4] = [f32::NAN; 3];
    rest[0].indices[9] = [0, 1, u32::MAX];
    let first = build(&rest, WATERTIGHT[0]);
    let mut pose = bent(&rest, 0.7);
    check(&first.posed(&triangles(&pose), Threads::Single).expect("as bad"), &pose, WATERTIGHT[0], 3);
    pose[0].positions[4] = [0.5; 3];
    let refused = first.posed(&triangles(&pose), Threads::Single).expect_err("one more can be traced");
    assert_eq!(refused, RefitError::OtherPrimitives, "{refused}");
}

#[test]
fn other_kinds_go_along() {
    let positions: Vec<[f32; 3]> =
        (0..40).map(|i| [i as f32 * 0.1, (i % 2) as f32, 0.3 * (i / 20) as f32]).collect();
    let indices: Vec<[u32; 4]> = (0..18).map(|i| [i, i + 1, i + 21, i + 20]).collect();
    let lifted: Vec<[f32; 3]> = positions.iter().map(|&[x, y, z]| [x, y + 0.3 * x, z]).collect();
    let soup = Soup::random(8, 50, 0.3);
    let of = |positions: &[[f32; 3]], center: f32| -> (Vec<[f32; 3]>, [[f32; 3]; 1]) {
        (positions.to_vec(), [[center, 0.0, 0.0]])
    };
    let (a, b) = (of(&positions, 0.0), of(&lifted, 1.0));
    let soup_mesh = Triangles { positions: &soup.positions, indices: &soup.indices };
    let geometries = |(positions, centers): &'_ (Vec<[f32; 3]>, [[f32; 3]; 1]),
                      use_it: &mut dyn FnMut(&[Geometry])| {
        let quads = Quads { positions, indices: &indices };
        use_it(&[
            Geometry::from(quads).with_mask(1),
            soup_mesh.into(),
            Spheres { centers, radii: &[0.5] }.into(),
        ]);
    };
    let (mut first, rays) = (None, batch(&rays::random(4, 100)));
    geometries(&a, &mut |geometries| {
        first = Some(ObjectTree::build_from(geometries, &BuildOptions::default(), Threads::Single));
    });
    let first = first.expect("it was built");
    geometries(&b, &mut |geometries| {
        let tree = first.posed_from(geometries, Threads::Single).expect("it shares");
        let fresh = ObjectTree::build_from(geometries, &BuildOptions::default(), Threads::Single);
        assert_eq!(run_queries(&tree, &rays), run_queries(&fresh, &rays), "quads, triangles and spheres");
    });
}

/// A pose that is followed from frame to frame stays one, and leaves frames in flight alone.
#[test]
fn poses_move_on() {
    let rest = [closed::torus(8)];
    let first = Arc::new(build(&rest, WATERTIGHT[0]));
    let tree = first.posed(&triangles(&rest), Threads::Single).expect("it shares");
    let mut moving = MovingTree::of(Arc::new(tree), Motion::Auto);
    for frame in 1..12 {
        let meshes = bent(&rest, 0.1 * frame as f32);
        let before = Arc::clone(moving.tree());
        let bounds = before.bounds();
        let geometries: Vec<Geometry> = triangles(&meshes).into_iter().map(Geometry::from).collect();
        let update = moving.update(&geometries, &BuildOptions::default(), Threads::Single);
        assert_eq!(update, Update::Refitted, "frame {frame}");
        assert!(moving.tree().is_posed() && before.bounds() == bounds, "frame {frame}");
        if frame % 5 == 1 {
            check(moving.tree(), &meshes, WATERTIGHT[0], frame);
        }
    }
}
