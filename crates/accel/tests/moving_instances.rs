// SPDX-License-Identifier: GPL-3.0-or-later
//! Updated scenes equal scenes built from the current list: the same hits, bit for bit, in every kind of
//! query and at every level, after any sequence of edits; earlier scenes stay unchanged.

use std::sync::Arc;

use crate::common::{WATERTIGHT, batch, build, run_queries, scene_of};
use gnurt_accel::{
    BuildOptions, DEEPEST_SCENE, Hit, Instance, ObjectTree, Quality, RayBatch, SceneTree, Shape, Threads,
};
use gnurt_testkit::{Random, Soup, closed, rays};

/// A list of instances, and the scene that follows it.
struct Following {
    list: Vec<Option<Instance>>,
    scene: SceneTree,
    shapes: Vec<Shape>,
    nothing: Arc<ObjectTree>,
    random: Random,
    /// Instances are this large.
    size: f32,
}

impl Following {
    fn new(count: usize, size: f32, quality: Quality, seed: u64) -> Self {
        let object = |soup: Soup| Arc::new(build(&[soup], WATERTIGHT[0]));
        let (cube, soup) = (object(closed::cube(1)), object(Soup::random(1, 10, 0.5)));
        let nothing = object(Soup::default());
        let row = |n: usize| -> Vec<Instance> {
            (0..n).map(|i| Instance::new(cube.clone(), placement([i as f64 - 1.0, 0.0, 0.5], 0.3))).collect()
        };
        let shapes = vec![
            Shape::from(cube.clone()),
            soup.into(),
            nothing.clone().into(),
            Arc::new(scene_of(&row(2))).into(),
            Arc::new(scene_of(&row(3))).into(),
            Arc::new(SceneTree::default()).into(),
        ];
        let options = BuildOptions { quality, ..BuildOptions::default() };
        let scene = SceneTree::build(&[], &options, Threads::Single);
        let mut following =
            Self { list: Vec::new(), scene, shapes, nothing, random: Random::new(seed), size };
        let all: Vec<(u32, Option<Instance>)> =
            (0..count as u32).map(|i| (i, Some(following.any(false)))).collect();
        following.edit(count, &all, Threads::Single);
        following
    }

    /// An instance of some shape, mostly a sound one.
    fn any(&mut self, nested: bool) -> Instance {
        let random = &mut self.random;
        let plain = [0, 0, 0, 1, 1, 2];
        let shape = if nested { random.pick(&[0, 1, 2, 3, 4, 5]) } else { random.pick(&plain) };
        let at = random.point().map(|x| f64::from(2.0 * x - 1.0));
        let mut instance = Instance::new(self.shapes[shape].clone(), placement(at, f64::from(self.size)));
        instance.mask = random.pick(&[1, 2, u32::MAX]);
        match (random.unit() * 23.0) as u32 {
            1 => instance.world_from_object[1] = [0.0; 3],
            2 => instance.world_from_object[3][0] = f64::NAN,
            3 => instance.world_from_object[2][2] = f64::INFINITY,
            _ => {}
        }
        instance
    }

    fn edit(&mut self, len: usize, edits: &[(u32, Option<Instance>)], threads: Threads) {
        self.list.resize(len, None);
        for (placement, instance) in edits {
            self.list[*placement as usize].clone_from(instance);
        }
        self.scene = self.scene.updated(len, edits, threads);
    }

