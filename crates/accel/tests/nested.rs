// SPDX-License-Identifier: GPL-3.0-or-later
//! Nested scenes: the same hits as the flat scene of all objects, at every level, one by one and in tiles;
//! paths name the instances; invalid nesting is rejected.

use std::sync::Arc;

use crate::common::{TESTS, WATERTIGHT, assert_hits, batch, build, run_queries, scene_of, try_scene_of};
use gnurt_accel::{
    BuildOptions, DEEPEST_SCENE, Instance, MovingTriangles, ObjectTree, SceneError, SceneTree, Shape, Threads,
};
use gnurt_testkit::{OracleInstance, Random, Soup, closed, rays};

type Columns = [[f64; 3]; 4];

const IDENTITY: Columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

fn turned(random: &mut Random, size: f32) -> Columns {
    let (s, c) = random.between(0.0, 6.3).sin_cos();
    let size = random.between(0.5, 1.0) * size;
    let mut columns =
        [[c, s, 0.0], [0.0, 0.0, 1.0], [s, -c, 0.0]].map(|axis| axis.map(|x| f64::from(x * size))).to_vec();
    columns.push(random.point().map(|x| f64::from(0.7 * x)));
    [columns[0], columns[1], columns[2], columns[3]]
}

/// `a` after `b`.
fn compose(a: &Columns, b: &Columns) -> Columns {
    let linear = |v: [f64; 3]| [0, 1, 2].map(|k| a[0][k] * v[0] + a[1][k] * v[1] + a[2][k] * v[2]);
    let [x, y, z, placement] = b.map(linear);
    [x, y, z, [0, 1, 2].map(|k| placement[k] + a[3][k])]
}

/// Where each object is, and the path to it.
fn flatten(
    instances: &[Instance],
    lists: &Lists,
    outer: &Columns,
    path: &[u32],
    out: &mut Vec<(Columns, Vec<u32>, *const ObjectTree)>,
) {
    for (id, instance) in instances.iter().enumerate() {
        let placement = compose(outer, &instance.world_from_object);
        let path: Vec<u32> = path.iter().copied().chain([id as u32]).collect();
        match &instance.shape {
            Shape::Object(object) => out.push((placement, path, Arc::as_ptr(object))),
            Shape::Scene(scene) => {
                let (_, inner) =
                    lists.iter().find(|(known, _)| Arc::ptr_eq(known, scene)).expect("a known scene");
                flatten(inner, lists, &placement, &path, out);
            }
        }
    }
}

type Lists = Vec<(Arc<SceneTree>, Vec<Instance>)>;

#[test]
fn nested_scenes_equal_flat_ones() {
    for (test, margin) in TESTS {
        let shapes = [[closed::sphere(6)], [Soup::random(1, 30, 0.5)]];
        let objects: Vec<Arc<ObjectTree>> = shapes.iter().map(|s| Arc::new(build(s, test))).collect();
        let mut random = Random::new(7);
        let mut lists: Lists = Vec::new();
        // Scenes of objects and of the scenes before, a single instance among them, and one that shows nothing.
        for n in [3, 1, 4, 2] {
            let mut instances = Vec::new();
            for i in 0..n {
                let shape: Shape = match lists.last() {
                    Some((scene, _)) if i % 2 == 0 => Arc::clone(scene).into(),
                    _ => Arc::clone(&objects[i % 2]).into(),
                };
                let placement = if i == 1 { IDENTITY } else { turned(&mut random, 0.9) };
                instances.push(Instance::new(shape, placement));
            }
            instances.push(Instance::identity(Arc::new(scene_of(&[]))));
            let retained = instances[..instances.len() - 1].to_vec();
            lists.push((Arc::new(try_scene_of(&instances).expect("fine instances")), retained));
        }
        let (scene, instances) = lists.last().expect("four scenes");
        assert_eq!(scene.depth(), 4, "each holds the one before");
        let mut flat = Vec::new();
        flatten(instances, &lists, &IDENTITY, &[], &mut flat);
        let oracles: Vec<OracleInstance> = flat
            .iter()
            .map(|(placement, _, object)| {
                let shape = objects.iter().position(|o| Arc::as_ptr(o) == *object).expect("a known object");
                OracleInstance { meshes: &shapes[shape], world_from_object: *placement }
            })
            .collect();
        for (leaf_id, (_, path, _)) in flat.iter().enumerate() {
            assert_eq!(
                scene.instance_path(leaf_id as u32).as_ref(),
                Some(path),
                "the way to object {leaf_id}"
            );
        }
        assert_eq!(scene.instance_path(flat.len() as u32), None, "there are no more objects");

        let mut plain = rays::aimed(&closed::sphere(5), [0.2, -0.1, 3.0], 2);
        plain.extend(rays::random(2, 300));
        let rays = batch(&plain);
        let mut hits = run_queries(&**scene, &rays);
        for hit in hits.iter_mut().flatten() {
            let (_, path, _) = &flat[hit.leaf_id as usize];
            assert_eq!(hit.inst_id, path[0], "{hit:?}: the outermost instance");
            // The oracle numbers objects.
            hit.inst_id = hit.leaf_id;
        }
        assert!(hits.iter().flatten().count() > 100, "enough is hit");
        let ids: std::collections::BTreeSet<u32> = hits.iter().flatten().map(|hit| hit.leaf_id).collect();
        assert!(ids.len() > 4, "many objects are hit: {ids:?}");
        assert_hits(&oracles, &rays, &hits, 30.0 * margin);
    }
}

