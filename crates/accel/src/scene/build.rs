// SPDX-License-Identifier: GPL-3.0-or-later
//! Transforms instances and builds the top tree over them. Source: [WBS03a]. Space: world; where the scene is
//! far away for its size, the top tree is relative to a point near it, so that its boxes stay as precise as
//! near the origin.
//! Invariant: threads do not matter. Tests: `tests/instances.rs`, `tests/nested.rs`, `tests/far_away.rs`, `tests/control.rs`.

use gnurt_accel_bvh::BoxIndex;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::threads::extend;
use gnurt_accel_core::{BuildControl, Quality};

use super::box64::Box64;
use super::error::SceneError;
use super::leaves::Leaves;
use super::types::{DEEPEST_SCENE, Entries, Entry, Instance, PlacedInstance, SceneTree, Slot};
use crate::{Aabb, BuildOptions, INVALID_ID, SharedList, Threads};

impl SceneTree {
    /// Builds over `instances`; their indices in the list are the `inst_id`s of hits. Those that
    /// [`try_build`](Self::try_build) would reject are dropped and counted; an empty list is valid.
    ///
    /// Of the options it is `quality` that counts, for this and for all that is [`updated`](Self::updated) from it.
    ///
    /// # Panics
    /// If there are too many instances for one tree (some 900 million).
    #[must_use]
    pub fn build(instances: &[Instance], options: &BuildOptions, threads: Threads) -> Self {
        let built = build(instances, options.quality, threads, &Watch::new(&()), false);
        built.unwrap_or_else(|error| panic!("{error}"))
    }

    /// Builds over `instances`, all of them, under control: it may be cancelled, reports progress and memory,
    /// and stays within a budget. The memory of the shown objects does not count.
    ///
    /// # Errors
    /// See [`SceneError`]: the first instance that cannot be placed, or a stop by `control`.
    pub fn try_build(
        instances: &[Instance],
        options: &BuildOptions,
        threads: Threads,
        control: &dyn BuildControl,
    ) -> Result<Self, SceneError> {
        let watch = Watch::new(control);
        let scene = build(instances, options.quality, threads, &watch, true)?;
        watch.finish();
        Ok(scene)
    }
}

impl Default for SceneTree {
    /// Of no instances.
    fn default() -> Self {
        Self::build(&[], &BuildOptions::default(), Threads::Single)
    }
}

/// Properties of a placed instance.
#[derive(Clone, Copy)]
pub(super) struct InstanceProperties {
    /// Around it, relative to the origin of boxes; empty where there is nothing to see.
    pub(super) bounds: Aabb,
    /// Number of objects in its shape.
    pub(super) leaves: u32,
    /// Nesting depth of its visible part.
    pub(super) depth: u32,
    /// Whether it moves during an open shutter, or shows something that does.
    pub(super) moves: bool,
    /// See [`PlacedInstance::slack`].
    pub(super) slack: f32,
    /// The reason of its rejection.
    pub(super) error: Option<SceneError>,
}

impl InstanceProperties {
    /// Of an instance that is not there.
    pub(super) const ABSENT: Self =
        Self { bounds: Aabb::EMPTY, leaves: 1, depth: 0, moves: false, slack: 1.0, error: None };
}

/// An instance made ready, its box relative to `origin`.
pub(super) fn place_instance(
    instance: &Instance,
    inst_id: u32,
    origin: [f32; 3],
) -> (Slot, InstanceProperties) {
    let refused =
        |error| (Slot::Refused, InstanceProperties { error: Some(error), ..InstanceProperties::ABSENT });
    if instance.shape.depth() >= DEEPEST_SCENE {
        return refused(SceneError::TooDeep { inst_id });
    }
    match PlacedInstance::new(instance, origin) {
        Some((placed, bounds)) => {
            let (leaves, depth) = (placed.shape.leaves(), placed.shape.scene_depth());
            let (moves, slack) = (placed.moves(), placed.slack());
            let error = None;
            (Slot::PlacedInstance(placed), InstanceProperties { bounds, leaves, depth, moves, slack, error })
        }
        None => refused(SceneError::NoInverse { inst_id }),
    }
}

fn build(
    instances: &[Instance],
    quality: Quality,
    threads: Threads,
    watch: &Watch,
    all: bool,
) -> Result<SceneTree, SceneError> {
    let held = instances.len() * (size_of::<Slot>() + size_of::<Entry>());
    let passing = instances.len() * (size_of::<InstanceProperties>() + size_of::<Aabb>());
    watch.take(held + passing);
    watch.result()?;
    threads.run(|parallel| {
        let (mut slots, mut properties) = SharedList::with(instances.len(), parallel, |i| {
            place_instance(&instances[i], i as u32, [0.0; 3])
        });
        let mut dropped = 0;
        let (mut depths, mut moving) = ([0; DEEPEST_SCENE as usize], 0);
        let mut leaves = 0;
        for (i, properties) in properties.iter_mut().enumerate() {
            let more: u64 = leaves + u64::from(properties.leaves);
            // The greatest number is that of no object.
            if more >= u64::from(INVALID_ID) {
                let inst_id = i as u32;
                *slots.edit(i) = Slot::Refused;
                *properties = InstanceProperties {
                    error: properties.error.or(Some(SceneError::TooManyObjects { inst_id })),
                    leaves: 0,
                    ..InstanceProperties::ABSENT
                };
            }
            leaves += u64::from(properties.leaves);
            depths[properties.depth as usize] += 1;
            moving += u32::from(properties.moves);
            match properties.error {
                Some(error) if all => return Err(error),
                Some(_) => dropped += 1,
                None => {}
            }
        }
        let mut boxes = Vec::new();
        extend(parallel, &mut boxes, properties.len(), |i| properties[i].bounds);
        let origin = origin_for(&around(&boxes));
        if origin != [0.0; 3] {
            boxes.clear();
            extend(parallel, &mut boxes, slots.len(), |i| slots[i].bounds_from(origin));
        }
        let slack = properties.iter().fold(1.0, |most: f32, properties| most.max(properties.slack));
        let leaves = Leaves::new(properties.iter().map(|properties| properties.leaves));
        drop(properties);
        let boxes_at = |place_instance: usize| slots[place_instance].boxes_at(origin);
        let top = BoxIndex::build(&boxes, &boxes_at, origin, quality, threads, watch)?.with_slack(slack);
        watch.give(passing);
        watch.result()?;
        let entries = Entries::new(&top, &slots, parallel);
        Ok(SceneTree { only: top.only(), top, slots, entries, leaves, depths, dropped, moving })
    })
}

fn around(boxes: &[Aabb]) -> Box64 {
    Box64::from(boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(bounds)))
}

/// A scene whose middle is this many times its size away from the origin has a top tree relative to the middle.
const FAR: f64 = 64.0;

/// Whether boxes within `bounds` are precise enough relative to `origin`.
pub(super) fn is_near(bounds: &Box64, origin: [f32; 3]) -> bool {
    let size = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max);
    let far = |k: usize| (0.5 * (bounds.min[k] + bounds.max[k]) - f64::from(origin[k])).abs() > FAR * size;
    bounds.is_empty() || !(0..3).any(far)
}

/// The origin of boxes within `bounds`.
pub(super) fn origin_for(bounds: &Box64) -> [f32; 3] {
    if is_near(bounds, [0.0; 3]) {
        return [0.0; 3];
    }
    [0, 1, 2].map(|k| (0.5 * (bounds.min[k] + bounds.max[k])) as f32)
}
