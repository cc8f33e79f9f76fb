// SPDX-License-Identifier: GPL-3.0-or-later
//! Callbacks that accept or reject hits: the result equals a filtered list of all hits, at every level, in
//! objects and scenes.

use std::sync::Arc;

use crate::common::{WATERTIGHT, batch, build, scene_of};
use gnurt_accel::{Hit, HitBatch, Instance, Level, ObjectTree, Query, Ray, RayBatch, SceneTree};
use gnurt_testkit::{Soup, closed, rays};

fn check(what: &str, rays: &RayBatch, target: &dyn Questions) {
    let accept = |ray: &Ray, hit: &Hit| (hit.prim_id + hit.inst_id) % 3 == 1 && ray.at(hit.t)[0] > -0.5;
    let mut rejected = 0;
    for level in Level::available() {
        let query = Query { level, ..Query::default() };
        let mut hits = Vec::new();
        for i in 0..rays.len() {
            let ray = rays.get(i);
            target.all(&query, &ray, &mut hits);
            let expected = hits.iter().copied().find(|hit| accept(&ray, hit));
            rejected += usize::from(expected != hits.first().copied());
            let found = target.filtered(&query, &ray, &accept);
            assert_eq!(found, (expected, expected.is_some()), "{what}: {ray:?} at {level}");
            let Some(first) = hits.first() else { continue };
            let next = hits.iter().copied().find(|hit| hit.primitive() != first.primitive());
            let found = target.ignoring(&query, &ray, first);
            assert_eq!(found, (next, next.is_some()), "{what}: {ray:?} without {first:?} at {level}");
        }
        let (found, any) = target.batch_filtered(&query, rays, &accept);
        assert_eq!(any.len(), rays.len(), "{what}: one answer for each ray");
        for (i, &any) in any.iter().enumerate() {
            let single = target.filtered(&query, &rays.get(i), &accept);
            assert_eq!((found.get(i), any), single, "{what}: ray {i} of a batch at {level}");
        }
    }
    assert!(rejected > 50, "{what}: only {rejected} closest hits were rejected");
}

/// The queries of both kinds of trees.
trait Questions {
    fn all(&self, query: &Query, ray: &Ray, hits: &mut Vec<Hit>);
    fn filtered(&self, query: &Query, ray: &Ray, accept: Accept) -> (Option<Hit>, bool);
    fn ignoring(&self, query: &Query, ray: &Ray, first: &Hit) -> (Option<Hit>, bool);
    fn batch_filtered(&self, query: &Query, rays: &RayBatch, accept: Accept) -> (HitBatch, Vec<bool>);
}

type Accept<'a> = &'a dyn Fn(&Ray, &Hit) -> bool;

macro_rules! questions {
    ($($tree:ty),*) => {$(
        impl Questions for $tree {
            fn all(&self, query: &Query, ray: &Ray, hits: &mut Vec<Hit>) {
                self.all_hits(query, ray, hits);
            }
            fn filtered(&self, query: &Query, ray: &Ray, accept: Accept) -> (Option<Hit>, bool) {
                (self.intersect_filtered(query, ray, accept), self.occluded_filtered(query, ray, accept))
            }
            fn ignoring(&self, query: &Query, ray: &Ray, first: &Hit) -> (Option<Hit>, bool) {
                let ignored = first.primitive();
                (self.intersect_ignoring(query, ray, ignored), self.occluded_ignoring(query, ray, ignored))
            }
            fn batch_filtered(&self, query: &Query, rays: &RayBatch, accept: Accept) -> (HitBatch, Vec<bool>) {
                let (mut hits, mut any) = (HitBatch::default(), Vec::new());
                let pass = |i: usize, hit: &Hit| accept(&rays.get(i), hit);
                self.intersect_batch_filtered(query, rays, &mut hits, pass);
                self.occluded_batch_filtered(query, rays, &mut any, pass);
                (hits, any)
            }
        }
    )*};
}
questions!(ObjectTree, SceneTree);

#[test]
fn filters_see_every_candidate() {
    let meshes = [closed::sphere(9), Soup::random(1, 200, 0.7)];
    for kind in WATERTIGHT {
        let object = Arc::new(build(&meshes, kind));
        let rays = batch(&rays::random(2, 100));
        check("object", &rays, &*object);
        let placement = |i: u32| {
            let mut instance = Instance::identity(Arc::clone(&object));
            instance.world_from_object[3] = [f64::from(i) * 0.3 - 0.5, 0.1, f64::from(i % 2)];
            instance
        };
        let scene = scene_of(&(0..5).map(placement).collect::<Vec<_>>());
        check("scene", &rays, &scene);
    }
}
