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

/// Rays carried into a sheared instance are rounded by more than its own size: its box may turn none of them away. What each
/// instance by itself is hit by, where no box is asked, is the truth.
#[test]
fn sheared_instances_lose_no_rays() {
    let (kind, _) = TESTS[0];
    let mut random = Random::new(6);
    let size = 1e-3;
    let mut square = Soup::default();
    let corner = |x: f32, z: f32| [x * size, 0.0, z * size];
    square.push([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)]);
    square.push([corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
    let object = Arc::new(build(&[square], kind));
    // Many more than one part of a top tree holds where they are far away.
    for (shear, far) in [(100.0, 1), (1000.0, 1), (1000.0, 1500), (1e5, 1)] {
        let sheared = [[1.0, 0.0, 0.0], [shear, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.25]];
        let turned = [[0.6, 0.8, 0.0], [shear, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.0, 0.0]];
        let mut instances =
            vec![Instance::new(Arc::clone(&object), sheared), Instance::new(Arc::clone(&object), turned)];
        instances.extend((0..far).map(|i| {
            let place = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [3.0, 0.01 * f64::from(i), -5.0]];
            Instance::new(Arc::clone(&object), place)
        }));
        let around = |middle: [f32; 3], by: f32, random: &mut Random| {
            let p = random.point();
            [0, 1, 2].map(|k| middle[k] + by * p[k])
        };
        let rays: Vec<rays::PlainRay> = (0..1500)
            .map(|i| {
                let middle = [[0.0, 0.0, 0.25], [0.5, 0.0, 0.0]][i % 2];
                let mut target = around(middle, 4e-3, &mut random);
                target[1] = 0.0;
                let org = around(middle, random.pick(&[0.1, 1.0, 10.0]), &mut random);
                (org, [0, 1, 2].map(|k| target[k] - org[k]))
            })
            .collect();
        let rays = batch(&rays);
        let mut all = vec![None; rays.len()];
        for (i, instance) in (0..).zip(&instances[..2]) {
            let alone = run_queries(&scene_of(std::slice::from_ref(instance)), &rays);
            for (best, hit) in all.iter_mut().zip(alone) {
                let hit = hit.map(|hit| (hit.t, i, hit.prim_id, [hit.u, hit.v].map(f32::to_bits)));
                *best = match (*best, hit) {
                    (Some(best), Some(hit)) => Some(if hit < best { hit } else { best }),
                    (best, hit) => best.or(hit),
                };
            }
        }
        let found = run_queries(&scene_of(&instances), &rays);
        let mut hits = 0;
        for (i, (expected, found)) in all.iter().zip(&found).enumerate() {
            let Some(expected) = expected else { continue };
            hits += 1;
            let found = found.map(|hit| (hit.t, hit.inst_id, hit.prim_id, [hit.u, hit.v].map(f32::to_bits)));
            assert_eq!(found, Some(*expected), "shear {shear}, ray {i}: {:?}", rays.get(i));
        }
        assert!(hits > 20, "{hits} of the rays hit something at a shear of {shear}");
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
