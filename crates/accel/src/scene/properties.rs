// SPDX-License-Identifier: GPL-3.0-or-later
//! Properties of a scene, and the instance of a hit. Source: [WBS03a]. Space: world.
//! Tests: `tests/instances.rs`, `tests/nested.rs`, `tests/far_away.rs`.

use gnurt_accel_core::bits::each;
use gnurt_accel_core::nearest::Nearest;
use gnurt_accel_core::tile::NearestTile;

use super::box64::Box64;
use super::types::{PlacedInstance, SceneTree, Shape, Slot};
use crate::{Aabb, Hit, HitBatch, ObjectTree, TreeStats};

impl SceneTree {
    /// Box around everything, world space; [`Aabb::EMPTY`] without anything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        if self.top.origin() == [0.0; 3] { self.top.bounds() } else { self.bounds64().rounded() }
    }

    /// The same in double precision.
    pub(super) fn bounds64(&self) -> Box64 {
        let Aabb { min, max } = self.top.bounds();
        let from = self.top.origin();
        let index = |x: [f32; 3]| [0, 1, 2].map(|k| f64::from(x[k]) + f64::from(from[k]));
        Box64 { min: index(min), max: index(max) }
    }

    /// Instances that could not be placed: see [`SceneError`](crate::SceneError).
    #[must_use]
    pub fn dropped_instances(&self) -> u64 {
        self.dropped
    }

    /// Levels of scenes on the longest path down, this one included.
    #[must_use]
    pub fn depth(&self) -> u32 {
        1 + self.depths.iter().rposition(|&count| count > 0).unwrap_or(0) as u32
    }

    /// How many objects it shows, those of nested scenes too: numbers below this are [`Hit::leaf_id`]s.
    #[must_use]
    pub fn leaf_count(&self) -> u32 {
        self.leaves.count()
    }

    /// The instances on the path to the object of [`Hit::leaf_id`], outermost first: indices of the lists of
    /// the scenes' builds. `None` where there is no such object.
    #[must_use]
    pub fn instance_path(&self, leaf_id: u32) -> Option<Vec<u32>> {
        let (mut scene, mut leaf, mut path) = (self, leaf_id, Vec::new());
        loop {
            let (index, placed) = scene.located_instance(leaf)?;
            path.push(index as u32);
            match &placed.shape {
                Shape::Object(_) => return Some(path),
                Shape::Scene(inner) => (scene, leaf) = (inner, leaf - scene.leaves.first(index)),
            }
        }
    }

    /// The outermost instance on the path to the object of [`Hit::leaf_id`], and the object's number in the
    /// instance's scene, 0 if it shows an object. `None` where there is no such object.
    #[must_use]
    pub fn instance_at(&self, leaf_id: u32) -> Option<(u32, u32)> {
        if leaf_id >= self.leaves.count() {
            return None;
        }
        let index = self.leaves.index(leaf_id);
        Some((index as u32, leaf_id - self.leaves.first(index)))
    }

    /// The number of the first object of an instance, the inverse of [`instance_at`](Self::instance_at).
    ///
    /// # Panics
    /// If there is no such instance.
    #[must_use]
    pub fn first_leaf(&self, inst_id: u32) -> u32 {
        assert!((inst_id as usize) < self.slots.len(), "instance {inst_id} of {}", self.slots.len());
        self.leaves.first(inst_id as usize)
    }

    /// Whether both number objects alike: hits on one name the same objects in the other, where these are there.
    #[must_use]
    pub fn numbers_alike(&self, other: &Self) -> bool {
        self.leaves.is_like(&other.leaves)
    }

    /// Size and shape of the top tree.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        let primitive_bytes =
            self.slots.memory_bytes() + self.entries.memory_bytes() + self.leaves.memory_bytes();
        TreeStats { primitive_bytes: primitive_bytes as u64, ..self.top.stats() }
    }

    /// An instance that is placed.
    #[inline]
    pub(super) fn placed(&self, index: usize) -> Option<&PlacedInstance> {
        match &self.slots[index] {
            Slot::PlacedInstance(placed) => Some(placed),
            Slot::Absent | Slot::Refused => None,
        }
    }

    /// The instance that holds an object, and its index.
    #[inline]
    pub(super) fn located_instance(&self, leaf: u32) -> Option<(usize, &PlacedInstance)> {
        if leaf >= self.leaves.count() {
            return None;
        }
        let index = self.leaves.index(leaf);
        self.placed(index).map(|placed| (index, placed))
    }

    /// The outermost instance on the path to a hit object, and that object.
    fn object_at(&self, leaf: u32) -> (u32, &ObjectTree) {
        let (mut scene, mut left, mut outermost) = (self, leaf, None);
        loop {
            let (index, placed) = scene.located_instance(left).expect("hits name objects that are there");
            let first = *outermost.get_or_insert(index as u32);
            match &placed.shape {
                Shape::Object(object) => return (first, object),
                Shape::Scene(inner) => (scene, left) = (inner, left - scene.leaves.first(index)),
            }
        }
    }

    /// Ids of a hit.
    #[inline]
    pub(crate) fn resolve(&self, nearest: &Nearest) -> Hit {
        let (inst_id, object) = self.object_at(nearest.slot);
        object.resolve(nearest, inst_id, nearest.slot)
    }

    /// The corners of the triangle that was hit, in its object's space, where that has but one tree, which is of triangles.
    #[inline]
    pub(crate) fn corners_met(&self, nearest: &Nearest) -> Option<[[f32; 3]; 3]> {
        self.object_at(nearest.slot).1.corners_met(nearest)
    }

    /// Writes the hits of those rays of a tile that are in `bits`, the tile's first ray to lane `first`.
    pub(crate) fn write(&self, nearest: &NearestTile, bits: u64, first: usize, hits: &mut HitBatch) {
        // Neighbours often hit the same object.
        let mut last: Option<(u32, (u32, &ObjectTree))> = None;
        each(bits, |i| {
            let nearest = nearest.get(i);
            let (inst_id, object) = match last {
                Some((slot, found)) if slot == nearest.slot => found,
                _ => self.object_at(nearest.slot),
            };
            last = Some((nearest.slot, (inst_id, object)));
            hits.set(first + i, object.resolve(&nearest, inst_id, nearest.slot));
        });
    }

    /// As [`Target::only_object`](crate::target::Target::only_object).
    pub(crate) fn only_object(&self) -> Option<([u32; 2], &ObjectTree)> {
        let index = self.only?;
        match &self.placed(index)?.shape {
            Shape::Object(object) => Some(([index as u32, self.leaves.first(index)], object)),
            Shape::Scene(_) => None,
        }
    }
}
