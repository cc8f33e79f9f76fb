// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays at the limits of floats, batches made by hand, threads with small stacks.

use std::sync::Arc;

use crate::common::{TESTS, WATERTIGHT, build, queries, run_queries, scene_of};
use gnurt_accel::{
    HitBatch, Instance, Level, ObjectTree, Pencil, Query, Ray, Ray64, RayBatch, Record, Spheres,
};
use gnurt_testkit::{Random, Soup, closed, rays};

/// A ray from `org` through `to`.
fn through(org: [f32; 3], to: [f32; 3]) -> Ray {
    Ray::new(org, [0, 1, 2].map(|k| to[k] - org[k]))
}

/// Beyond about 1e19 products of coordinates overflow: every level and every kind of query still gives the
/// same bits, and a ray aimed at the middle of a triangle hits it.
#[test]
fn origins_beyond_1e19_are_alike_at_every_level() {
    let mut random = Random::new(3);
    for (size, away) in [(1.5e18f32, 1e20f32), (1.5e18, 3e19), (1e17, 1e19), (1.0, 9e19)] {
        let mut soup = Soup::default();
        for _ in 0..60 {
            soup.push([random.point(), random.point(), random.point()].map(|p| p.map(|x| x * size)));
        }
        let mut batch = RayBatch::default();
        for indices in &soup.indices {
            let [a, b, c] = indices.map(|i| soup.positions[i as usize]);
            let middle = [0, 1, 2].map(|k| a[k] / 3.0 + b[k] / 3.0 + c[k] / 3.0);
            for _ in 0..6 {
                let from = random.point();
                let longest = from.iter().fold(1e-6f32, |most, x| most.max(x.abs()));
                batch.push(through(from.map(|x| x / longest * away), middle));
                batch.push(through(from.map(|x| x / longest * away), a));
            }
        }
        for (kind, _) in TESTS {
            // Where the objects are far larger than a float's steps at the rays' distance, they are hit.
            let hits = run_queries(&build(std::slice::from_ref(&soup), kind), &batch);
            let count = hits.iter().flatten().count();
            assert!(size < 1e18 || count > batch.len() / 3, "{kind:?}: {count} hits of {}", batch.len());
        }
    }
}

/// The shortest direction of all moves, too, and nothing about it is special but the size of `t`.
#[test]
fn directions_of_any_length_hit() {
    let mut soup = Soup::default();
    soup.push([[-1e-8, -1e-8, 1e-8], [3e-8, -1e-8, 1e-8], [-1e-8, 3e-8, 1e-8]]);
    let lengths: Vec<f32> = (-149..100).step_by(5).map(|exponent| 2f64.powi(exponent) as f32).collect();
    let batch: RayBatch = lengths.iter().map(|&length| Ray::new([0.0; 3], [0.0, 0.0, length])).collect();
    for (kind, _) in TESTS {
        let object = Arc::new(build(std::slice::from_ref(&soup), kind));
        let instance_at = |x: f64| {
            Instance::new(
                Arc::clone(&object),
                [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, 0.0, 0.0]],
            )
        };
        let scene = scene_of(&[instance_at(0.0), instance_at(1.0)]);
        for hits in [run_queries(&*object, &batch), run_queries(&scene, &batch)] {
            for (hit, length) in hits.iter().zip(&lengths) {
                let t = hit.unwrap_or_else(|| panic!("{length:e} misses, {kind:?}")).t;
                let expected_t = (1e-8 / f64::from(*length)) as f32;
                assert!(
                    (t - expected_t).abs() <= 1e-6 * expected_t,
                    "{t:e}, not {expected_t:e}, for {length:e}, {kind:?}"
                );
            }
        }
        let all = queries().iter().all(|query| object.first_hit_of(query, &batch.get(0)));
        assert!(all, "filters see it, too, {kind:?}");
    }
}

/// Near ends below zero are unsupported, but hits are right: surfaces behind the origin are found from the
/// near end on.
#[test]
fn near_ends_below_zero_see_what_is_behind() {
    let soup = Soup::random(5, 300, 0.3);
    let mut plain = rays::random(6, 200);
    plain.extend(rays::aimed(&closed::sphere(5), [0.2, -0.1, 3.0], 1));
    let forwards: RayBatch = plain.iter().map(|&(org, dir)| Ray::new(org, dir).within(-8.0, 3.0)).collect();
    // The same line from eight steps behind, on the same floats as far as these reach.
    for kind in WATERTIGHT {
        let tree = build(std::slice::from_ref(&soup), kind);
        let found = run_queries(&tree, &forwards);
        let behind = found.iter().flatten().filter(|hit| hit.t < 0.0).count();
        assert!(behind > 20, "{behind} hits lie behind");
        for (i, hit) in found.iter().enumerate() {
            let mut all = Vec::new();
            tree.all_hits(&Query::default(), &forwards.get(i), &mut all);
            assert_eq!(hit.map(|hit| hit.t), all.first().map(|hit| hit.t), "the first of all, {kind:?}");
        }
    }
}

