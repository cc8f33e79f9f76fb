// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays with times have the hits of rays in a tree over all geometry at their time, bit for bit, in every
//! kind of query and at every level.

use std::sync::Arc;

use gnurt_accel::{
    BuildOptions, Face, Geometry, Hit, HitBatch, Instance, KeyInterval, Level, Memory, MotionPath,
    MovingTriangles, ObjectTree, Quality, Query, Ray, Ray64, RayBatch, SceneTree, Threads, Triangles,
};
use gnurt_testkit::{Random, Soup, rays};

use crate::common::{QueryTarget, queries, run_queries};

/// A soup at some keys: triangles drift apart, each its own way.
struct Drift {
    keys: Vec<Vec<[f32; 3]>>,
    indices: Vec<[u32; 3]>,
}

impl Drift {
    fn new(seed: u64, triangles: usize, keys: usize) -> Self {
        let (soup, mut random) = (Soup::random(seed, triangles, 0.5), Random::new(seed + 77));
        let mut all = vec![soup.positions.clone()];
        for _ in 1..keys {
            let mut next = all[all.len() - 1].clone();
            for triangle in next.chunks_mut(3) {
                let (motion_path, one) = (random.point(), random.point());
                for (p, further) in triangle.iter_mut().zip([motion_path, motion_path, one]) {
                    *p = [0, 1, 2].map(|k| p[k] + 0.6 * (further[k] - 0.5));
                }
            }
            all.push(next);
        }
        Self { keys: all, indices: soup.indices }
    }

    fn lists(&self) -> Vec<&[[f32; 3]]> {
        self.keys.iter().map(Vec::as_slice).collect()
    }

    /// All vertices as they are at a moment.
    fn positions(&self, time: f32) -> Vec<[f32; 3]> {
        let interval = KeyInterval::of(time, self.keys.len());
        let (from, to) = (&self.keys[interval.key], &self.keys[interval.next]);
        from.iter().zip(to).map(|(&from, &to)| interval.mix3(from, to)).collect()
    }
}

/// Two meshes that move, of different numbers of keys, and one that stands still.
fn geometries<'a>(two: &'a [&'a [[f32; 3]]], drift: &'a Drift, still: &'a Soup) -> [Geometry<'a>; 3] {
    let moving = MovingTriangles { keys: two, indices: &drift.indices };
    let still = Triangles { positions: &still.positions, indices: &still.indices };
    let other = MovingTriangles { keys: &two[..2], indices: &drift.indices };
    [moving.into(), still.into(), Geometry::from(other).with_mask(2)]
}

const TIMES: [f32; 6] = [0.0, 0.2, 0.5, 0.734, 1.0, 0.999];

fn some_rays(seed: u64, count: usize) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let ray = |(i, (org, dir)): (usize, ([f32; 3], [f32; 3]))| {
        let mask = random.pick(&[1, 2, u32::MAX]);
        Ray::new(org, dir).with_mask(mask).with_time(TIMES[i % TIMES.len()])
    };
    rays::random(seed, count).into_iter().enumerate().map(ray).collect()
}

/// Asserts that rays of several times find the contents of `snapshot` at each of them.
fn compare<T: QueryTarget>(moving: &T, rays: &[Ray], mut snapshot: impl FnMut(f32) -> T) {
    let batch: RayBatch = rays.iter().copied().collect();
    let found = run_queries(moving, &batch);
    for time in TIMES {
        let still = snapshot(time);
        let mut hits = 0;
        for (ray, found) in rays.iter().zip(&found).filter(|(ray, _)| ray.time == time) {
            let bits = |hit: Option<Hit>| hit.map(|hit| (hit, [hit.t, hit.u, hit.v].map(f32::to_bits)));
            let expected = still.one(&Query::default(), ray);
            assert_eq!(bits(*found), bits(expected), "{ray:?}");
            assert_eq!(moving.all(ray), still.all(ray), "all hits of {ray:?}");
            hits += usize::from(expected.is_some());
        }
        assert!(hits > 20, "{hits} hits at {time} are enough to tell");
    }
}

