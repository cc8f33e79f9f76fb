// SPDX-License-Identifier: GPL-3.0-or-later
//! Common parts of this crate's tests: soups as objects, all kinds of queries, comparison with the oracle.
#![allow(dead_code, reason = "each test file uses a part of it")]

use gnurt_accel::{
    BuildOptions, Coherence, Hit, HitBatch, Instance, Level, Memory, ObjectTree, Quality, Query, Ray,
    RayBatch, Record, SceneError, SceneTree, Structure, Threads, TriangleTest, Triangles,
};
use gnurt_testkit::{OracleInstance, Soup, oracle, rays::PlainRay};

/// A structure with a triangle test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind(pub(crate) Structure, pub(crate) Quality, pub(crate) TriangleTest, pub(crate) Memory);

/// All that never leak.
pub(crate) const WATERTIGHT: [Kind; 7] = [
    Kind(Structure::Bvh, Quality::Medium, TriangleTest::Watertight, Memory::Fast),
    Kind(Structure::Bvh, Quality::High, TriangleTest::Watertight, Memory::Fast),
    Kind(Structure::Bvh, Quality::Fast, TriangleTest::Watertight, Memory::Fast),
    Kind(Structure::Kd, Quality::Medium, TriangleTest::Watertight, Memory::Fast),
    Kind(Structure::Kd, Quality::Fast, TriangleTest::Watertight, Memory::Fast),
    Kind(Structure::Bvh, Quality::Medium, TriangleTest::Watertight, Memory::Compact),
    Kind(Structure::Bvh, Quality::High, TriangleTest::Watertight, Memory::Compact),
];

/// A grid. Not among all that never leak, since it has no nodes and cannot be saved.
pub(crate) const GRID: Kind = Kind(Structure::Grid, Quality::Medium, TriangleTest::Watertight, Memory::Fast);

/// All kinds, and how far their hits may be from the truth in barycentric weights.
pub(crate) const TESTS: [(Kind, f64); 8] = [
    (WATERTIGHT[0], 2e-5),
    (Kind(Structure::Kd, Quality::Medium, TriangleTest::Projected, Memory::Fast), 1e-3),
    (WATERTIGHT[1], 2e-5),
    (WATERTIGHT[2], 2e-5),
    (WATERTIGHT[3], 2e-5),
    (WATERTIGHT[4], 2e-5),
    (WATERTIGHT[5], 2e-5),
    (WATERTIGHT[6], 2e-5),
];

/// A tree over meshes.
pub(crate) fn build(meshes: &[Soup], kind: Kind) -> ObjectTree {
    build_with(meshes, &options(kind), Threads::Single)
}

/// The options that stand for a kind.
pub(crate) fn options(Kind(structure, quality, triangle_test, memory): Kind) -> BuildOptions {
    BuildOptions { structure, quality, triangle_test, memory, ..BuildOptions::default() }
}

/// A tree over meshes with given options.
pub(crate) fn build_with(meshes: &[Soup], options: &BuildOptions, threads: Threads) -> ObjectTree {
    let meshes: Vec<Triangles> =
        meshes.iter().map(|m| Triangles { positions: &m.positions, indices: &m.indices }).collect();
    ObjectTree::build(&meshes, options, threads)
}

/// A scene by default options; instances that cannot be placed are dropped.
pub(crate) fn scene_of(instances: &[Instance]) -> SceneTree {
    SceneTree::build(instances, &BuildOptions::default(), Threads::Single)
}

/// A scene of all instances by default options.
pub(crate) fn try_scene_of(instances: &[Instance]) -> Result<SceneTree, SceneError> {
    SceneTree::try_build(instances, &BuildOptions::default(), Threads::Single, &())
}

/// Plain rays over `[0, inf]`.
pub(crate) fn batch(rays: &[PlainRay]) -> RayBatch {
    rays.iter().map(|&(org, dir)| Ray::new(org, dir)).collect()
}

/// Every way to ask, at each level of this CPU: first all single rays, then tiles, then sorted ones.
pub(crate) fn queries() -> Vec<Query> {
    let all = |coherence| {
        Level::available().into_iter().map(move |level| Query { level, coherence, ..Query::default() })
    };
    all(Coherence::Incoherent).chain(all(Coherence::Coherent)).chain(all(Coherence::Fanned)).collect()
}

