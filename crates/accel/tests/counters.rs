// SPDX-License-Identifier: GPL-3.0-or-later
//! Counters: packets in a kd-tree count the same as single rays, at every level, for closest and for any
//! hits. Tiles count the same nodes at every level that has them, and nearly the same triangles except at the
//! widest; costs per ray add up to the sums.

use std::sync::Arc;

use crate::common::{Kind, TESTS, WATERTIGHT, batch, build, queries, scene_of};
use gnurt_accel::{
    Coherence, Counters, HitBatch, Instance, Level, Query, RayBatch, Record, Structure, TriangleTest,
};
use gnurt_testkit::{Random, Soup, closed, rays};

/// Coherent ones, mixed ones that packets have to send singly, and one more than a whole number of packets.
fn some_rays() -> RayBatch {
    let mut plain = rays::aimed(&closed::sphere(5), [0.2, -0.1, 3.0], 1);
    plain.extend(rays::random(1, 300));
    plain.truncate(plain.len() / 8 * 8 + 1);
    batch(&plain)
}

#[test]
fn packets_count_what_single_rays_do() {
    let rays = some_rays();
    for (test, _) in TESTS {
        let object = build(&[closed::torus(12), Soup::random(2, 200, 0.4)], test);
        let mut first: Option<[Counters; 2]> = None;
        // Tiles go through leaves of blocks together.
        let exact = matches!(test, Kind(Structure::Kd, _, TriangleTest::Projected, _));
        for query in queries() {
            let (mut closest, mut any) = (Record::default(), Record::default());
            object.intersect_batch(&query, &rays, &mut HitBatch::default(), &mut closest);
            object.occluded_batch(&query, &rays, &mut Vec::new(), &mut any);
            let counted = [closest.counters, any.counters];
            let expected = *first.get_or_insert(counted);
            assert!(!exact || expected == counted, "{query:?}: {counted:?}, not {expected:?} of single rays");
            let [all, any] = counted;
            assert_eq!((all.rays, any.rays), (rays.len() as u64, rays.len() as u64), "rays asked for");
            assert!(all.nodes > all.rays / 2 && all.triangles > all.rays / 4, "{all:?} for many rays");
            assert!(
                any.nodes < all.nodes && any.triangles <= all.triangles,
                "any hit is less: {any:?}, {all:?}"
            );
        }
    }
}

#[test]
fn all_levels_with_tiles_count_the_same_in_a_scene() {
    for kind in &WATERTIGHT[3..4] {
        let rays = some_rays();
        let object = Arc::new(build(&[closed::sphere(8)], *kind));
        let placement = |i: u32| {
            let mut instance = Instance::identity(Arc::clone(&object));
            instance.world_from_object[3] = [f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0, 0.25];
            instance
        };
        let scene = scene_of(&(0..9).map(placement).collect::<Vec<_>>());
        let of = |query: &Query| {
            let mut record = Record::default();
            scene.intersect_batch(query, &rays, &mut HitBatch::default(), &mut record);
            record.counters
        };
        // The scalar level sends rays one by one.
        let has_tiles =
            |query: &&Query| query.coherence == Coherence::Coherent && query.level != Level::Scalar;
        let queries = queries();
        let tiled: Vec<&Query> = queries.iter().filter(has_tiles).collect();
        let counted: Vec<Counters> = tiled.iter().map(|query| of(query)).collect();
        assert!(counted.iter().all(|c| c.nodes == counted[0].nodes), "{counted:?} at all levels");
        // Which rays meet the box of an instance is found ray by ray, with multiplications and subtractions that a level
        // without fused ones rounds twice: a ray that just meets the box at one level just misses it at another.
        let narrow = tiled.iter().zip(&counted).filter(|(query, _)| query.level != Level::Avx512);
        let triangles: Vec<u64> = narrow.map(|(_, counted)| counted.triangles).collect();
        let is_near = |&n: &u64| n.abs_diff(triangles[0]) * 50 < triangles[0];
        assert!(triangles.iter().all(is_near), "{counted:?} at all levels but the widest");
        let single: Vec<Counters> = [Coherence::Coherent, Coherence::Incoherent]
            .map(|coherence| of(&Query { level: Level::Scalar, coherence, ..Query::default() }))
            .into();
        assert_eq!(single[0], single[1], "without tiles, coherence does not matter");
    }
}

/// Rays of a batch that is said to be coherent, and is not, do not do each other's work.
#[test]
fn rays_that_part_at_once_do_little_more_together() {
    let object = Arc::new(build(&[Soup::random(2, 1, 1.0)], WATERTIGHT[0]));
    let mut random = Random::new(5);
    let mut placement = |_| {
        let mut instance = Instance::identity(Arc::clone(&object));
        instance.world_from_object = [[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.05], [0.0; 3]];
        instance.world_from_object[3] = random.point().map(|x| f64::from(10.0 * x));
        instance
    };
    let scene = scene_of(&(0..5000).map(&mut placement).collect::<Vec<_>>());
    let mut random = Random::new(6);
    let rays: Vec<_> = (0..2000).map(|_| (random.point().map(|x| 10.0 * x), random.point())).collect();
    let rays = batch(&rays);
    for level in Level::available() {
        let [joint, single] = [Coherence::Coherent, Coherence::Incoherent].map(|coherence| {
            let query = Query { level, coherence, ..Query::default() };
            let (mut closest, mut any) = (Record::default(), Record::default());
            scene.intersect_batch(&query, &rays, &mut HitBatch::default(), &mut closest);
            scene.occluded_batch(&query, &rays, &mut Vec::new(), &mut any);
            [closest.counters, any.counters]
        });
        for (joint, single) in joint.iter().zip(single) {
            assert!(joint.nodes <= 2 * single.nodes, "{level}: {joint:?}, {single:?} one by one");
            assert!(joint.triangles <= 2 * single.triangles, "{level}: {joint:?}, {single:?} one by one");
        }
    }
}

#[test]
fn costs_add_up_and_records_go_on() {
    for kind in WATERTIGHT {
        let rays = some_rays();
        let object = build(&[closed::torus(12)], kind);
        let mut record = Record::with_costs();
        for round in 1..3 {
            object.intersect_batch(&Query::default(), &rays, &mut HitBatch::default(), &mut record);
            let costs: u64 = record.costs.iter().flatten().map(|&cost| u64::from(cost)).sum();
            let Counters { rays: traced, nodes, triangles } = record.counters;
            assert_eq!(traced, round * rays.len() as u64, "sums go on from batch to batch");
            assert_eq!(round * costs, nodes + triangles, "costs are the last batch's");
            assert_eq!(record.costs.as_ref().map(Vec::len), Some(rays.len()), "one for each ray");
        }
    }
}
