// SPDX-License-Identifier: GPL-3.0-or-later
//! Places instances and builds the top tree over them; what there is to know of a scene, and which instance was hit.
//! Source: [WBS03a]. Space: world; where the scene is far away for its size, the top tree is relative to a point near it,
//! so that its boxes stay as precise as near the origin.
//! Proof: `tests/instances.rs`, `tests/nested.rs`, `tests/far_away.rs`.

use gnurt_accel_bvh::BoxIndex;
use gnurt_accel_core::bits::each;
use gnurt_accel_core::nearest::Nearest;
use gnurt_accel_core::tile::NearestTile;

use super::box64::Box64;
use super::error::SceneError;
use super::types::{DEEPEST_SCENE, Instance, Placed, SceneTree, Shape};
use crate::{Aabb, Hit, HitBatch, INVALID_ID, TreeStats};

impl SceneTree {
    /// Builds over `instances`; their places in the list are the `inst_id`s of hits. Those that
    /// [`try_build`](Self::try_build) would refuse are left out and counted; no instance at all is fine.
    #[must_use]
    pub fn build(instances: &[Instance]) -> Self {
        let mut scene = Self::default();
        for (id, instance) in instances.iter().enumerate() {
            scene.dropped += u64::from(scene.place(instance, id as u32).is_err());
        }
        scene.finish();
        scene
    }

    /// Builds over `instances`, all of them.
    ///
    /// # Errors
    /// See [`SceneError`]: the first instance that cannot be placed.
    pub fn try_build(instances: &[Instance]) -> Result<Self, SceneError> {
        let mut scene = Self::default();
        for (id, instance) in instances.iter().enumerate() {
            scene.place(instance, id as u32)?;
        }
        scene.finish();
        Ok(scene)
    }

    fn place(&mut self, instance: &Instance, inst_id: u32) -> Result<(), SceneError> {
        let depth = instance.shape.depth() + 1;
        if depth > DEEPEST_SCENE {
            return Err(SceneError::TooDeep { inst_id });
        }
        let (placed, exact, bounds) =
            Placed::new(instance, inst_id).ok_or(SceneError::NoInverse { inst_id })?;
        if bounds.is_empty() {
            return Ok(());
        }
        // The greatest number is that of no object.
        let leaves = self.leaves.checked_add(placed.shape.leaves()).filter(|&n| n < INVALID_ID);
        let first_leaf = self.leaves;
        self.leaves = leaves.ok_or(SceneError::TooManyObjects { inst_id })?;
        self.flat &= matches!(placed.shape, Shape::Object(_));
        self.depth = self.depth.max(depth);
        self.bounds64 = self.bounds64.union(&bounds);
        self.placed.push(Placed { first_leaf, ..placed });
        self.exact.push(exact);
        Ok(())
    }

    /// Builds the top tree.
    fn finish(&mut self) {
        let Box64 { min, max } = self.bounds64;
        let size = (0..3).map(|k| max[k] - min[k]).fold(0.0, f64::max);
        let middle = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]));
        let far = middle.iter().any(|x| x.abs() > FAR * size);
        let origin = if far { middle.map(|x| x as f32) } else { [0.0; 3] };
        let boxes = self.placed.iter().zip(&self.exact);
        let boxes: Vec<Aabb> = boxes.map(|(placed, exact)| placed.bounds_from(exact, origin)).collect();
        self.top = BoxIndex::build(&boxes, origin);
    }

    /// Box around everything, world space; [`Aabb::EMPTY`] without anything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        if self.top.origin() == [0.0; 3] { self.top.bounds() } else { self.bounds64.rounded() }
    }

    /// Instances that could not be placed: see [`SceneError`].
    #[must_use]
    pub fn dropped_instances(&self) -> u64 {
        self.dropped
    }

    /// Scenes on the longest way down, this one included.
    #[must_use]
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// The instances on the way to the object that [`Hit::leaf_id`] stands for, outermost first: places in the lists
    /// that the scenes were built from. `None` where there is no such object.
    #[must_use]
    pub fn instance_path(&self, leaf_id: u32) -> Option<Vec<u32>> {
        let (mut scene, mut leaf, mut path) = (self, leaf_id, Vec::new());
        if leaf >= scene.leaves {
            return None;
        }
        loop {
            let placed = scene.placed_at(leaf);
            path.push(placed.inst_id);
            match &placed.shape {
                Shape::Object(_) => return Some(path),
                Shape::Scene(inner) => (scene, leaf) = (inner, leaf - placed.first_leaf),
            }
        }
    }

    /// Size and shape of the top tree.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        let primitive_bytes = (size_of_val(&self.placed[..]) + size_of_val(&self.exact[..])) as u64;
        TreeStats { primitive_bytes, ..self.top.stats() }
    }

    /// The instance that holds an object.
    #[inline]
    fn placed_at(&self, leaf: u32) -> &Placed {
        if self.flat {
            return &self.placed[leaf as usize];
        }
        let after = self.placed.partition_point(|placed| placed.first_leaf <= leaf);
        &self.placed[after - 1]
    }
}

impl Placed {
    /// Ids of a hit on object `leaf` of the scene that this is in.
    fn resolve(&self, nearest: &Nearest, leaf: u32) -> Hit {
        match &self.shape {
            Shape::Object(object) => object.resolve(nearest, self.inst_id, nearest.slot),
            Shape::Scene(scene) => {
                let leaf = leaf - self.first_leaf;
                Hit { inst_id: self.inst_id, ..scene.placed_at(leaf).resolve(nearest, leaf) }
            }
        }
    }
}

/// A scene whose middle is this many times its size away from the origin has a top tree relative to the middle.
const FAR: f64 = 64.0;

impl SceneTree {
    /// Ids of what was hit.
    #[inline]
    pub(crate) fn resolve(&self, nearest: &Nearest) -> Hit {
        self.placed_at(nearest.slot).resolve(nearest, nearest.slot)
    }

    /// Writes what those rays of a tile that are in `bits` have hit, the tile's first ray to lane `first`.
    pub(crate) fn write(&self, nearest: &NearestTile, bits: u64, first: usize, hits: &mut HitBatch) {
        // Neighbours often hit the same object.
        let mut last: Option<(u32, &Placed)> = None;
        each(bits, |i| {
            let nearest = nearest.get(i);
            let placed = match last {
                Some((slot, placed)) if slot == nearest.slot => placed,
                _ => self.placed_at(nearest.slot),
            };
            last = Some((nearest.slot, placed));
            hits.set(first + i, placed.resolve(&nearest, nearest.slot));
        });
    }

    /// The instance, where all hits have the same one and their numbers are `prim_id`s of its only mesh.
    pub(crate) fn only_mesh(&self) -> Option<u32> {
        let [Placed { shape: Shape::Object(object), inst_id, .. }] = &self.placed[..] else { return None };
        object.has_one_mesh().then_some(*inst_id)
    }
}

impl Default for SceneTree {
    /// Of no instances.
    fn default() -> Self {
        Self {
            top: BoxIndex::build(&[], [0.0; 3]),
            placed: Vec::new(),
            exact: Vec::new(),
            bounds64: Box64::EMPTY,
            dropped: 0,
            depth: 1,
            leaves: 0,
            flat: true,
        }
    }
}