#[test]
fn meshes_are_seen_where_they_are_at_the_moment() {
    let still = Soup::random(5, 40, 0.4);
    for (keys, quality, memory) in [
        (2, Quality::Medium, Memory::Fast),
        (3, Quality::Fast, Memory::Fast),
        (5, Quality::High, Memory::Compact),
    ] {
        let drift = Drift::new(keys as u64, 300, keys);
        let lists = drift.lists();
        let options = BuildOptions { quality, memory, ..BuildOptions::default() };
        let tree =
            Arc::new(ObjectTree::build_from(&geometries(&lists, &drift, &still), &options, Threads::Single));
        assert!(tree.moves(), "it moves");
        let rays = some_rays(9, 900);
        let two = Drift { keys: drift.keys[..2].to_vec(), indices: drift.indices.clone() };
        let fresh = |time: f32| {
            let (all, other) = (drift.positions(time), two.positions(time));
            let mesh = |positions| -> Geometry { Triangles { positions, indices: &drift.indices }.into() };
            let third = Triangles { positions: &still.positions, indices: &still.indices };
            let meshes = [mesh(&all), third.into(), mesh(&other).with_mask(2)];
            ObjectTree::build_from(&meshes, &options, Threads::Single)
        };
        compare(&*tree, &rays, fresh);
        compare(&*tree, &rays, |time| (*tree.at(time)).clone());
        let stopped = tree.at(0.3);
        let (around, true_box) = (stopped.bounds(), fresh(0.3).bounds());
        assert_eq!(around.union(&true_box), around, "the box at a moment holds what is there");
        // A frozen tree is a tree like any other.
        let mut file = Vec::new();
        stopped.save(&mut file).expect("to memory");
        let loaded = ObjectTree::load(&mut &file[..]).expect("what was saved is a tree");
        assert!(loaded.same_tree(&stopped), "node for node");
    }
}

/// A place, turned and scaled in some way.
fn placement(random: &mut Random) -> [[f64; 3]; 4] {
    let rotation = f64::from(random.between(-3.0, 3.0));
    let (s, c) = rotation.sin_cos();
    let scale = f64::from(random.pick(&[0.5_f32, 1.0, -1.0]));
    let at = random.point().map(f64::from);
    [[c, 0.2 * s, s], [0.0, scale, 0.0], [-s, 0.1, c], at]
}

#[test]
fn instances_are_seen_where_they_are_at_the_moment() {
    let mut random = Random::new(3);
    let (options, threads) = (BuildOptions::default(), Threads::Single);
    let drift = Drift::new(8, 60, 3);
    let lists = drift.lists();
    let mesh = MovingTriangles { keys: &lists, indices: &drift.indices };
    let object = |geometry: Geometry| Arc::new(ObjectTree::build_from(&[geometry], &options, threads));
    let soup = Soup::random(1, 60, 0.4);
    let still = object(Triangles { positions: &soup.positions, indices: &soup.indices }.into());
    let moving = object(mesh.into());
    let path = |random: &mut Random, keys: usize| {
        let placements: Vec<_> = (0..keys).map(|_| placement(random)).collect();
        Arc::new(MotionPath::new(&placements).expect("they have inverses"))
    };
    let mut instances = vec![
        Instance::new(still.clone(), placement(&mut random)),
        Instance::moving(still.clone(), path(&mut random, 2)).with_mask(3),
        Instance::moving(moving.clone(), path(&mut random, 4)),
        Instance::identity(moving.clone()),
    ];
    let inner = Arc::new(SceneTree::build(&instances, &options, threads));
    instances.push(Instance::moving(inner.clone(), path(&mut random, 3)));
    instances.push(Instance::new(inner, placement(&mut random)));
    let rays = some_rays(4, 1200);

    // By hand, instance by instance.
    fn snapshot(instances: &[Instance], time: f32) -> SceneTree {
        let still = |instance: &Instance| {
            let columns = instance.motion.as_ref().map_or(instance.world_from_object, |path| path.at(time));
            let shape = match &instance.shape {
                gnurt_accel::Shape::Object(object) => object.at(time).into(),
                gnurt_accel::Shape::Scene(scene) => Arc::new(scene.at(time, Threads::Single)).into(),
            };
            Instance { shape, motion: None, world_from_object: columns, mask: instance.mask }
        };
        let all: Vec<Instance> = instances.iter().map(still).collect();
        SceneTree::build(&all, &BuildOptions::default(), Threads::Single)
    }
    for count in [2, instances.len()] {
        let scene = SceneTree::build(&instances[..count], &options, threads);
        assert!(scene.moves() && !scene.at(0.5, threads).moves(), "it moves until it is stopped");
        compare(&scene, &rays, |time| snapshot(&instances[..count], time));
        compare(&scene, &rays, |time| scene.at(time, threads));
    }
    // Alone: no top tree is in the way. And with origins in double precision.
    for instance in &instances[1..3] {
        let scene = SceneTree::build(std::slice::from_ref(instance), &options, threads);
        for ray in &rays {
            let still = scene.at(ray.time, threads);
            assert_eq!(scene.intersect(ray), still.intersect(ray), "{ray:?}");
            let Ray { org, t_near, dir, t_far, mask, time } = *ray;
            let precise = Ray64 { org: org.map(|x| f64::from(x) + 1e-9), t_near, dir, t_far, mask, time };
            assert_eq!(scene.intersect(&precise), still.intersect(&precise), "{precise:?}");
        }
    }
    // Into a scene that is there already.
    let mut following = SceneTree::build(&instances[..1], &options, threads);
    let more: Vec<(u32, Option<Instance>)> = (1..).zip(instances[1..].iter().cloned().map(Some)).collect();
    following = following.updated(instances.len(), &more, threads);
    compare(&following, &rays, |time| snapshot(&instances, time));
}

