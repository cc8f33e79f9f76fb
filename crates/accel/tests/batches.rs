// SPDX-License-Identifier: GPL-3.0-or-later
//! Batches through an object of several meshes get the hits of their rays alone: ids are found in lanes, rays beside the
//! object's box are not traced.

use std::sync::Arc;

use crate::common::{QueryTarget, queries, scene_of};
use gnurt_accel::{BuildOptions, Instance, ObjectTree, Ray, RayBatch, Threads, Triangles};
use gnurt_testkit::{Random, Soup};

/// From everywhere, also from far outside; every third beside the box, some without a direction.
fn some(random: &mut Random, count: usize, distance: f32) -> RayBatch {
    (0..count)
        .map(|i| {
            let (from, to) = (random.point(), random.point());
            let beside = if i % 3 == 0 { 2.5 * distance } else { 0.0 };
            let org = from.map(|x| distance * x);
            let dir = [to[0] + beside - org[0], to[1] - org[1], to[2] - org[2]];
            // In one tile only: others are written as a whole.
            Ray::new(org, if i == 77 { [0.0; 3] } else { dir })
        })
        .collect()
}

/// An object of `count` meshes, one of which is empty.
fn object(count: usize) -> ObjectTree {
    let soups: Vec<Soup> =
        (0..count).map(|i| Soup::random(i as u64, if i == 1 { 0 } else { 1 + 60 / count }, 0.6)).collect();
    let meshes: Vec<Triangles> =
        soups.iter().map(|soup| Triangles { positions: &soup.positions, indices: &soup.indices }).collect();
    ObjectTree::build(&meshes, &BuildOptions::default(), Threads::Single)
}

/// The number of hits.
fn check<T: QueryTarget>(tree: &T) -> usize {
    let mut found = 0;
    for query in queries() {
        for distance in [1.0, 4.0, 50.0] {
            let rays = some(&mut Random::new(9), 3 * 64 + 17, distance);
            let (hits, occluded) = tree.run_queries(&query, &rays);
            for (i, &is_occluded) in occluded.iter().enumerate() {
                let alone = tree.one(&query, &rays.get(i));
                assert_eq!(hits.get(i), alone, "{query:?}, {:?}", rays.get(i));
                assert_eq!(is_occluded, alone.is_some(), "{query:?}, {:?}", rays.get(i));
                found += usize::from(is_occluded);
            }
        }
    }
    found
}

#[test]
fn rays_of_batches_get_the_hits_of_rays_alone() {
    // More meshes than are compared in lanes, too.
    for count in [1, 2, 7, 64, 65] {
        let object = Arc::new(object(count));
        let found = check(&*object);
        let scene = scene_of(&[Instance::new(object, IDENTITY)]);
        assert_eq!(found, check(&scene), "a scene of one object is that object");
        assert!(found > 1000, "{found} hits of {count} meshes are enough to tell");
    }
}

const IDENTITY: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
