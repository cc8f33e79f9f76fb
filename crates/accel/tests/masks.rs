// SPDX-License-Identifier: GPL-3.0-or-later
//! Masks: a ray sees instances and geometries that have a bit in common with it, one by one and in tiles,
//! whether the rays of a batch have one mask or many. The list of all hits of a ray that sees everything is
//! the oracle.

use std::sync::Arc;

use crate::common::{QueryTarget, WATERTIGHT, options, queries, scene_of};
use gnurt_accel::{Geometry, Hit, Instance, ObjectTree, Query, Ray, RayBatch, Threads, Triangles};
use gnurt_testkit::{Random, Soup, closed, rays};

const MASKS: [u32; 4] = [1, 2, 6, u32::MAX];

fn object(meshes: &[Soup], kind: crate::common::Kind) -> ObjectTree {
    let triangles = meshes.iter().map(|m| Triangles { positions: &m.positions, indices: &m.indices });
    let geometries: Vec<Geometry> =
        triangles.enumerate().map(|(i, mesh)| Geometry::from(mesh).with_mask(MASKS[i % 4])).collect();
    ObjectTree::build_from(&geometries, &options(kind), Threads::Single)
}

/// Camera rays and random ones, with many masks, or with none at all.
fn some_rays(masked: bool) -> RayBatch {
    let mut plain = rays::aimed(&closed::sphere(5), [0.2, -0.1, 3.0], 2);
    plain.extend(rays::random(1, 300));
    let mut random = Random::new(4);
    let mask = |random: &mut Random| if masked { random.pick(&[0, 1, 2, 4, 8, 5, u32::MAX]) } else { !0 };
    plain.into_iter().map(|(org, dir)| Ray::new(org, dir).with_mask(mask(&mut random))).collect()
}

#[test]
fn rays_see_what_their_masks_say() {
    let meshes: Vec<Soup> = (0..6).map(|seed| Soup::random(seed, 40, 0.5)).collect();
    for kind in WATERTIGHT {
        let object = Arc::new(object(&meshes, kind));
        let placement = |i: u32| {
            let mut instance = Instance::identity(Arc::clone(&object)).with_mask(!(1 << (i % 3)));
            instance.world_from_object[3] = [f64::from(i) * 0.4 - 1.0, 0.1, f64::from(i % 2)];
            instance
        };
        let scene = scene_of(&(0..6).map(placement).collect::<Vec<_>>());
        let in_object = |hit: &Hit| MASKS[hit.geom_id as usize % 4];
        check(&*object, |mask, hit| in_object(hit) & mask != 0);
        check(&scene, |mask, hit| in_object(hit) & mask != 0 && !(1 << (hit.inst_id % 3)) & mask != 0);
    }
}

fn check(tree: &impl QueryTarget, sees: impl Fn(u32, &Hit) -> bool) {
    for (masked, common_mask) in [(true, !0), (false, 2), (true, 5), (false, 0)] {
        let rays = some_rays(masked);
        let expected: Vec<Option<Hit>> = (0..rays.len())
            .map(|i| {
                let ray = rays.get(i);
                let mask = ray.mask & common_mask;
                tree.all(&ray.with_mask(!0)).into_iter().find(|hit| sees(mask, hit))
            })
            .collect();
        let found = expected.iter().flatten().count();
        assert_eq!(found > 50, common_mask != 0, "{found} hits with {common_mask:b}");
        for query in queries() {
            let query = Query { mask: common_mask, ..query };
            let (hits, any) = tree.run_queries(&query, &rays);
            for (i, expected) in expected.iter().enumerate() {
                assert_eq!(hits.get(i), *expected, "{query:?}: {:?}", rays.get(i));
                assert_eq!(any[i], expected.is_some(), "{query:?}, any hit: {:?}", rays.get(i));
                assert_eq!(
                    tree.one(&query, &rays.get(i)),
                    *expected,
                    "{query:?}, one ray: {:?}",
                    rays.get(i)
                );
            }
        }
    }
}