/// Enough instances that the top tree has parts, some of which move; and updates in which some of them change
/// direction.
#[test]
fn many_instances_are_met_where_they_are() {
    let mut random = Random::new(11);
    let (options, threads) = (BuildOptions::default(), Threads::Single);
    let soup = Soup::random(2, 12, 0.5);
    let mesh = Triangles { positions: &soup.positions, indices: &soup.indices };
    let object = Arc::new(ObjectTree::build(&[mesh], &options, threads));
    let small = |random: &mut Random, from: [f32; 3]| {
        let near = random.point();
        let [axes @ .., _] = placement(random);
        let at = [0, 1, 2].map(|k| f64::from(10.0 * from[k] + near[k]));
        let [x, y, z] = axes.map(|axis| axis.map(|x| 0.9 * x));
        [x, y, z, at]
    };
    let instance = |random: &mut Random| {
        let from = random.point();
        let keys = random.pick(&[1, 1, 2, 3, 5, 12]);
        let placements: Vec<_> = (0..keys).map(|_| small(random, from)).collect();
        match keys {
            1 => Instance::new(object.clone(), placements[0]),
            _ => Instance::moving(
                object.clone(),
                Arc::new(MotionPath::new(&placements).expect("they have inverses")),
            ),
        }
    };
    let instances: Vec<Instance> = (0..1200).map(|_| instance(&mut random)).collect();
    let mut scene = SceneTree::build(&instances, &options, threads);
    let ray = |(i, (org, dir)): (usize, ([f32; 3], [f32; 3]))| {
        Ray::new(org.map(|x| 10.0 * x), dir).with_time(TIMES[i % TIMES.len()])
    };
    let rays: Vec<Ray> = rays::random(6, 420).into_iter().enumerate().map(ray).collect();
    compare(&scene, &rays, |time| scene.at(time, threads));
    // All at one time, in tiles: geometry is static for them.
    let stopped = scene.at(0.734, threads);
    let joint = |random: &mut Random| {
        let to = random.point();
        Ray::new([-5.0, 4.0, 6.0], [0, 1, 2].map(|k| 10.0 * to[k] - [-5.0, 4.0, 6.0][k])).with_time(0.734)
    };
    let bundle: RayBatch = (0..256).map(|_| joint(&mut random)).collect();
    assert_eq!(run_queries(&scene, &bundle), run_queries(&stopped, &bundle), "at one moment");
    let spread: RayBatch = (0..256).map(|i| bundle.get(i).with_time(i as f32 / 256.0)).collect();
    let found = run_queries(&scene, &spread);
    for (i, found) in found.iter().enumerate().step_by(64) {
        let ray = spread.get(i);
        assert_eq!(*found, scene.at(ray.time, threads).intersect(&ray), "{ray:?} in a tile of many moments");
    }
    let other: Vec<(u32, Option<Instance>)> =
        (0..240).map(|i| (5 * i, (i % 10 != 0).then(|| instance(&mut random)))).collect();
    scene = scene.updated(instances.len(), &other, threads);
    compare(&scene, &rays, |time| scene.at(time, threads));
}