/// A batch whose arrays do not go together is refused by name, before anything is traced.
#[test]
#[should_panic(expected = "a batch of 3 rays (t_near) has 2 values in dir[1]")]
fn batches_made_badly_by_hand_are_named() {
    let mut batch: RayBatch = [Ray::new([0.0; 3], [1.0; 3]); 3].into_iter().collect();
    batch.dir[1].pop();
    let tree = build(&[closed::cube(1)], WATERTIGHT[0]);
    tree.intersect_batch(&Query::default(), &batch, &mut HitBatch::default(), &mut Record::default());
}

/// Everything that can be asked, of scenes in scenes as deep as they go and of a tree whose rays take turns, on a stack
/// of 128 KB.
#[test]
fn small_stacks_are_enough() {
    let large = Arc::new(build(&[Soup::random(4, 60_000, 0.1)], WATERTIGHT[0]));
    let small = Arc::new(build(&[closed::sphere(6)], WATERTIGHT[3]));
    let compact = Arc::new(build(&[closed::torus(8)], WATERTIGHT[5]));
    let balls = Spheres { centers: &[[0.0, 2.0, 0.0]], radii: &[0.5] };
    let balls = ObjectTree::build_from(&[balls.into()], &Default::default(), Default::default());
    let at = |x: f64| [[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, 0.0, 0.0]];
    let mut scene = Arc::new(scene_of(&[
        Instance::identity(large),
        Instance::new(small, at(2.0)),
        Instance::new(compact, at(-2.0)),
        Instance::new(Arc::new(balls), at(0.5)),
    ]));
    for level in 1..gnurt_accel::DEEPEST_SCENE {
        // The offset instance is far enough away to cost no time.
        let offset = Instance::new(Arc::clone(&scene), at(1000.0 * f64::from(level)));
        scene = Arc::new(scene_of(&[Instance::new(scene, at(0.001)), offset]));
    }
    assert_eq!(scene.depth(), gnurt_accel::DEEPEST_SCENE, "scenes in one another");
    let mut plain = rays::random(1, 200);
    plain.extend(rays::aimed(&closed::sphere(4), [0.2, -0.1, 3.0], 1));
    let batch = crate::common::batch(&plain);
    let requests = std::thread::Builder::new().stack_size(128 << 10).spawn(move || {
        let mut hit = 0;
        for query in queries() {
            let (mut hits, mut occluded, mut record) = (HitBatch::default(), Vec::new(), Record::default());
            scene.intersect_batch(&query, &batch, &mut hits, &mut record);
            scene.occluded_batch(&query, &batch, &mut occluded, &mut record);
            hit += occluded.iter().filter(|&&hit| hit).count();
        }
        for level in Level::available() {
            let query = Query { level, ..Query::default() };
            let (org, dir) = plain[0];
            let ray = Ray64 { ..Ray64::new(org.map(f64::from), dir) };
            let mut all = Vec::new();
            scene.first_hits(&query, &ray, 3, &mut all);
            let near = scene.closest_point_with(&query, [0.1, 0.2, 9.0], 20.0);
            hit += usize::from(near.is_some());
            let mut pencil = Box::new(Pencil::EMPTY);
            pencil.org = [0.0, 0.0, 4.0];
            let (dirs, ends) = pencil.lanes();
            for i in 0..Pencil::MOST {
                (dirs[0][i], dirs[1][i], dirs[2][i]) = (0.01 * i as f32 - 0.3, 0.1, -1.0);
                ends[i] = f32::INFINITY;
            }
            hit += scene.occluded_pencil(&query, &mut pencil, &mut Record::default()).count_ones() as usize;
        }
        hit
    });
    let hit = requests.expect("threads start").join().expect("nothing is wrong");
    assert!(hit > 1000, "{hit} hits");
}

/// Whether a filter is shown a hit.
trait Shown {
    fn first_hit_of(&self, query: &Query, ray: &Ray) -> bool;
}

impl Shown for ObjectTree {
    fn first_hit_of(&self, query: &Query, ray: &Ray) -> bool {
        self.occluded_filtered(query, ray, |_, hit| hit.t > 0.0)
    }
}