    /// A few edits of all kinds.
    fn some_edits(&mut self, nested: bool) -> (usize, Vec<(u32, Option<Instance>)>) {
        let before = self.list.len();
        let len = match (self.random.unit() * 10.0) as u32 {
            1 => before + 1 + before / 50,
            2 => (before - before / 40).max(1),
            _ => before,
        };
        let many = self.random.pick(&[1, 1, 2, 3, 10, before / 30 + 1, before / 3 + 1]);
        let edits = (0..many).map(|_| {
            let placement = (self.random.unit() * len as f32) as usize % len;
            let kind = self.random.pick(&[0, 0, 0, 1, 1, 2]);
            let old = self.list.get(placement).cloned().flatten();
            let instance = match (kind, old) {
                (0, Some(mut old)) => {
                    let step = self.random.point().map(|x| f64::from(0.1 * (x - 0.5)));
                    (0..3).for_each(|k| old.world_from_object[3][k] += step[k]);
                    Some(old)
                }
                (2, _) => None,
                _ => Some(self.any(nested)),
            };
            (placement as u32, instance)
        });
        let edits = edits.collect();
        (len, edits)
    }

    fn check(&self, rays: &RayBatch, step: usize) -> Vec<Option<Hit>> {
        let hidden = || Instance::identity(self.nothing.clone());
        let list: Vec<Instance> = self.list.iter().map(|i| i.clone().unwrap_or_else(hidden)).collect();
        let fresh = scene_of(&list);
        let (hits, reference) = (run_queries(&self.scene, rays), run_queries(&fresh, rays));
        for (i, (hit, reference)) in hits.iter().zip(&reference).enumerate() {
            assert_eq!(hit, reference, "step {step}: {:?}", rays.get(i));
            let path = |scene: &SceneTree| hit.and_then(|hit| scene.instance_path(hit.leaf_id));
            assert_eq!(path(&self.scene), path(&fresh), "step {step}: the way to {hit:?}");
        }
        assert_eq!(self.scene.dropped_instances(), fresh.dropped_instances(), "step {step}: what is dropped");
        assert_eq!(self.scene.depth(), fresh.depth(), "step {step}: the depth");
        let shown = |scene: &SceneTree| scene.stats().primitives;
        assert_eq!(shown(&self.scene), shown(&fresh), "step {step}: instances in the tree");
        // Relative to another point it may be rounded differently.
        let (bounds, reference) = (self.scene.bounds(), fresh.bounds());
        let same =
            |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() <= 1e-6 * b[k].abs().max(1.0));
        let same = bounds == reference || same(bounds.min, reference.min) && same(bounds.max, reference.max);
        assert!(same, "step {step}: the box around all is {bounds:?}, not {reference:?}");
        hits
    }
}

fn placement(at: [f64; 3], size: f64) -> [[f64; 3]; 4] {
    [[size, 0.0, 0.0], [0.0, 0.0, size], [0.0, -size, 0.0], at]
}

fn some_rays(seed: u64, count: usize) -> RayBatch {
    let mut plain = rays::random(seed, count);
    plain.extend(rays::aimed(&closed::sphere(4), [0.2, -0.1, 3.0], 1));
    batch(&plain)
}

#[test]
fn a_few_instances_follow_their_list() {
    for (seed, nested) in [(1, false), (2, true)] {
        let mut following = Following::new(20, 0.4, Quality::Medium, seed);
        let mut before: Option<(SceneTree, Vec<Option<Hit>>)> = None;
        let mut found = 0;
        for step in 0..16 {
            let (len, edits) = following.some_edits(nested);
            following.edit(len, &edits, Threads::Single);
            let rays = some_rays(seed, 30);
            let hits = following.check(&rays, step);
            found += hits.iter().flatten().count();
            if let Some((scene, hits)) = &before {
                assert_eq!(&run_queries(scene, &rays), hits, "step {step}: the scene before stays as it was");
            }
            before = Some((following.scene.clone(), hits));
        }
        assert!(found > 200, "{found} hits");
    }
}

#[test]
fn many_instances_follow_their_list() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads start");
    for (seed, quality) in [(3, Quality::Medium), (4, Quality::Fast), (5, Quality::High)] {
        let mut following = Following::new(1400, 0.08, quality, seed);
        let mut found = 0;
        for step in 0..6 {
            let (len, edits) = following.some_edits(step > 2);
            let threads = if step % 2 == 0 { Threads::Pool(&pool) } else { Threads::Single };
            following.edit(len, &edits, threads);
            let hits = following.check(&some_rays(seed + step as u64, 30), step);
            found += hits.iter().flatten().count();
        }
        assert!(found > 40, "{found} hits");
    }
}

