// SPDX-License-Identifier: GPL-3.0-or-later
//! Primitives that touch boxes and balls, and the nearest ones, equal brute force: over all triangles by whole numbers or by
//! cutting, and by nearest points.

use std::sync::Arc;

use gnurt_accel::{
    BuildOptions, Instance, Lists, ObjectTree, PointHit, PrimitiveId, Quads, Query, Spheres, Threads,
    Triangles,
};
use gnurt_testkit::{Random, Soup, closed};

use crate::common::{WATERTIGHT, build, scene_of};

/// The part of a triangle in a box, cut side by side; multiples of small powers of two are cut exactly enough
/// to decide whether it is empty.
fn is_in_box(corners: [[f32; 3]; 3], min: [f64; 3], max: [f64; 3]) -> bool {
    let mut polygon: Vec<[f64; 3]> = corners.map(|p| p.map(f64::from)).into();
    for k in 0..3 {
        for (side, at) in [(1.0, min[k]), (-1.0, -max[k])] {
            let depth = |p: &[f64; 3]| side * p[k] - at;
            let mut cut = Vec::new();
            for i in 0..polygon.len() {
                let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                let (a, b) = (depth(&p), depth(&q));
                if a >= 0.0 {
                    cut.push(p);
                }
                if a * b < 0.0 {
                    let mut between = [0, 1, 2].map(|j| p[j] + (q[j] - p[j]) * (a / (a - b)));
                    between[k] = side * at;
                    cut.push(between);
                }
            }
            polygon = cut;
        }
    }
    !polygon.is_empty()
}

#[test]
fn boxes_equal_brute_force() {
    let mut random = Random::new(2);
    for (round, kind) in WATERTIGHT.iter().enumerate() {
        for mesh in [Soup::random(round as u64, 200, 0.4), closed::sphere(10), closed::cube(4)] {
            let tree = build(std::slice::from_ref(&mesh), *kind);
            let (mut boxes, mut lists) = (Vec::new(), Lists::default());
            for _ in 0..60 {
                let (at, size) = (random.point(), random.pick(&[0.0, 0.05, 0.3, 1.5]));
                let min = at.map(|x| f64::from((x * 16.0).round() / 16.0));
                boxes.push([min, min.map(|x| x + size)]);
            }
            tree.touching_box_batch(&Query::default(), &boxes, Threads::Single, &mut lists);
            assert_eq!(lists.len(), boxes.len(), "a list each");
            for (&[min, max], ids) in boxes.iter().zip(lists.iter()) {
                assert!(ids.is_sorted_by(|a, b| a < b), "in order, each once");
                for i in 0..mesh.indices.len() {
                    let corners = mesh.corners(i).expect("a triangle");
                    let found = ids.iter().any(|id| id.prim_id == i as u32);
                    // If cutting rounds, a primitive that just touches may be in either set.
                    let slack = 1e-9;
                    let (less, more) = (min.map(|x| x - slack), max.map(|x| x + slack));
                    if is_in_box(corners, min, max) {
                        assert!(found, "{corners:?} touches {min:?} to {max:?}, {kind:?}");
                    } else if !is_in_box(corners, less, more) {
                        assert!(!found, "{corners:?} is apart from {min:?} to {max:?}, {kind:?}");
                    }
                }
            }
        }
    }
    let cube = build(&[closed::cube(1)], WATERTIGHT[0]);
    let mut ids = Vec::new();
    let everywhere = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];
    for (min, max, count) in [
        (everywhere[0], everywhere[1], 12),
        ([-0.5; 3], [0.5; 3], 0),
        ([1.0; 3], [2.0; 3], 6),
        ([f64::NAN; 3], [2.0; 3], 0),
        ([0.5; 3], [-0.5; 3], 0),
        ([1.0000001; 3], [2.0; 3], 0),
    ] {
        cube.touching_box(&Query::default(), min, max, &mut ids);
        // A corner of a cube belongs to three faces, to one or two triangles of each.
        let right = if count == 6 { (3..=6).contains(&ids.len()) } else { ids.len() == count };
        assert!(right, "{min:?} to {max:?}: {ids:?}");
    }
}

#[test]
fn the_nearest_primitives_equal_brute_force() {
    let mut random = Random::new(8);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    for kind in WATERTIGHT {
        let mesh = Soup::random(1, 150, 0.3);
        let tree = build(std::slice::from_ref(&mesh), kind);
        let single: Vec<ObjectTree> = (0..mesh.indices.len())
            .map(|i| {
                let mut one = Soup::default();
                one.push(mesh.corners(i).expect("a triangle"));
                build(&[one], kind)
            })
            .collect();
        let points: Vec<[f64; 3]> = (0..150).map(|_| random.point().map(f64::from)).collect();
        let query = Query::default();
        let mut lists = Lists::default();
        tree.nearest_primitives_batch(&query, &points, 0.8, 7, Threads::Pool(&pool), &mut lists);
        for (i, &point) in points.iter().enumerate() {
            let mut all: Vec<(f64, u32)> = single
                .iter()
                .zip(0..)
                .filter_map(|(tree, i)| Some((tree.closest_point(point, 0.8)?.distance, i)))
                .collect();
            all.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
            let found: Vec<(f64, u32)> = lists.get(i).iter().map(|hit| (hit.distance, hit.prim_id)).collect();
            assert_eq!(found, all[..all.len().min(7)], "around {point:?} in {kind:?}");
            let nearest = tree.closest_point(point, 0.8);
            assert_eq!(lists.get(i).first().copied(), nearest, "the first is the nearest");
            let mut ids = Vec::new();
            tree.touching_sphere(&query, point, 0.3, &mut ids);
            let mut near: Vec<u32> = all.iter().filter(|(d, _)| *d <= 0.3).map(|(_, i)| *i).collect();
            near.sort_unstable();
            assert!(ids.iter().map(|id| id.prim_id).eq(near), "within 0.3 of {point:?} in {kind:?}");
        }
    }
}

