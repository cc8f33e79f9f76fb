// SPDX-License-Identifier: GPL-3.0-or-later
//! Compact trees answer as the others do, bit for bit, to every kind of question and on every way, and take less than half of
//! their memory.

use std::sync::Arc;

use crate::common::{QueryTarget, batch, run_queries, scene_of};
use gnurt_accel::{
    Aabb, BuildOptions, Geometry, Instance, Memory, ObjectTree, Quads, Quality, Query, Ray, RayBatch,
    Spheres, Threads, Triangles, UserGeometry, UserHit,
};
use gnurt_testkit::{Random, Soup, closed, rays};

/// A tree of either kind over triangles.
fn pair(soup: &Soup, quality: Quality) -> [ObjectTree; 2] {
    [Memory::Fast, Memory::Compact].map(|memory| {
        let options = BuildOptions { quality, memory, ..BuildOptions::default() };
        crate::common::build_with(std::slice::from_ref(soup), &options, Threads::Single)
    })
}

fn bytes(tree: &ObjectTree) -> u64 {
    tree.stats().tree_bytes + tree.stats().primitive_bytes
}

/// Closest and any hits in all ways, all hits, filtered ones.
fn assert_same<T: QueryTarget>(name: &str, [fast, compact]: [&T; 2], rays: &RayBatch) {
    let hits = run_queries(fast, rays);
    assert!(hits.iter().flatten().count() > 0, "{name}: rays hit");
    assert_eq!(hits, run_queries(compact, rays), "{name}: closest hits");
    for i in 0..rays.len() {
        let ray = rays.get(i);
        assert_eq!(fast.all(&ray), compact.all(&ray), "{name}: all hits of {ray:?}");
    }
}

/// Rays from everywhere around a box.
fn around(bounds: &Aabb, seed: u64, count: usize) -> RayBatch {
    let middle = [0, 1, 2].map(|k| 0.5 * (bounds.min[k] + bounds.max[k]));
    let half = (0..3).map(|k| bounds.max[k] - middle[k]).fold(0.0, f32::max);
    let plain = rays::random(seed, count).into_iter();
    let plain = plain.map(|(org, dir)| ([0, 1, 2].map(|k| middle[k] + half * org[k]), dir));
    batch(&plain.collect::<Vec<_>>())
}

#[test]
fn triangles_are_hit_alike() {
    let scaled = |mut soup: Soup, by: f32| {
        soup.positions.iter_mut().flatten().for_each(|x| *x *= by);
        soup
    };
    let soups = [
        ("soup", Soup::random(1, 500, 0.3)),
        ("one", Soup::random(2, 1, 2.0)),
        ("grid", Soup::grid(3, 300)),
        ("torus", closed::torus(24)),
        ("flat but for one bit", Soup::flat_but_for_one_bit(31, 400)),
        ("slivers", Soup::slivers(19, 200)),
        ("bad ones among them", Soup::degenerate(13, 200)),
        ("far away", scaled(closed::torus(12), 64.0).moved([1e6, -1e6, 5e5])),
        ("tiny", scaled(closed::torus(12), 1e-12)),
        ("huge", scaled(closed::torus(12), 1e12)),
    ];
    for (name, soup) in soups {
        for quality in [Quality::Fast, Quality::Medium, Quality::High] {
            let [fast, compact] = &pair(&soup, quality);
            assert_eq!(fast.bounds(), compact.bounds(), "{name}");
            assert_eq!(fast.bad_primitives(), compact.bad_primitives(), "{name}");
            let bounds = fast.bounds();
            assert_same(name, [fast, compact], &around(&bounds, 5, 300));
            let mut random = Random::new(6);
            for _ in 0..50 {
                let point = [0, 1, 2].map(|k| {
                    let within = 0.5 + 0.7 * f64::from(random.point()[k]);
                    f64::from(bounds.min[k]) + within * f64::from(bounds.max[k] - bounds.min[k])
                });
                let near = [fast, compact].map(|tree| tree.closest_point(point, f64::INFINITY));
                assert_eq!(near[0], near[1], "{name}: nearest to {point:?}");
            }
        }
    }
}

