// SPDX-License-Identifier: GPL-3.0-or-later
//! A scene ten million units from the origin, seen by rays with origins in double precision: the same hits as at the
//! origin, flat and nested, to a millionth of its size.

use std::sync::Arc;

use crate::common::{QueryTarget, WATERTIGHT, batch, build, scene_of};
use gnurt_accel::{Instance, Level, Query, Ray, Ray64};
use gnurt_testkit::{Random, Soup, closed, rays};

const FAR: [f64; 3] = [1e7 + 0.3, -2e7 - 0.7, 0.9e7 + 0.123_456_7];

fn at(far: f64, placement: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| far * FAR[k] + placement[k])
}

#[test]
fn far_scenes_are_as_precise_as_near_ones() {
    for kind in WATERTIGHT {
        let objects =
            [closed::sphere(9), Soup::random(1, 60, 0.5)].map(|soup| Arc::new(build(&[soup], kind)));
        let mut random = Random::new(3);
        let placements: Vec<([f64; 3], f64)> =
            (0..40).map(|_| (random.point().map(f64::from), f64::from(random.between(0.05, 0.3)))).collect();
        let scene = |far: f64| {
            let instance = |(i, &(placement, size)): (usize, &([f64; 3], f64))| {
                let axes = [[0.0, size, 0.0], [-size, 0.0, 0.0], [0.0, 0.0, size]];
                let columns = [axes[0], axes[1], axes[2], at(far, placement)];
                Instance::new(Arc::clone(&objects[i % 2]), columns)
            };
            scene_of(&placements.iter().enumerate().map(instance).collect::<Vec<_>>())
        };
        let (near, away) = (scene(0.0), scene(1.0));
        // A scene that lies far away and is brought back, and one that is near and is brought there.
        let shift = |by: f64| {
            let [x, y, z, _] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
            [x, y, z, at(by, [0.0; 3])]
        };
        let back = scene_of(&[
            Instance::new(Arc::new(scene(1.0)), shift(-1.0)),
            Instance::identity(Arc::new(scene_of(&[]))),
        ]);
        let there = scene_of(&[Instance::new(Arc::new(scene(0.0)), shift(1.0))]);

        let mut plain = rays::random(4, 600);
        plain.extend(rays::aimed(&closed::sphere(4), [0.3, 0.1, 1.9], 1));
        let (mut found, mut differ) = (0, 0);
        for (org, dir) in plain {
            let length = dir.iter().map(|x| x * x).sum::<f32>().sqrt();
            let dir = dir.map(|x| x / length);
            let expected = near.intersect(&Ray::new(org, dir));
            found += usize::from(expected.is_some());
            for level in Level::available() {
                let query = Query { level, ..Query::default() };
                for (name, scene, far) in
                    [("near", &near, 0.0), ("away", &away, 1.0), ("back", &back, 0.0), ("there", &there, 1.0)]
                {
                    let ray = Ray64::new(at(far, org.map(f64::from)), dir);
                    let hit = scene.intersect_with(&query, &ray);
                    let any = scene.occluded_with(&query, &ray);
                    assert_eq!(hit.is_some(), any, "{name}: closest and any hit of {ray:?} at {level}");
                    let same = match (hit, expected) {
                        (Some(a), Some(b)) => {
                            a.primitive() == b.primitive() && (a.t - b.t).abs() < 1e-6 * 2.0 * (1.0 + b.t)
                        }
                        (a, b) => a.is_none() && b.is_none(),
                    };
                    // At edges a rounding decides.
                    differ += usize::from(!same);
                }
            }
        }
        assert!(found > 150, "{found} hits");
        assert!(differ < found / 50, "{differ} of {found} differ");
    }
}

#[test]
fn rays_of_single_precision_see_far_scenes() {
    // Their origins are multiples of one unit there; tiles and single rays agree, and find the geometry in
    // front of them.
    let object = Arc::new(build(&[closed::sphere(9)], WATERTIGHT[0]));
    let far = [1e7, -2e7, 0.5e7];
    let placement = |i: u32| {
        let at = [f64::from(i % 5) * 4.0, f64::from(i / 5) * 4.0, 0.0];
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0, 1, 2].map(|k| far[k] + at[k])];
        Instance::new(Arc::clone(&object), columns)
    };
    let scene = scene_of(&(0..25).map(placement).collect::<Vec<_>>());
    let bounds = scene.bounds();
    assert!(bounds.min[0] < 1e7 && bounds.max[0] > 1e7 + 16.0 && bounds.max[0] < 1e7 + 20.0, "{bounds:?}");
    let plain: Vec<_> = (0..25)
        .map(|i| ([1e7 + (i % 5) as f32 * 4.0, -2e7 + (i / 5) as f32 * 4.0, 0.5e7 + 30.0], [0.0, 0.0, -1.0]))
        .collect();
    let hits = crate::common::run_queries(&scene, &batch(&plain));
    for (i, hit) in hits.iter().enumerate() {
        let hit = hit.unwrap_or_else(|| panic!("ray {i} looks at a sphere"));
        assert!(hit.inst_id == i as u32 && (hit.t - 29.0).abs() < 0.1, "ray {i}: {hit:?}");
    }
    let query = Query::default();
    assert_eq!(scene.one(&query, &Ray::new([1e7, -2e7, 0.5e7 + 30.0], [0.0, 0.0, 1.0])), None, "behind it");
}
