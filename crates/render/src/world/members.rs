// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects that hold others, updated bottom-up: first those whose members hold none.
//! Source: [WBS03a], level by level. Space: the object that holds them.
//! The tree has an entry for each member, at its index in the description's list, and a last one for the
//! object's own meshes. If few of them changed, it is an update of the previous one. Tests:
//! crates/render/tests/{nested,edits}.rs.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use gnurt_accel::{BuildOptions, Instance, SceneTree, SharedList, Threads};
use gnurt_scene::animation::Exposure;
use gnurt_scene::nesting::DEEPEST;
use gnurt_scene::{Affine, Member, Scene};

use super::object::{MemberSlot, Members, ObjectSlot, PlacedMember, WorldObject};
use super::object_build::ChangedObjects;
use super::open::ways_in;

/// Updates used objects that hold others: those of `dirty`, ascending, and holders of changed objects. Adds
/// them to `changed`.
pub(super) fn update(
    objects: &mut SharedList<ObjectSlot>,
    before: &SharedList<ObjectSlot>,
    dirty: &[u32],
    (scene, exposure): (&Scene, &Exposure),
    pool: &rayon::ThreadPool,
    changed: &mut ChangedObjects,
) {
    let mut levels = vec![Vec::new(); DEEPEST as usize];
    let mut known = HashMap::new();
    for (id, slot) in (0..).zip(objects.iter()).filter(|(_, slot)| !slot.holds.is_empty()) {
        levels[level(objects, id, &mut known)].push((id, slot.holds.clone()));
    }
    let mut all: BTreeSet<u32> = changed.ids.iter().copied().collect();
    for holders in levels {
        let is_due = |(id, holds): &(u32, Arc<[u32]>)| {
            dirty.binary_search(id).is_ok() || holds.iter().any(|held| all.contains(held))
        };
        let ids: Vec<u32> = holders.into_iter().filter(is_due).map(|(id, _)| id).collect();
        for id in ids {
            let slot = objects.edit(id as usize);
            let Some(own) = slot.object.take() else { continue };
            let known = before.get(id as usize).and_then(|slot| slot.object.as_ref());
            let known = known.and_then(|object| object.members.as_ref());
            let members = &scene.objects()[id as usize].members;
            let members = (&members[..], &ways_in(exposure, id));
            let members = Members::after(known.map(|known| &**known), &own, members, objects, pool);
            objects.edit(id as usize).object =
                Some(Arc::new(Arc::unwrap_or_clone(own).with_members(members)));
            changed.built += 1;
            changed.reshaped = true;
            all.insert(id);
        }
    }
    changed.ids = all.into_iter().collect();
}

/// The nesting depth of an object, without itself.
fn level(objects: &SharedList<ObjectSlot>, id: u32, known: &mut HashMap<u32, usize>) -> usize {
    if let Some(&level) = known.get(&id) {
        return level;
    }
    let inner = objects[id as usize].holds.iter().map(|&held| 1 + level(objects, held, known));
    let level = inner.max().unwrap_or(0);
    known.insert(id, level);
    level
}

impl Members {
    /// The `members` with the objects' current state, the paths of some during the open shutter, and the
    /// object's own geometry; shares unchanged parts with those `before`.
    pub(super) fn after(
        before: Option<&Self>,
        own: &WorldObject,
        (members, paths): (&[Member], &HashMap<u32, &[Affine]>),
        objects: &SharedList<ObjectSlot>,
        pool: &rayon::ThreadPool,
    ) -> Self {
        let own_place = members.len() as u32;
        let alike = before.filter(|before| before.list.len() == members.len());
        let mut list = alike.map(|before| before.list.clone()).unwrap_or_default();
        list.grow(members.len());
        let is_shown = |slot: &MemberSlot, member: &Member| {
            let now = objects.get(member.object.index()).and_then(|slot| slot.object.as_ref());
            slot.from.as_ref() == Some(member)
                && slot
                    .placed
                    .as_ref()
                    .is_none_or(|placed| now.is_some_and(|now| Arc::ptr_eq(now, &placed.object)))
        };
        let moves = |slot: &MemberSlot| slot.placed.as_ref().is_some_and(|placed| placed.motion.is_some());
        let is_other = |&member_index: &u32| {
            let slot = &list[member_index as usize];
            !is_shown(slot, &members[member_index as usize])
                || moves(slot)
                || paths.contains_key(&member_index)
        };
        let changed: Vec<u32> = (0..own_place).filter(is_other).collect();
        let make = |member_index: usize| MemberSlot {
            from: Some(members[member_index]),
            placed: PlacedMember::new(
                &members[member_index],
                objects,
                paths.get(&(member_index as u32)).copied(),
            ),
        };
        pool.install(|| list.set_all(&changed, true, make));
        let shown = |member_index: u32| {
            let member = members.get(member_index as usize)?;
            let placed = list[member_index as usize].placed.as_ref()?;
            let instance = match &placed.motion {
                Some(motion) => Instance::moving(placed.object.shape(), motion.clone()),
                None => Instance::new(placed.object.shape(), member.object_from_member.columns),
            };
            Some(instance.with_mask(member.mask.0))
        };
        let own_instance = || Instance::identity(own.tree.clone());
        let threads = Threads::Pool(pool);
        let tree = match alike.filter(|_| changed.len() <= members.len() / 2) {
            Some(before) => {
                let changes = changed.iter().map(|&member_index| (member_index, shown(member_index)));
                let all: Vec<_> = changes.chain([(own_place, Some(own_instance()))]).collect();
                before.tree.updated(members.len() + 1, &all, threads)
            }
            None => {
                let nothing = || Instance::identity(Arc::new(SceneTree::default()));
                let all = (0..own_place).map(|member_index| shown(member_index).unwrap_or_else(nothing));
                let all: Vec<Instance> = all.chain([own_instance()]).collect();
                SceneTree::build(&all, &BuildOptions::default(), threads)
            }
        };
        let inner = list.iter().filter_map(|slot| slot.placed.as_ref());
        let triangles =
            own.tree.stats().primitives + inner.map(|placed| placed.object.triangles()).sum::<u64>();
        Self { tree: Arc::new(tree), list, triangles }
    }
}
