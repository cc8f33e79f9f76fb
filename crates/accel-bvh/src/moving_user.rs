// SPDX-License-Identifier: GPL-3.0-or-later
//! User geometry that moves while the shutter is open, under a wide BVH whose boxes move with it. As `motion.rs`: the tree
//! is built over the boxes at one key and refitted to each; a ray interpolates boxes between two keys, and the tests of
//! the primitives get its time. Space: object.
//! Invariant: a primitive whose box cannot be used at some key is in no block. Tests: `tests/keyed.rs` of `gnurt-accel`.

use std::sync::Arc;

use gnurt_accel_core::control::Watch;
use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::RegionFilter;
use gnurt_accel_core::threads::extend;
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::{
    Aabb, BadPrimitives, BuildError, INVALID_ID, KeyInterval, Quality, Ray, Threads, TreeStats, UserGeometry,
    UserHit,
};
use gnurt_simd::Simd;

use crate::blocked::{BlockKind, Blocked, Inputs, Shared, lanes};
use crate::blocks::BlockIndex;
use crate::build::try_build;
use crate::interpolated::{InterpolatedNodes, empty_nothing, hide_nothing};
use crate::node::{Child, Node8, WIDTH};
use crate::node_ray::NodeRay;
use crate::tree::Tree;
use crate::user::UserBlock;
use crate::walk::walk;

/// Trees at each key, of the same topology, over the same blocks.
#[derive(Clone, Debug)]
pub struct MovingUserIndex {
    keys: Vec<Tree>,
    blocks: Vec<UserBlock>,
    shared: Shared<UserBlock>,
    /// Around all of them.
    bounds: Aabb,
    greatest: f32,
    stats: TreeStats,
}

/// Boxes of the usable primitives, key by key for each, and their numbers.
fn screen(inputs: &Inputs, keys: u32, bad: &mut BadPrimitives) -> (Vec<u32>, Vec<Aabb>) {
    let (mut numbers, mut boxes) = (Vec::new(), Vec::new());
    for (i, geometry) in inputs.own() {
        let GeometryKind::User(user) = &geometry.kind else { continue };
        for (prim_id, number) in (0..).zip(inputs.numbering.range(i)) {
            let before = boxes.len();
            boxes.extend((0..keys).map(|key| user.bounds_at(prim_id, key)));
            let own = &boxes[before..];
            let is_empty = own.iter().any(Aabb::is_empty);
            let planes = own.iter().flat_map(|one| one.min.into_iter().chain(one.max));
            if is_empty {
                bad.zero_area += 1;
            } else if let Some(fault) = bad.fault(planes) {
                *fault += 1;
            } else {
                numbers.push(number);
                continue;
            }
            boxes.truncate(before);
        }
    }
    (numbers, boxes)
}

impl MovingUserIndex {
    /// Over user geometry of this many keys; primitives without usable boxes are counted. `None` where there is nothing.
    ///
    /// # Errors
    /// That `watch` stopped it, or that there are too many.
    pub fn build(
        inputs: &Inputs,
        keys: u32,
        bad: &mut BadPrimitives,
        quality: Quality,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Option<Self>, BuildError> {
        let (numbers, boxes) = screen(inputs, keys, bad);
        if numbers.is_empty() {
            return Ok(None);
        }
        let at = |i: usize, key: usize| boxes[i * keys as usize + key];
        let middle = KeyInterval::of(0.5, keys as usize);
        let mix = |from: Aabb, to: Aabb| Aabb {
            min: middle.mix3(from.min, to.min),
            max: middle.mix3(from.max, to.max),
        };
        let middles: Vec<Aabb> =
            (0..numbers.len()).map(|i| mix(at(i, middle.key), at(i, middle.next))).collect();
        let mut tree = try_build(&&middles[..], Vec::new(), quality, threads, watch)?;
        let in_blocks = std::mem::take(&mut tree.blocks);
        let own =
            |block: &[u32; WIDTH]| block.map(|i| numbers.get(i as usize).copied().unwrap_or(INVALID_ID));
        let blocks: Vec<UserBlock> = in_blocks.iter().map(|block| UserBlock(own(block))).collect();
        let mut trees = Vec::with_capacity(keys as usize);
        for key in 0..keys as usize {
            watch.take(tree.node_bytes());
            watch.result()?;
            trees.push(threads.run(|parallel| {
                let mut around = Vec::new();
                extend(parallel, &mut around, in_blocks.len(), |block| {
                    let own = in_blocks[block].iter().filter(|&&i| i != INVALID_ID);
                    own.fold(Aabb::EMPTY, |all, &i| all.union(&at(i as usize, key)))
                });
                let mut tree = tree.clone();
                tree.refit(&around, parallel, &mut Vec::new());
                hide_nothing(&mut tree.nodes);
                tree
            }));
        }
        let bounds = trees.iter().fold(Aabb::EMPTY, |all, tree: &Tree| all.union(&tree.bounds));
        let stats = TreeStats { primitives: numbers.len() as u64, ..tree.measure() };
        let (shared, greatest) = (inputs.shared(), bounds.greatest());
        Ok(Some(Self { keys: trees, blocks, shared, bounds, greatest, stats }))
    }

    /// Box around everything at all times.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        let tree_bytes = self.keys.iter().map(Tree::node_bytes).sum::<usize>() as u64;
        TreeStats { tree_bytes, primitive_bytes: size_of_val(&self.blocks[..]) as u64, ..self.stats }
    }