#[test]
fn less_than_half_of_the_memory() {
    for quality in [Quality::Fast, Quality::Medium, Quality::High] {
        let [fast, compact] = &pair(&closed::torus(100), quality);
        let (fast, compact) = (bytes(fast), bytes(compact));
        assert!(2 * compact < fast, "{compact} bytes, and {fast} otherwise");
        // The number of unshared corners stays the same.
        let [fast, compact] = &pair(&Soup::random(7, 20_000, 0.01), quality);
        let (fast, compact) = (bytes(fast), bytes(compact));
        assert!(10 * compact < 11 * fast, "{compact} bytes of a soup, and {fast} otherwise");
    }
}

/// Boxes that are hit where they are entered.
#[derive(Debug)]
struct Boxes(Vec<[f32; 3]>);

impl UserGeometry for Boxes {
    fn count(&self) -> u32 {
        self.0.len() as u32
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        let center = self.0[prim_id as usize];
        Aabb { min: center.map(|x| x - 0.05), max: center.map(|x| x + 0.05) }
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        let Aabb { min, max } = self.bounds(prim_id);
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for k in 0..3 {
            let to = |x: f32| (f64::from(x) - f64::from(ray.org[k])) / f64::from(ray.dir[k]);
            enter = enter.max(to(min[k]).min(to(max[k])));
            leave = leave.min(to(min[k]).max(to(max[k])));
        }
        if enter <= leave {
            hit(UserHit { t: enter as f32, u: 0.0, v: 0.0 });
        }
    }
}

#[test]
fn all_kinds_are_hit_alike() {
    let mut random = Random::new(8);
    let mut points = |count: usize| (0..count).map(|_| random.point()).collect::<Vec<_>>();
    let (mesh, centers, boxes) = (closed::torus(12), points(300), Arc::new(Boxes(points(300))));
    let radii: Vec<f32> = (0..300).map(|i| 0.01 + 0.0005 * i as f32).collect();
    let quads = points(400);
    let indices: Vec<[u32; 4]> = (0..100).map(|i| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]).collect();
    let geometries = [
        Geometry::from(Triangles { positions: &mesh.positions, indices: &mesh.indices }),
        Quads { positions: &quads, indices: &indices }.into(),
        Spheres { centers: &centers, radii: &radii }.into(),
        Geometry::user(boxes),
    ];
    let trees = [Memory::Fast, Memory::Compact].map(|memory| {
        let options = BuildOptions { memory, ..BuildOptions::default() };
        Arc::new(ObjectTree::build_from(&geometries, &options, Threads::Single))
    });
    let rays = around(&trees[0].bounds(), 9, 500);
    assert_same("an object", [&*trees[0], &*trees[1]], &rays);
    assert!(bytes(&trees[1]) < bytes(&trees[0]), "smaller");
    for i in 0..rays.len() {
        let ray = rays.get(i);
        let even = |tree: &ObjectTree| {
            tree.intersect_filtered(&Query::default(), &ray, |_, hit| hit.prim_id % 2 == 0)
        };
        assert_eq!(even(&trees[0]), even(&trees[1]), "every second primitive of {ray:?}");
        let others = |tree: &ObjectTree| {
            let first = tree.intersect(&ray)?;
            tree.intersect_ignoring(&Query::default(), &ray, first.primitive())
        };
        assert_eq!(others(&trees[0]), others(&trees[1]), "the next of {ray:?}");
    }
    let scenes = trees.map(|tree| {
        let placement = |i: u32| {
            let rotation = [[0.0, 0.5, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.0, 0.7]];
            let at = [f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0, 0.3 * f64::from(i)];
            Instance::new(Arc::clone(&tree), [rotation[0], rotation[1], rotation[2], at])
        };
        let row = Arc::new(scene_of(&(0..9).map(placement).collect::<Vec<_>>()));
        scene_of(&[Instance::identity(row)])
    });
    let rays = around(&scenes[0].bounds(), 10, 500);
    assert_same("a scene", [&scenes[0], &scenes[1]], &rays);
}