/// Scenes that show another one many times, down to something that moves: 10^8 objects, which are one.
#[test]
fn what_is_shared_is_stopped_once() {
    let (here, there) = ([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0.0, 0.0, 1.0]; 3]);
    let there = [0, 1, 2].map(|i| [0, 1, 2].map(|k| there[i][k] + here[i][k]));
    let moving = MovingTriangles { keys: &[&here, &there], indices: &[[0, 1, 2]] };
    let options = BuildOptions::default();
    let object = Arc::new(ObjectTree::build_from(&[moving.into()], &options, Threads::Single));
    // Side by side, and those side by side.
    let row = |shape: Shape, step: f64| -> Vec<Instance> {
        let placement = |i: u32| [IDENTITY[0], IDENTITY[1], IDENTITY[2], [step * f64::from(i), 0.0, 0.0]];
        (0..100).map(|i| Instance::new(shape.clone(), placement(i))).collect()
    };
    let mut scene = scene_of(&row(object.clone().into(), 2.0));
    for step in [2e2, 2e4, 2e6] {
        scene = try_scene_of(&row(Arc::new(scene).into(), step)).expect("10^8 objects");
    }
    assert!(scene.moves(), "it moves");
    let stopped = scene.at(0.25, Threads::Single);
    assert!(!stopped.moves(), "it was stopped");
    let ray = gnurt_accel::Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -1.0]);
    assert_eq!(stopped.intersect(&ray).map(|hit| hit.t), Some(2.75), "where it was");
    // And it is known of scenes that change.
    let empty = scene_of(&[]);
    let with = empty.updated(2, &[(0, Some(Instance::identity(object)))], Threads::Single);
    let still = Instance::identity(Arc::new(stopped));
    let shown = with.updated(2, &[(1, Some(still.clone())), (0, None)], Threads::Single);
    assert_eq!([&empty, &with, &shown].map(SceneTree::moves), [false, true, false], "as it comes and goes");
    let again = shown.updated(3, &[(2, Some(Instance::identity(Arc::new(with))))], Threads::Single);
    let cut = again.updated(2, &[], Threads::Single);
    assert_eq!([again.moves(), cut.moves()], [true, false], "within another one, too");
}

#[test]
fn masks_count_at_each_level() {
    let object = Arc::new(build(&[closed::cube(1)], WATERTIGHT[0]));
    let inner = scene_of(&[Instance::identity(object).with_mask(3)]);
    let scene = scene_of(&[Instance::identity(Arc::new(inner)).with_mask(6)]);
    let ray = gnurt_accel::Ray::new([0.1, 0.2, 3.0], [0.0, 0.0, -1.0]);
    let found: Vec<bool> = [1, 2, 4, 5].iter().map(|&mask| scene.occluded(&ray.with_mask(mask))).collect();
    // 5 has a bit in common with each of them.
    assert_eq!(found, [false, true, false, true], "one bit in common at each level");
}

#[test]
fn too_deep_and_too_many_are_refused() {
    let object = Arc::new(build(&[closed::cube(1)], WATERTIGHT[0]));
    let mut scene = Arc::new(scene_of(&[Instance::identity(object)]));
    for depth in 2..=DEEPEST_SCENE {
        scene = Arc::new(try_scene_of(&[Instance::identity(scene)]).expect("not too deep"));
        assert_eq!(scene.depth(), depth, "one more");
    }
    let ray = gnurt_accel::Ray::new([0.1, 0.2, 3.0], [0.0, 0.0, -1.0]);
    assert_eq!(scene.intersect(&ray).map(|hit| hit.t), Some(2.0), "seen through all of them");
    let deeper = [Instance::identity(Arc::new(scene_of(&[]))), Instance::identity(scene)];
    let error = try_scene_of(&deeper).expect_err("one too many");
    assert_eq!(error, SceneError::TooDeep { inst_id: 1 }, "{error}");
    assert_eq!(scene_of(&deeper).dropped_instances(), 1, "or it is left out");

    let object = Arc::new(build(&[closed::cube(1)], WATERTIGHT[0]));
    let mut scene = Arc::new(scene_of(&vec![Instance::identity(object); 100]));
    for _ in 0..3 {
        scene = Arc::new(try_scene_of(&vec![Instance::identity(scene); 100]).expect("10^8 objects"));
    }
    assert!(scene.occluded(&ray), "10^8 objects");
    let error = try_scene_of(&vec![Instance::identity(scene); 43]).expect_err("4.3 * 10^9");
    assert_eq!(error, SceneError::TooManyObjects { inst_id: 42 }, "{error}");
}
