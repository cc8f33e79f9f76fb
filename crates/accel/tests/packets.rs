// SPDX-License-Identifier: GPL-3.0-or-later
//! Packets of any size, of rays that go one way or all ways, with masks and without, get the answers of their rays alone.

use std::sync::Arc;

use crate::common::{QueryTarget, WATERTIGHT, build, queries, scene_of};
use gnurt_accel::{
    Geometry, GeometryKind, Hit, Instance, ObjectTree, Packet, Query, Ray, SceneTree, Threads, Triangles,
};
use gnurt_testkit::{Random, Soup};

/// Rays near each other, or all over the place; some of other masks, and some that are none.
fn some(random: &mut Random, count: usize, round: usize) -> Vec<Ray> {
    let (org, dir) = (random.point(), random.point());
    (0..count)
        .map(|i| {
            let (a, b) = (random.point(), random.point());
            let wide = if round.is_multiple_of(2) { 0.05 } else { 2.0 };
            let along = |from: [f32; 3], by: [f32; 3]| [0, 1, 2].map(|k| from[k] + wide * by[k]);
            let ray = Ray::new(along(org, a), along(dir, b)).within(0.0, random.between(0.5, 9.0));
            match (round % 5, i % 4) {
                (3, 1) => ray.with_mask(0b10),
                (4, 2) => Ray { dir: [0.0; 3], ..ray },
                _ => ray,
            }
        })
        .collect()
}

fn check<T: QueryTarget>(tree: &T, packets: impl Fn(&Query, Packet) -> (Vec<(usize, Hit)>, u64), seed: u64) {
    let mut random = Random::new(seed);
    let mut hits = 0;
    for query in queries() {
        for round in 0..60 {
            let rays = some(&mut random, round % (Packet::MOST + 1), round);
            let mut packet = Packet::new();
            rays.iter().for_each(|ray| packet.push(ray));
            assert_eq!(packet.len(), rays.len(), "all are in");
            let (reported, bits) = packets(&query, packet);
            let single: Vec<(usize, Hit)> =
                rays.iter().enumerate().filter_map(|(i, ray)| Some((i, tree.one(&query, ray)?))).collect();
            assert_eq!(reported, single, "{query:?}, {rays:?}");
            assert_eq!(bits, single.iter().map(|(i, _)| 1 << i).sum::<u64>(), "{query:?}, {rays:?}");
            hits += reported.len();
        }
    }
    assert!(hits > 300, "{hits} hits are enough to tell");
}

macro_rules! of {
    ($tree:expr) => {
        |query: &Query, packet: Packet| {
            let mut reported = Vec::new();
            $tree.intersect_packet(query, packet.clone(), |i, hit| reported.push((i, hit)));
            (reported, $tree.occluded_packet(query, packet))
        }
    };
}

#[test]
fn packets_answer_as_their_rays_do() {
    let soup = Soup::random(5, 400, 0.4);
    for kind in [WATERTIGHT[0], WATERTIGHT[3], WATERTIGHT[5]] {
        let object: ObjectTree = build(std::slice::from_ref(&soup), kind);
        check(&object, of!(object), 7);
    }
    let meshes = [1, 2].map(|seed| Soup::random(seed, 100, 0.5));
    let masked: Vec<Geometry> = [0b1, 0b10]
        .iter()
        .zip(&meshes)
        .map(|(&mask, mesh)| {
            let triangles = Triangles { positions: &mesh.positions, indices: &mesh.indices };
            Geometry::new(GeometryKind::Triangles(triangles)).with_mask(mask)
        })
        .collect();
    let object = Arc::new(ObjectTree::build_from(&masked, &Default::default(), Threads::Single));
    check(&*object, of!(object), 8);
    let aside = [[0.0, 0.8, 0.6], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8], [0.5, 0.25, -1.0]];
    let scene: SceneTree = scene_of(&[Instance::new(Arc::clone(&object), aside), Instance::identity(object)]);
    check(&scene, of!(scene), 9);
}