#[test]
fn far_away_and_back() {
    let mut following = Following::new(10, 0.4, Quality::Medium, 6);
    let rays = some_rays(1, 30);
    // All of it moves far away, where boxes are relative to another point, then comes back.
    for (step, distance) in [3e6, 1e7, 0.0].into_iter().enumerate() {
        let list = following.list.clone();
        let moved = |(i, instance): (usize, Option<Instance>)| {
            let mut instance = instance?;
            instance.world_from_object[3][0] = distance + 0.1 * i as f64;
            Some(instance)
        };
        let edits: Vec<(u32, Option<Instance>)> =
            list.into_iter().enumerate().map(|pair| (pair.0 as u32, moved(pair))).collect();
        following.edit(10, &edits, Threads::Single);
        let there: RayBatch = (0..rays.len())
            .map(|i| {
                let mut ray = rays.get(i);
                ray.org[0] += distance as f32;
                ray
            })
            .collect();
        let hits = following.check(&there, step);
        assert!(hits.iter().flatten().count() > 2, "something is hit at {distance}");
    }
}

#[test]
fn what_cannot_be_placed_is_counted_once() {
    let cube = Arc::new(build(&[closed::cube(1)], WATERTIGHT[0]));
    let fine = Instance::identity(cube);
    let mut flat = fine.clone();
    flat.world_from_object[0] = [0.0; 3];
    let scene = scene_of(&[fine.clone(), flat.clone()]);
    assert_eq!(scene.dropped_instances(), 1, "one is flat");
    let both = scene.updated(2, &[(0, Some(flat.clone())), (1, Some(flat.clone()))], Threads::Single);
    assert_eq!((both.dropped_instances(), both.bounds().is_empty()), (2, true), "both are");
    let last = both.updated(2, &[(1, Some(flat)), (1, Some(fine.clone()))], Threads::Single);
    assert_eq!((last.dropped_instances(), last.stats().primitives), (1, 1), "the last change counts");
    assert_eq!(last.updated(1, &[], Threads::Single).dropped_instances(), 1, "the second one is gone");
    assert_eq!(last.updated(0, &[], Threads::Single).dropped_instances(), 0, "both are gone");
    let mut deep = Arc::new(scene_of(std::slice::from_ref(&fine)));
    for _ in 1..DEEPEST_SCENE {
        deep = Arc::new(scene_of(&[Instance::identity(deep)]));
    }
    assert_eq!(deep.depth(), DEEPEST_SCENE, "as deep as may be");
    let refused = scene.updated(3, &[(2, Some(Instance::identity(deep)))], Threads::Single);
    assert_eq!((refused.dropped_instances(), refused.depth()), (2, 1), "too deep");

    let many = Arc::new(scene_of(&vec![fine.clone(); 70_000]));
    let many = Instance::identity(Arc::new(scene_of(&vec![Instance::identity(many); 60_000])));
    let full = scene_of(&[many.clone(), fine.clone()]);
    assert_eq!(full.dropped_instances(), 0, "4.2 * 10^9 objects are not too many");
    let fuller = full.updated(3, &[(2, Some(many.clone()))], Threads::Single);
    assert_eq!(fuller.dropped_instances(), 1, "8.4 * 10^9 are");
    let other = fuller.updated(3, &[(0, None), (2, Some(many))], Threads::Single);
    assert_eq!(other.dropped_instances(), 0, "unless others go");
}

#[test]
#[should_panic(expected = "instance 3 of 3")]
fn places_beyond_the_end_are_a_mistake() {
    let _ = SceneTree::default().updated(3, &[(3, None)], Threads::Single);
}
