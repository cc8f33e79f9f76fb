// SPDX-License-Identifier: GPL-3.0-or-later
//! Users of an object: visible instances, and used objects that hold it, by reference counts. Invariants: an
//! object without users has no tree and holds nothing; no object holds itself. Tests:
//! crates/render/tests/edits.rs.

use std::collections::BTreeSet;
use std::sync::Arc;

use gnurt_accel::SharedList;
use gnurt_scene::Scene;

use super::object::ObjectSlot;

/// An object has one user more, which may be its first.
pub(super) fn retain(objects: &mut SharedList<ObjectSlot>, scene: &Scene, id: u32, dirty: &mut Vec<u32>) {
    let slot = objects.edit(id as usize);
    slot.users += 1;
    if slot.users == 1 {
        dirty.push(id);
        hold(objects, scene, id, dirty);
    }
}

/// An object has one user less, which may have been its last.
pub(super) fn release(objects: &mut SharedList<ObjectSlot>, id: u32, dirty: &mut Vec<u32>) {
    let slot = objects.edit(id as usize);
    slot.users -= 1;
    if slot.users == 0 {
        dirty.push(id);
        for &held in std::mem::take(&mut slot.holds).iter() {
            release(objects, held, dirty);
        }
    }
}

/// Updates the held objects of a used object from the scene.
pub(super) fn hold(objects: &mut SharedList<ObjectSlot>, scene: &Scene, id: u32, dirty: &mut Vec<u32>) {
    let members = &scene.objects()[id as usize].members;
    let before = objects[id as usize].holds.clone();
    if members.is_empty() && before.is_empty() {
        return;
    }
    let now: BTreeSet<u32> = members.iter().map(|member| member.object.0).collect();
    let now: Arc<[u32]> = now.into_iter().collect();
    now.iter().for_each(|&held| retain(objects, scene, held, dirty));
    objects.edit(id as usize).holds = now;
    before.iter().for_each(|&held| release(objects, held, dirty));
}