#[test]
fn normals_and_faces_are_those_of_the_moment() {
    let (options, threads) = (BuildOptions::default(), Threads::Single);
    // Turns over from facing z to facing -z, by way of standing upright.
    let keys: [&[[f32; 3]]; 2] =
        [&[[-1., -1., 0.], [1., -1., 0.], [0., 1., 0.]], &[[1., -1., 0.], [-1., -1., 0.], [0., 1., 0.]]];
    let mesh = MovingTriangles { keys: &keys, indices: &[[0, 1, 2]] };
    let object = Arc::new(ObjectTree::build_from(&[mesh.into()], &options, threads));
    let quarter = [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]];
    let half = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0; 3]];
    let path = MotionPath::new(&[identity(), quarter, half]).expect("places");
    let scene = SceneTree::build(&[Instance::moving(object.clone(), Arc::new(path))], &options, threads);
    let ray = |time| Ray::new([0.0, -0.5, 3.0], [0.0, 0.0, -1.0]).with_time(time);
    for (time, object_z, scene_z) in [(0.1, 1.0, 1.0), (0.9, -1.0, 1.0)] {
        let rays: RayBatch = [ray(time)].into_iter().collect();
        let mut normals = Vec::new();
        let mut hits = HitBatch::default();
        object.intersect_batch(&Query::default(), &rays, &mut hits, &mut Default::default());
        object.normals(&rays, &hits, threads, &mut normals);
        assert_eq!(normals, [[0.0, 0.0, object_z]], "of the object at {time}");
        let (visible, unseen) =
            if object_z > 0.0 { (Face::Front, Face::Back) } else { (Face::Back, Face::Front) };
        assert!(object.occluded_face(&Query::default(), &ray(time), visible), "{visible:?} at {time}");
        assert!(!object.occluded_face(&Query::default(), &ray(time), unseen), "{unseen:?} at {time}");
        scene.intersect_batch(&Query::default(), &rays, &mut hits, &mut Default::default());
        scene.normals(&rays, &hits, threads, &mut normals);
        let is_like =
            (normals[0][2] - scene_z * normals[0][2].abs()).abs() < 1e-6 && normals[0][2].abs() > 0.9;
        assert!(is_like, "of the scene at {time}: {normals:?}");
    }
}

fn identity() -> [[f64; 3]; 4] {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]
}

#[test]
fn bad_triangles_are_left_out_at_every_key() {
    let good = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [5., 5., 5.]];
    let mut spoiled = good;
    spoiled[1][2] = f32::NAN;
    let options = BuildOptions::default();
    let build = |keys: &[&[[f32; 3]]], indices: &[[u32; 3]]| {
        ObjectTree::build_from(&[MovingTriangles { keys, indices }.into()], &options, Threads::Single)
    };
    let tree = build(&[&good, &spoiled], &[[0, 1, 2], [0, 3, 2], [0, 9, 2], [2, 2, 3]]);
    let bad = tree.bad_primitives();
    assert_eq!((bad.nan, bad.bad_index, bad.zero_area, bad.total()), (1, 1, 1, 3), "{bad:?}");
    assert!(tree.moves() && !tree.bounds().is_empty(), "one is left");
    assert!(build(&[], &[[0, 1, 2]]).bounds().is_empty(), "no key, no triangle");
    assert!(build(&[&good, &good[..2]], &[[0, 1, 2]]).bad_primitives().bad_index == 1, "a short key");
    let one = build(&[&good], &[[0, 1, 2]]);
    let ray = Ray::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]).with_time(0.7);
    assert_eq!(one.intersect(&ray).map(|hit| hit.t), Some(1.0), "one key stands still");
    // Collapsed to a line at one key, a triangle is there in between.
    let flat = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [5., 5., 5.]];
    let tree = build(&[&good, &flat], &[[0, 1, 2]]);
    assert!(tree.occluded(&ray.with_time(0.1)), "at first it is");
    for query in queries() {
        let found: HitBatch = {
            let (mut hits, rays) = (HitBatch::default(), [ray.with_time(1.0)].into_iter().collect());
            tree.intersect_batch(&query, &rays, &mut hits, &mut Default::default());
            hits
        };
        assert_eq!(found.get(0), None, "at the end it is a line, {query:?}");
    }
    assert!(Level::available().len() > 1 || cfg!(not(target_arch = "x86_64")), "several levels were asked");
}
