// SPDX-License-Identifier: GPL-3.0-or-later
//! A scene after some of its instances moved, came or went. Source: [WBS06] for refits, [WBS03a] for the two levels.
//! Space: world. Invariant: rays hit the same as in a scene built from the current list.
//! Tests: `tests/moving_instances.rs`.

use gnurt_accel_bvh::{BoxEdit, BoxIndex};
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::threads::extend;

use super::build::{InstanceProperties, is_near, origin_for, place_instance};
use super::types::{Entries, Instance, SceneTree, Slot};
use crate::{INVALID_ID, SceneError, Threads};

/// A change of a slot: its new contents, and their properties.
type Change = (u32, Slot, InstanceProperties);

impl SceneTree {
    /// The scene of `len` instances that differs from this one in those that are `changed`: indices, and new
    /// contents; `None` removes an instance. Of several changes of one index the last one counts. New indices
    /// without a change show nothing; indices from `len` on are removed. Instances that cannot be placed are
    /// dropped and counted, as by [`build`](Self::build).
    ///
    /// It shares unchanged parts with this one, so it costs about the number of changes, and this one stays
    /// valid for frames in flight. Boxes of the top tree are refitted; parts of it, or all, are rebuilt if
    /// their cost by the surface area heuristic has grown too far. Hits are those of a scene built from the
    /// list, with one exception: instances that were dropped because there were too many objects
    /// ([`SceneError::TooManyObjects`]) stay out until they are changed.
    ///
    /// # Panics
    /// If an index is not below `len`.
    #[must_use]
    pub fn updated(&self, len: usize, changed: &[(u32, Option<Instance>)], threads: Threads) -> Self {
        let mut last: Vec<usize> = (0..changed.len()).collect();
        last.sort_by_key(|&i| changed[i].0);
        // Stable: of equal indices the last one is the last.
        let last: Vec<usize> =
            last.chunk_by(|&a, &b| changed[a].0 == changed[b].0).map(|same| same[same.len() - 1]).collect();
        if let Some(&i) = last.last() {
            assert!((changed[i].0 as usize) < len, "instance {} of {len}", changed[i].0);
        }
        let origin = self.top.origin();
        let mut changes: Vec<Change> = Vec::new();
        threads.run(|parallel| {
            let parallel = parallel && last.len() > FEW;
            extend(parallel, &mut changes, last.len(), |i| {
                let (inst_id, instance) = &changed[last[i]];
                let (slot, properties) = match instance {
                    Some(instance) => place_instance(instance, *inst_id, origin),
                    None => (Slot::Absent, InstanceProperties::ABSENT),
                };
                (*inst_id, slot, properties)
            });
        });
        self.after(len, changes, threads)
    }

    fn after(&self, len: usize, mut changes: Vec<Change>, threads: Threads) -> Self {
        let before = self.slots.len();
        let mut scene = Self { entries: Entries::default(), ..self.clone() };
        for index in len..before {
            scene.forget(&self.slots[index]);
        }
        scene.slots.truncate(len);
        scene.slots.grow(len);
        scene.depths[0] += len.saturating_sub(before) as u32;
        for (index, ..) in &changes {
            // New indices are absent, and so count as one object's.
            scene.forget(self.slots.get(*index as usize).unwrap_or(&Slot::Absent));
        }
        scene.number(before, len, &mut changes);
        for (_, _, properties) in &changes {
            scene.depths[properties.depth as usize] += 1;
            scene.moving += u32::from(properties.moves);
            scene.dropped += u64::from(properties.error.is_some());
        }
        let gone = (len..before).map(|index| (index as u32, None));
        let edit = |(index, _, properties): &Change| (*index, Some(properties.bounds));
        let edits: Vec<BoxEdit> = changes.iter().map(edit).chain(gone).collect();
        let indices: Vec<u32> = changes.iter().map(|change| change.0).collect();
        threads.run(|parallel| {
            scene.slots.set_all(&indices, parallel, |index| {
                let at = indices.partition_point(|&other| (other as usize) < index);
                changes[at].1.clone()
            });
        });
        let (slots, origin) = (&scene.slots, self.top.origin());
        // What needed more than these may be gone: more than enough is as good.
        let slack = changes.iter().fold(self.top.slack(), |most, change| most.max(change.2.slack));
        scene.top =
            self.top.updated(&edits, &|index| slots[index].boxes_at(origin), threads).with_slack(slack);
        let bounds = scene.bounds64();
        if !is_near(&bounds, scene.top.origin()) {
            scene.move_origin(origin_for(&bounds), threads);
        }
        scene.only = scene.top.only();
        let trees = (&scene.top, &self.top);
        scene.entries = threads.run(|parallel| self.entries.updated(trees, &scene.slots, &indices, parallel));
        scene
    }

    /// An instance is no longer counted.
    fn forget(&mut self, slot: &Slot) {
        let (depth, moves) = match slot {
            Slot::PlacedInstance(placed) => (placed.shape.scene_depth(), placed.moves()),
            Slot::Absent | Slot::Refused => (0, false),
        };
        self.depths[depth as usize] -= 1;
        self.moving -= u32::from(moves);
        self.dropped -= u64::from(matches!(slot, Slot::Refused));
    }

    /// Renumbers objects; changes that would make them too many are rejected.
    fn number(&mut self, before: usize, len: usize, changes: &mut [Change]) {
        let counts = |changes: &[Change]| -> Vec<(u32, u32)> {
            changes.iter().map(|(index, _, properties)| (*index, properties.leaves)).collect()
        };
        let none: Vec<(u32, u32)> = changes.iter().map(|change| (change.0, 0)).collect();
        let requested: u64 = changes.iter().map(|(_, _, properties)| u64::from(properties.leaves)).sum();
        let most = u64::from(INVALID_ID);
        // As most, those there were, and one for each that is new.
        if u64::from(self.leaves.count()) + requested + len.saturating_sub(before) as u64 >= most {
            let mut leaves = u64::from(self.leaves.updated(before, len, &none).count());
            for (inst_id, slot, properties) in changes.iter_mut() {
                if leaves + u64::from(properties.leaves) >= most {
                    *slot = Slot::Refused;
                    let error = SceneError::TooManyObjects { inst_id: *inst_id };
                    *properties = InstanceProperties {
                        error: properties.error.or(Some(error)),
                        leaves: 0,
                        ..InstanceProperties::ABSENT
                    };
                }
                leaves += u64::from(properties.leaves);
            }
        }
        self.leaves = self.leaves.updated(before, len, &counts(changes));
    }

    /// Builds the top tree relative to another point.
    fn move_origin(&mut self, origin: [f32; 3], threads: Threads) {
        let mut boxes = Vec::new();
        let slots = &self.slots;
        threads.run(|parallel| extend(parallel, &mut boxes, slots.len(), |i| slots[i].bounds_from(origin)));
        // A billion boxes take a hundred times the memory of their tree before.
        let boxes_at = |index: usize| slots[index].boxes_at(origin);
        let slack = self.top.slack();
        self.top = BoxIndex::build(&boxes, &boxes_at, origin, self.top.quality(), threads, &Watch::new(&()))
            .unwrap_or_else(|error| panic!("{error}"))
            .with_slack(slack);
    }
}

/// Changes that are not worth a thread.
const FEW: usize = 64;