    /// How many keys there are.
    #[must_use]
    pub fn keys(&self) -> u32 {
        self.keys.len() as u32
    }

    /// Whether both have the same nodes and blocks.
    #[must_use]
    pub fn same_tree(&self, other: &Self) -> bool {
        let numbers =
            |index: &Self| -> Vec<[u32; WIDTH]> { index.blocks.iter().map(|block| block.0).collect() };
        self.keys == other.keys && numbers(self) == numbers(other)
    }

    /// Numbers of all leaf blocks, and how many there are.
    pub fn numbers(&self, visit: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
        self.blocks.iter().enumerate().for_each(|(i, block)| visit(i, &block.0));
        self.blocks.len()
    }

    /// The primitive in a lane.
    #[must_use]
    pub fn primitive(&self, block: usize, lane: usize) -> Primitive<'_> {
        self.blocks[block].primitive(lane, 0, &self.shared)
    }

    /// Shows the primitives that may meet a region at time 0.
    pub fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(u32, Primitive)) {
        self.keys[0].filter_region(region_filter, &mut |range| {
            for block in &self.blocks[range] {
                lanes(block).for_each(|(lane, number)| visit(number, block.primitive(lane, 0, &self.shared)));
            }
        });
    }

    /// Offers the hits of a ray at its time; it is valid and regular.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        let interval = KeyInterval::of(traversal.ray.time, self.keys.len());
        let [from, to] = [interval.key, interval.next].map(|key| &self.keys[key].nodes[..]);
        let nodes = InterpolatedNodes { from, to, weights: interval.weights };
        let for_nodes = NodeRay::new(simd, traversal.ray, self.greatest);
        let (mut tested, reach) = (0, traversal.reach());
        let visited = walk(
            &nodes,
            simd,
            Child::node(0),
            &for_nodes,
            reach,
            #[inline(always)]
            |range| {
                for block in &self.blocks[range] {
                    tested += block.test(&self.shared, traversal);
                }
                traversal.reach()
            },
        );
        traversal.counters.nodes += u64::from(visited);
        traversal.counters.triangles += tested;
    }

    /// Improves `nearest` by the primitives at time 0.
    #[inline(always)]
    pub(crate) fn nearest<S: Simd>(&self, simd: S, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        self.keys[0].near(simd, &probe.point, probe.radius_for(nearest.distance()), |range| {
            for block in &self.blocks[range] {
                lanes(block).for_each(|(lane, _)| block.near(lane, &self.shared, probe, slot, nearest));
            }
            probe.radius_for(nearest.distance())
        });
    }

    /// The primitives at one time.
    #[must_use]
    pub fn at(&self, time: f32) -> BlockIndex {
        let interval = KeyInterval::of(time, self.keys.len());
        let (mut mixed, to) = (self.keys[interval.key].clone(), &self.keys[interval.next]);
        for (node, to) in mixed.nodes.iter_mut().zip(&to.nodes) {
            let rows = node.rows[..6].as_flattened_mut().iter_mut().zip(to.rows[..6].as_flattened());
            rows.for_each(|(from, &to)| *from = interval.mix(*from, to));
        }
        empty_nothing(&mut mixed.nodes);
        mixed.bounds = mixed.nodes.first().map_or(Aabb::EMPTY, Node8::whole);
        let shared = self
            .shared
            .map(|user| Arc::new(Stopped { user: Arc::clone(user), time }) as Arc<dyn UserGeometry>);
        BlockIndex::User(Blocked::of(mixed, self.blocks.clone(), shared, self.stats))
    }
}

/// User geometry at one time.
#[derive(Debug)]
struct Stopped {
    user: Arc<dyn UserGeometry>,
    time: f32,
}

impl UserGeometry for Stopped {
    fn count(&self) -> u32 {
        self.user.count()
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        let interval = KeyInterval::of(self.time, self.user.keys() as usize);
        let [from, to] = [interval.key, interval.next].map(|key| self.user.bounds_at(prim_id, key as u32));
        Aabb { min: interval.mix3(from.min, to.min), max: interval.mix3(from.max, to.max) }
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        self.user.intersect(prim_id, &Ray { time: self.time, ..*ray }, hit);
    }

    fn closest_point(&self, prim_id: u32, point: [f32; 3]) -> Option<[f32; 3]> {
        self.user.closest_point_at(prim_id, point, self.time)
    }

    fn normal(&self, prim_id: u32, uv: [f32; 2], point: Option<[f64; 3]>, _: f32) -> Option<[f64; 3]> {
        self.user.normal(prim_id, uv, point, self.time)
    }
}
