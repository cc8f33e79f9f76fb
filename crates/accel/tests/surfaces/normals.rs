// SPDX-License-Identifier: GPL-3.0-or-later
//! Normals are those of the corners, in every structure and through instances; faces are looked through.

use std::sync::Arc;

use gnurt_accel::{
    BuildOptions, Face, Hit, HitBatch, Instance, ObjectTree, Quads, Query, Ray, RayBatch, Record, Spheres,
    Threads,
};
use gnurt_testkit::{Random, Soup, closed};

use crate::common::{TESTS, WATERTIGHT, build, scene_of};

fn along(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn normal_of([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = along(n, n).sqrt();
    n.map(|x| x / length)
}

#[test]
fn normals_are_those_of_the_corners() {
    let mut random = Random::new(4);
    for (kind, _) in TESTS {
        let mesh = Soup::random(3, 300, 0.4);
        let tree = build(&[closed::cube(1), mesh.clone()], kind);
        let rays: RayBatch = (0..300)
            .map(|_| {
                let (from, to) = (random.point(), random.point());
                Ray::new(from.map(|x| 3.0 * x), [0, 1, 2].map(|k| to[k] - 3.0 * from[k]))
            })
            .collect();
        let (mut hits, mut normals) = (HitBatch::default(), Vec::new());
        tree.intersect_batch(&Query::default(), &rays, &mut hits, &mut Record::default());
        tree.normals(&rays, &hits, Threads::Single, &mut normals);
        for (i, normal) in normals.iter().enumerate() {
            let Some(hit) = hits.get(i) else {
                assert_eq!(*normal, [0.0; 3], "no hit has no normal");
                continue;
            };
            let soup = if hit.geom_id == 0 { &closed::cube(1) } else { &mesh };
            let expected = normal_of(soup.corners(hit.prim_id as usize).expect("a triangle"));
            assert!(along(*normal, expected) > 0.999, "{normal:?} of {hit:?}, not {expected:?}, {kind:?}");
            assert_eq!(tree.normal(&hit), Some(*normal), "one by one");
        }
        let nowhere = Hit { t: 1.0, u: 0.0, v: 0.0, prim_id: 900, geom_id: 1, inst_id: 0, leaf_id: 0 };
        assert_eq!(tree.normal(&nowhere), None, "no such triangle");
        assert_eq!(tree.normal(&Hit { geom_id: u32::MAX, ..nowhere }), None, "no such geometry");
    }
}

#[test]
fn corners_come_with_hits() {
    let (mut random, query, mut known) = (Random::new(5), Query::default(), [0; 2]);
    for (kind, _) in TESTS {
        let all = [Soup::random(3, 300, 0.4), closed::cube(1)];
        // Of one mesh, and so on the shortest way; and of two.
        for tree in [build(&all[..1], kind), build(&all, kind)] {
            let (tree, aside) = (Arc::new(tree), [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [0.25, 0., 0.]]);
            let scene = scene_of(&[Instance::new(Arc::clone(&tree), aside)]);
            for i in 0..300 {
                let (from, to) = (random.point(), random.point());
                // Some are scaled before they are traced, and some hit nothing.
                let length = [1.0, 1e-30, 1e20, f32::NAN, 0.0][if i % 10 < 5 { i % 10 } else { 0 }];
                let ray =
                    Ray::new(from.map(|x| 3.0 * x), [0, 1, 2].map(|k| length * (to[k] - 3.0 * from[k])));
                let ray = if i % 20 == 19 { ray.within(2.0, 1.0) } else { ray };
                let answers = [
                    (tree.intersect_with_corners(&query, &ray), tree.intersect(&ray), tree.occluded(&ray)),
                    (scene.intersect_with_corners(&query, &ray), scene.intersect(&ray), scene.occluded(&ray)),
                ];
                for (which, (found, hit, any)) in answers.into_iter().enumerate() {
                    assert_eq!((found.map(|(hit, _)| hit), any), (hit, hit.is_some()), "{ray:?} {kind:?}");
                    if let Some((hit, Some(corners))) = found {
                        known[which] += 1;
                        let expected = all[hit.geom_id as usize].corners(hit.prim_id as usize);
                        assert_eq!(Some(corners), expected, "of {hit:?}, {kind:?}");
                    }
                }
            }
        }
    }
    assert!(known.iter().all(|&known| known > 500), "fast trees of triangles have them: {known:?}");
}

#[test]
fn kinds_and_instances() {
    let positions = [[0., 0., 0.], [2., 0., 0.], [2., 2., 1.], [0., 2., 0.]];
    let quad = Quads { positions: &positions, indices: &[[0, 1, 2, 3]] };
    let balls = Spheres { centers: &[[0.0, 0.0, 5.0]], radii: &[1.0] };
    let geometries = [quad.into(), balls.into()];
    let object = ObjectTree::build_from(&geometries, &BuildOptions::default(), Threads::Single);
    for (x, y, corners) in [(0.5, 0.5, [0, 1, 3]), (1.6, 1.7, [2, 3, 1])] {
        let hit = object.intersect(&Ray::new([x, y, 3.0], [0.0, 0.0, -1.0])).expect("the quad is there");
        let expected = normal_of(corners.map(|i: usize| positions[i]));
        assert!(along(object.normal(&hit).expect("a quad"), expected) > 0.999_99, "half at {x}");
    }
    let ray = Ray::new([0.6, 0.0, 9.0], [0.0, 0.0, -1.0]);
    let hit = object.intersect(&ray).expect("the ball is there");
    assert_eq!(object.normal(&hit), None, "a ball's normal needs the point");
    let normal = object.normal_at(&hit, ray.at(hit.t).map(f64::from)).expect("a ball");
    assert!(along(normal, [0.6, 0.0, 0.8]) > 0.999_99, "{normal:?}");

    // Mirrored and stretched along x.
    let columns = [[-2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [100.0, 0.0, 0.0]];
    let inner = Arc::new(scene_of(&[Instance::new(Arc::new(object), columns)]));
    let scene = scene_of(&[Instance::identity(Arc::clone(&inner)), Instance::identity(inner)]);
    let hit = scene.intersect(&Ray::new([96.8, 1.7, 3.0], [0.0, 0.0, -1.0])).expect("the quad is there");
    let normal = scene.normal(&hit).expect("a quad");
    let mut edges = normal_of([2, 3, 1].map(|i: usize| positions[i]));
    edges[0] /= -2.0;
    let length = along(edges, edges).sqrt();
    assert!(along(normal, edges) / length > 0.999_99, "{normal:?}, not along {edges:?}");
}

#[test]
fn faces_are_looked_through() {
    let query = Query::default();
    for kind in WATERTIGHT {
        let cube = Arc::new(build(&[closed::cube(2)], kind));
        let mirrored = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
        let scene = scene_of(&[Instance::new(Arc::clone(&cube), mirrored)]);
        let ray = Ray::new([0.3, 0.2, 5.0], [0.0, 0.0, -1.0]);
        for (face, t) in [(Face::Front, 4.0), (Face::Back, 6.0)] {
            assert_eq!(cube.intersect_face(&query, &ray, face).map(|hit| hit.t), Some(t), "{face:?}");
            assert_eq!(
                scene.intersect_face(&query, &ray, face).map(|hit| hit.t),
                Some(t),
                "{face:?}, mirrored"
            );
            assert_eq!(cube.occluded_face(&query, &ray.within(0.0, 5.0), face), t < 5.0, "{face:?} within 5");
            let mut hits = HitBatch::default();
            cube.intersect_batch_face(&query, &RayBatch::from_iter([ray; 3]), face, &mut hits);
            assert!(hits.t.iter().all(|&found| found == t), "{face:?}: {:?}", hits.t);
        }
        let inside = Ray::new([0.3, 0.2, 0.0], [0.0, 0.0, -1.0]);
        assert_eq!(cube.intersect_face(&query, &inside, Face::Front), None, "from inside no front is seen");
    }
}