#[test]
fn mixed_objects_and_instances() {
    let positions = [[0., 0., 0.], [2., 0., 0.], [2., 2., 0.], [0., 2., 0.]];
    let quad = Quads { positions: &positions, indices: &[[0, 1, 2, 3]] };
    let balls = Spheres { centers: &[[0.0, 0.0, 5.0]], radii: &[1.0] };
    let mesh = Triangles { positions: &positions, indices: &[[0, 1, 2]] };
    let object = ObjectTree::build_from(
        &[quad.into(), balls.into(), mesh.into()],
        &BuildOptions::default(),
        Threads::Single,
    );
    let query = Query::default();
    let mut hits: Vec<PointHit> = Vec::new();
    object.nearest_primitives(&query, [1.0, 1.0, 1.0], f64::INFINITY, 9, &mut hits);
    let named: Vec<(u32, f64)> = hits.iter().map(|hit| (hit.geom_id, hit.distance)).collect();
    assert_eq!(&named[..2], [(0, 1.0), (2, 1.0)], "a quad is one primitive, ties go by id");
    assert_eq!(named.len(), 3, "and a ball");
    object.nearest_primitives(&query, [1.0, 1.0, 1.0], 1.0, 1, &mut hits);
    assert_eq!(hits.len(), 1, "no more than one");
    let mut ids: Vec<PrimitiveId> = Vec::new();
    object.touching_box(&query, [0.5, 0.5, -1.0], [1.5, 1.5, 1.0], &mut ids);
    assert_eq!(
        ids.iter().map(|id| id.geom_id).collect::<Vec<_>>(),
        [0, 2],
        "the quad once, and the triangle"
    );
    object.touching_box(&query, [-0.1, -0.1, 4.9], [0.1, 0.1, 5.1], &mut ids);
    assert!(ids.is_empty(), "a box in a ball touches nothing: {ids:?}");
    object.touching_box(&query, [-0.1, -0.1, 4.9], [0.1, 0.1, 6.1], &mut ids);
    assert_eq!(ids.len(), 1, "one through its rim does");
    let turned = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 2.0], [10.0, 0.0, 0.0]];
    let object = Arc::new(object);
    let scene = scene_of(&[Instance::identity(Arc::clone(&object)), Instance::new(object, turned)]);
    scene.touching_box(&query, [8.5, 0.5, -0.1], [8.6, 0.6, 0.1], &mut ids);
    let leaves: Vec<(u32, u32)> = ids.iter().map(|id| (id.leaf_id, id.geom_id)).collect();
    assert_eq!(leaves, [(1, 0)], "the quad of the second; its triangle lies beside");
    scene.touching_sphere(&query, [9.0, 1.0, 3.0], 3.0, &mut ids);
    assert!(ids.iter().all(|id| id.leaf_id == 1) && ids.len() == 2, "{ids:?}");
}

#[test]
fn visitors_see_what_is_near() {
    let tree = build(&[closed::sphere(10)], WATERTIGHT[0]);
    let (query, mut random, mut ids) = (Query::default(), Random::new(5), Vec::new());
    for _ in 0..50 {
        let point = random.point().map(f64::from);
        let mut reported = Vec::new();
        tree.visit_near(&query, point, 0.5, |hit| {
            let PointHit { leaf_id, geom_id, prim_id, .. } = *hit;
            reported.push(PrimitiveId { leaf_id, geom_id, prim_id });
            0.5
        });
        reported.sort_unstable();
        reported.dedup();
        tree.touching_sphere(&query, point, 0.5, &mut ids);
        assert_eq!(reported, ids, "all within the radius, near {point:?}");
        let mut nearest = f64::INFINITY;
        tree.visit_near(&query, point, nearest, |hit| {
            nearest = nearest.min(hit.distance);
            nearest
        });
        let closest = tree.closest_point(point, f64::INFINITY).map(|hit| hit.distance);
        assert_eq!(Some(nearest), closest, "the nearest of all is among them, near {point:?}");
    }
}

#[test]
fn visitors_see_a_triangle_alone_once() {
    let corners = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 1.0]];
    for kind in WATERTIGHT {
        let single = Soup { positions: corners.into(), indices: vec![[0, 1, 2]] };
        let (tree, mut count) = (build(&[single], kind), 0);
        tree.visit_near(&Query::default(), [0.0; 3], f64::INFINITY, |_| {
            count += 1;
            f64::INFINITY
        });
        assert_eq!(count, 1, "{kind:?}");
    }
}
