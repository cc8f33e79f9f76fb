// SPDX-License-Identifier: GPL-3.0-or-later
//! Two-level scenes equal brute force over all instances.

use std::sync::Arc;

use crate::common::{TESTS, WATERTIGHT, assert_hits, batch, build, run_queries, scene_of};
use gnurt_accel::{Instance, ObjectTree};
use gnurt_testkit::{OracleInstance, Random, Soup, closed, rays};

/// Rotated about, scaled differently along the axes, mirrored now and then, moved.
fn any_transform(random: &mut Random) -> [[f64; 3]; 4] {
    let (angle, tilt) = (random.between(0.0, 6.3), random.between(0.0, 6.3));
    let ((s, c), (st, ct)) = (angle.sin_cos(), tilt.sin_cos());
    let axes = [[c, s, 0.0], [-s * ct, c * ct, st], [s * st, -c * st, ct]];
    let mut columns = [[0.0; 3]; 4];
    for (column, axis) in columns.iter_mut().zip(axes) {
        let scale = random.between(0.1, 0.6) * random.pick(&[1.0, 1.0, -1.0]);
        *column = axis.map(|x| f64::from(scale * x));
    }
    columns[3] = random.point().map(f64::from);
    columns
}

#[test]
fn scenes_equal_brute_force() {
    for (test, margin) in TESTS {
        let shapes = [[closed::sphere(6)], [Soup::random(1, 30, 0.5)], [closed::cube(2)], [Soup::default()]];
        let objects: Vec<Arc<ObjectTree>> = shapes.iter().map(|s| Arc::new(build(s, test))).collect();
        for n in [1, 2, 40] {
            let mut random = Random::new(n as u64);
            let (mut instances, mut oracles) = (Vec::new(), Vec::new());
            for i in 0..n {
                let shape = i % shapes.len();
                let world_from_object = any_transform(&mut random);
                instances.push(Instance::new(Arc::clone(&objects[shape]), world_from_object));
                oracles.push(OracleInstance { meshes: &shapes[shape], world_from_object });
            }
            let scene = scene_of(&instances);
            let rays = batch(&rays::random(2, 300));
            assert_hits(&oracles, &rays, &run_queries(&scene, &rays), 10.0 * margin);
        }
    }
}

/// Tiles whose rays part at once, among more instances than one part of a top tree holds.
#[test]
fn many_tiny_instances_equal_brute_force() {
    let (kind, margin) = TESTS[0];
    for shape in [[Soup::random(3, 1, 1.0)], [closed::cube(1)]] {
        let object = Arc::new(build(&shape, kind));
        let mut random = Random::new(4);
        let placement = |random: &mut Random| {
            let mut placement = any_transform(random);
            placement[3] = placement[3].map(|x| 4.0 * x);
            placement
        };
        let placements: Vec<[[f64; 3]; 4]> = (0..1200).map(|_| placement(&mut random)).collect();
        let instances: Vec<Instance> =
            placements.iter().map(|&placement| Instance::new(Arc::clone(&object), placement)).collect();
        let oracles: Vec<OracleInstance> = placements
            .iter()
            .map(|&world_from_object| OracleInstance { meshes: &shape, world_from_object })
            .collect();
        let rays: Vec<rays::PlainRay> =
            (0..400).map(|_| (random.point().map(|x| 4.0 * x), random.point())).collect();
        let rays = batch(&rays);
        let hits = run_queries(&scene_of(&instances), &rays);
        assert!(hits.iter().flatten().count() > 30, "some are hit");
        assert_hits(&oracles, &rays, &hits, 10.0 * margin);
    }
}

#[test]
fn instances_that_cannot_be_undone_are_counted() {
    for kind in WATERTIGHT {
        let object = Arc::new(build(&[closed::cube(1)], kind));
        let mut instances = vec![Instance::identity(Arc::clone(&object)); 4];
        instances[0].world_from_object[1] = [0.0; 3];
        instances[2].world_from_object[3][0] = f64::NAN;
        instances[3].world_from_object[3][2] = 5.0;
        let scene = scene_of(&instances);
        assert_eq!(scene.dropped_instances(), 2, "one is flat, one is nowhere");
        let hits = run_queries(
            &scene,
            &batch(&[([0.1, 0.2, -3.0], [0.0, 0.0, 1.0]), ([0.1, 0.2, 9.0], [0.0, 0.0, -1.0])]),
        );
        let ids: Vec<_> = hits.iter().flatten().map(|hit| (hit.inst_id, hit.t)).collect();
        assert_eq!(ids, [(1, 2.0), (3, 3.0)], "the others keep their ids");
    }
}

#[test]
fn an_empty_scene_is_a_scene() {
    let scene = scene_of(&[]);
    assert!(scene.bounds().is_empty(), "no instance, no box");
    assert!(run_queries(&scene, &batch(&rays::random(3, 20))).iter().all(Option::is_none), "and no hit");
}
