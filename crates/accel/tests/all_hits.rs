// SPDX-License-Identifier: GPL-3.0-or-later
//! All hits of a ray: each triangle that is hit, once, in order, in every structure and at every level; the first `n` are
//! the beginning of that list.

use crate::common::{WATERTIGHT, build};
use gnurt_accel::{Hit, Level, ObjectTree, Query, Ray};
use gnurt_testkit::{OracleInstance, Soup, oracle, rays};
use proptest::prelude::*;

/// The list, the same at every level and for every bound.
fn all_hits(object: &ObjectTree, ray: &Ray) -> Vec<Hit> {
    let mut first: Option<Vec<Hit>> = None;
    for level in Level::available() {
        let query = Query { level, ..Query::default() };
        let mut hits = Vec::new();
        object.all_hits(&query, ray, &mut hits);
        assert_eq!(object.count_hits(&query, ray), hits.len(), "counted at {level}");
        for n in 0..hits.len() + 2 {
            let mut some = Vec::new();
            object.first_hits(&query, ray, n, &mut some);
            assert_eq!(some, hits[..n.min(hits.len())], "the first {n} of {ray:?} at {level}");
        }
        assert_eq!(object.intersect_with(&query, ray), hits.first().copied(), "the closest one at {level}");
        let first = first.get_or_insert_with(|| hits.clone());
        assert_eq!(*first, hits, "{ray:?} at {level}");
    }
    first.unwrap_or_default()
}

fn check(meshes: &[Soup], rays: &[Ray]) {
    let objects = WATERTIGHT.map(|kind| build(meshes, kind));
    let instances = [OracleInstance::identity(meshes)];
    for ray in rays {
        let hits = all_hits(&objects[0], ray);
        for (object, kind) in objects.iter().zip(WATERTIGHT).skip(1) {
            assert_eq!(hits, all_hits(object, ray), "{kind:?} finds what {:?} does", WATERTIGHT[0]);
        }
        assert!(hits.is_sorted_by_key(|hit| (hit.t, hit.primitive())), "in order: {hits:?}");
        let ids =
            |geom_id, prim_id| hits.iter().filter(move |h| (h.geom_id, h.prim_id) == (geom_id, prim_id));
        let ends = [f64::from(ray.t_near), f64::from(ray.t_far)];
        let (slack, whole) = (1e-5, [f64::NEG_INFINITY, f64::INFINITY]);
        for sure in
            oracle::all_hits(&instances, (ray.org, ray.dir), [ends[0] + slack, ends[1] - slack], -2e-5)
        {
            let found = ids(sure.geom_id, sure.prim_id).count();
            assert_eq!(found, 1, "{sure:?} is in the list of {ray:?} once: {hits:?}");
        }
        let possible = oracle::all_hits(&instances, (ray.org, ray.dir), whole, 2e-5);
        for hit in &hits {
            let known = possible.iter().any(|o| (o.geom_id, o.prim_id) == (hit.geom_id, hit.prim_id));
            assert!(known, "{ray:?} does not hit {hit:?}");
            assert!(hit.t >= ray.t_near && hit.t <= ray.t_far, "{hit:?} is within {ray:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn lists_equal_brute_force(
        seed in any::<u64>(), n in 1..300usize, size in 0.05..1.5f32, near in 0.0..0.4f32, length in 0.2..3.0f32,
    ) {
        let meshes = [Soup::random(seed, n, size), Soup::random(seed ^ 1, n / 3, size)];
        let rays: Vec<Ray> = rays::random(seed, 12)
            .into_iter()
            .map(|(org, dir)| Ray::new(org, dir).within(near, near + length))
            .collect();
        check(&meshes, &rays);
    }
}

#[test]
fn large_triangles_are_listed_once() {
    // Triangles much larger than their leaves: spatial splits and kd-trees list them many times.
    let meshes = [Soup::random(3, 400, 2.0), Soup::slivers(4, 60)];
    for kind in [WATERTIGHT[1], WATERTIGHT[3]] {
        let object = build(&meshes[..1], kind);
        let doubled = object.stats().references > object.stats().primitives + 100;
        assert!(
            doubled || kind.0 == gnurt_accel::Structure::Bvh,
            "{:?} lists triangles twice",
            object.stats()
        );
    }
    let rays: Vec<Ray> = rays::random(5, 60).into_iter().map(|(org, dir)| Ray::new(org, dir)).collect();
    check(&meshes[..1], &rays);
}

#[test]
fn copies_and_huge_and_tiny_directions() {
    let meshes = [Soup::copies(100)];
    for scale in [1.0f32, 1e-20, 1e20, 3e-38] {
        let ray = Ray::new([0.1, 0.0, 3.0], [0.0, 0.0, -scale]);
        for kind in WATERTIGHT {
            let hits = all_hits(&build(&meshes, kind), &ray);
            if scale > 1e-37 {
                let ids: Vec<u32> = hits.iter().map(|hit| hit.prim_id).collect();
                assert_eq!(ids, (0..100).collect::<Vec<_>>(), "all copies in order, scale {scale:e}");
            }
        }
    }
}