/// Asks an object or a scene in every way and insists on one answer, bit for bit.
pub(crate) fn run_queries<T: QueryTarget>(target: &T, rays: &RayBatch) -> Vec<Option<Hit>> {
    let mut first: Option<Vec<Option<Hit>>> = None;
    for query in queries() {
        let (hits, occluded) = target.run_queries(&query, rays);
        let hits: Vec<Option<Hit>> = (0..hits.len()).map(|i| hits.get(i)).collect();
        for (i, hit) in hits.iter().enumerate() {
            assert_eq!(hit.is_some(), occluded[i], "{query:?}: closest and any hit of {:?}", rays.get(i));
        }
        match &first {
            None => first = Some(hits),
            Some(first) => {
                for (i, (a, b)) in first.iter().zip(&hits).enumerate() {
                    let bits = |hit: &Option<Hit>| hit.map(|h| [h.t, h.u, h.v].map(f32::to_bits));
                    let same = a == b && bits(a) == bits(b);
                    assert!(same, "{query:?} finds {b:?}, a single ray {a:?}, ray {i}: {:?}", rays.get(i));
                }
            }
        }
    }
    first.unwrap_or_default()
}

/// Objects and scenes.
pub(crate) trait QueryTarget {
    /// Closest and any hits of a batch.
    fn run_queries(&self, query: &Query, rays: &RayBatch) -> (HitBatch, Vec<bool>);
    /// The closest hit of one ray.
    fn one(&self, query: &Query, ray: &Ray) -> Option<Hit>;
    /// All hits of one ray.
    fn all(&self, ray: &Ray) -> Vec<Hit>;
}

macro_rules! may_query {
    ($($tree:ty),*) => {$(
        impl QueryTarget for $tree {
            fn run_queries(&self, query: &Query, rays: &RayBatch) -> (HitBatch, Vec<bool>) {
                let (mut hits, mut occluded, mut record) = (HitBatch::default(), Vec::new(), Record::default());
                self.intersect_batch(query, rays, &mut hits, &mut record);
                self.occluded_batch(query, rays, &mut occluded, &mut record);
                (hits, occluded)
            }

            fn one(&self, query: &Query, ray: &Ray) -> Option<Hit> {
                self.intersect_with(query, ray)
            }

            fn all(&self, ray: &Ray) -> Vec<Hit> {
                let mut hits = Vec::new();
                self.all_hits(&Query::default(), ray, &mut hits);
                hits
            }
        }
    )*};
}
may_query!(ObjectTree, SceneTree);

/// Compares answers with the oracle. A hit must be one of the triangle that it names, up to `margin`; it must not lie
/// behind anything that is surely hit; and a miss must not pass through anything that is surely hit. Where rays graze
/// an edge within the margin, either answer is right.
pub(crate) fn assert_hits(instances: &[OracleInstance], rays: &RayBatch, hits: &[Option<Hit>], margin: f64) {
    for (i, hit) in hits.iter().enumerate() {
        let ray = rays.get(i);
        let plain = (ray.org, ray.dir);
        let whole = [f64::NEG_INFINITY, f64::INFINITY];
        let scale = f64::from(ray.dir.iter().fold(0.0f32, |m, x| m.max(x.abs())));
        let slack = 100.0 * margin / scale;
        let surely = oracle::all_hits(instances, plain, [slack, f64::INFINITY], -margin).into_iter().next();
        match hit {
            None => assert!(surely.is_none(), "{ray:?} misses {surely:?}"),
            Some(hit) => {
                let near = |t: f64| (t - f64::from(hit.t)).abs() <= slack + margin * t.abs();
                let possible = oracle::all_hits(instances, plain, whole, margin.sqrt());
                let meant = possible
                    .iter()
                    .find(|o| (o.prim_id, o.geom_id, o.inst_id) == (hit.prim_id, hit.geom_id, hit.inst_id));
                assert!(meant.is_some_and(|o| near(o.t)), "{ray:?} hits {hit:?}, the oracle says {meant:?}");
                if let Some(surely) = surely {
                    let behind = f64::from(hit.t) > surely.t && !near(surely.t);
                    assert!(!behind, "{ray:?} hits {hit:?} behind {surely:?}");
                }
            }
        }
    }
}
