// SPDX-License-Identifier: GPL-3.0-or-later
//! Data of instances for rays, in the order of the top tree: one line of the cache each.
//! A ray that meets many small instances waits for memory at each. Here its map lies at a place that is known from the tree's
//! block alone, so that all instances of a block are requested at once; their shapes are in a short list for each treelet.
//! Space: world. Invariant: entries equal what slots hold; treelets that a scene shares with the one before share these, too.
//! Tests: `tests`, `tests/instances.rs`, `tests/moving_instances.rs`.

use std::sync::Arc;

use gnurt_accel_bvh::{BoxIndex, Member};
use gnurt_accel_core::affine::ObjectFromWorld;
use gnurt_simd::prefetch;

use super::types::{At, Entries, Entry, Shape, Shown, Slot, TreeletEntries};
use crate::SharedList;

/// Slots are requested so many instances before they are read.
const AHEAD: usize = 8;

impl Entry {
    /// Of one that is entered by its slot: it moves, or is where the world is, or is not there.
    const BY_SLOT: Self = {
        let map = ObjectFromWorld { rows: [[0.0; 3]; 3], translation: [[0.0; 3]; 2] };
        Self { map, shown: u32::MAX }
    };
}

impl TreeletEntries {
    /// Of the treelet with this number.
    fn new(top: &BoxIndex, treelet: usize, slots: &SharedList<Slot>) -> Self {
        let members: Vec<Member> = top.members(treelet).collect();
        let mut entries = Self { list: vec![Entry::BY_SLOT; top.places(treelet)], shown: Vec::new() };
        for (i, member) in members.iter().enumerate() {
            // Neighbours in space are none in the list.
            if let Some(later) = members.get(i + AHEAD) {
                prefetch(std::slice::from_ref(&slots[later.index]), 0);
            }
            entries.put(member, slots);
        }
        entries
    }

    /// Enters an instance.
    fn put(&mut self, member: &Member, slots: &SharedList<Slot>) {
        let Slot::PlacedInstance(placed) = &slots[member.index] else { return };
        let At::Still { object_from_world: Some(map), .. } = &placed.at else { return };
        let number = self.number(placed.mask, &placed.shape);
        self.list[member.place] = Entry { map: *map, shown: number };
    }

    /// The number of a shape under a mask; neighbours often have the same.
    fn number(&mut self, mask: u32, shape: &Shape) -> u32 {
        let is_same = |other: &Shown| other.mask == mask && other.shape.is_same(shape);
        let number = self.shown.iter().rposition(is_same).unwrap_or_else(|| {
            self.shown.push(Shown { shape: shape.clone(), mask });
            self.shown.len() - 1
        });
        number as u32
    }

    /// Of the treelet with this number where it was like this before, in `tree`; `is_edited` says which slots are others now.
    fn edited(
        &self,
        (top, tree): (&BoxIndex, &BoxIndex),
        treelet: usize,
        slots: &SharedList<Slot>,
        is_edited: &dyn Fn(usize) -> bool,
    ) -> Self {
        let mut before = vec![usize::MAX; self.list.len()];
        tree.members(treelet).for_each(|member| before[member.place] = member.index);
        let mut entries = Self { list: vec![Entry::BY_SLOT; top.places(treelet)], shown: Vec::new() };
        // A shape that no instance shows any more is not held.
        let mut numbers = vec![u32::MAX; self.shown.len()];
        for member in top.members(treelet) {
            if before.get(member.place) != Some(&member.index) || is_edited(member.index) {
                entries.put(&member, slots);
                continue;
            }
            let Entry { map, shown } = self.list[member.place];
            let Some(old) = self.shown.get(shown as usize) else { continue };
            if numbers[shown as usize] == u32::MAX {
                numbers[shown as usize] = entries.number(old.mask, &old.shape);
            }
            entries.list[member.place] = Entry { map, shown: numbers[shown as usize] };
        }
        entries
    }

    /// Asks for the memory of an instance.
    #[inline(always)]
    pub(super) fn prefetch(&self, place: usize) {
        prefetch(&self.list, place);
    }

    /// An instance at a place, unless it is to be entered by its slot.
    #[inline(always)]
    pub(super) fn get(&self, place: usize) -> Option<(&ObjectFromWorld, &Shown)> {
        let entry = &self.list[place];
        self.shown.get(entry.shown as usize).map(|shown| (&entry.map, shown))
    }
}

impl Entries {
    /// Of all treelets of `top`. `parallel`: by the threads of the present pool.
    pub(super) fn new(top: &BoxIndex, slots: &SharedList<Slot>, parallel: bool) -> Self {
        let of = |treelet: usize| Arc::new(TreeletEntries::new(top, treelet, slots));
        Self(SharedList::new(top.treelet_count(), parallel, of))
    }

    /// Of all treelets of `top`, which came of `tree`, whose entries these are; `edited` are the slots that are others now, in
    /// ascending order.
    pub(super) fn updated(
        &self,
        (top, tree): (&BoxIndex, &BoxIndex),
        slots: &SharedList<Slot>,
        edited: &[u32],
        parallel: bool,
    ) -> Self {
        let count = top.treelet_count();
        let others: Vec<u32> =
            (0..count as u32).filter(|&treelet| !top.shares_treelet(tree, treelet as usize)).collect();
        if 2 * others.len() > count {
            return Self::new(top, slots, parallel);
        }
        let is_edited = |index: usize| edited.binary_search(&(index as u32)).is_ok();
        let mut list = self.0.clone();
        list.truncate(count);
        list.grow(count);
        list.set_all(&others, parallel, |treelet| {
            Arc::new(match self.0.get(treelet) {
                Some(before) => before.edited((top, tree), treelet, slots, &is_edited),
                None => TreeletEntries::new(top, treelet, slots),
            })
        });
        Self(list)
    }

    /// Those of a treelet.
    #[inline(always)]
    pub(super) fn of(&self, treelet: usize) -> &TreeletEntries {
        &self.0[treelet]
    }

    /// Bytes of all.
    pub(super) fn memory_bytes(&self) -> usize {
        let of = |entries: &Arc<TreeletEntries>| {
            size_of::<TreeletEntries>() + size_of_val(&entries.list[..]) + size_of_val(&entries.shown[..])
        };
        self.0.memory_bytes() + self.0.iter().map(of).sum::<usize>()
    }
}

impl Shape {
    /// Whether it is the same object or scene.
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Object(a), Self::Object(b)) => Arc::ptr_eq(a, b),
            (Self::Scene(a), Self::Scene(b)) => Arc::ptr_eq(a, b),
            (Self::Object(_), Self::Scene(_)) | (Self::Scene(_), Self::Object(_)) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, MotionPath, ObjectTree, SceneTree, Threads};
    use gnurt_testkit::Random;

    /// Every placed instance has the map, shape and mask of its slot, or is entered by its slot.
    fn check(scene: &SceneTree) {
        let mut found = vec![false; scene.slots.len()];
        for treelet in 0..scene.top.treelet_count() {
            for member in scene.top.members(treelet) {
                found[member.index] = true;
                let placed = scene.placed(member.index).expect("what has a box is placed");
                let entry = scene.entries.of(treelet).get(member.place);
                let At::Still { object_from_world: Some(map), .. } = &placed.at else {
                    assert!(entry.is_none(), "{} moves, or is where the world is", member.index);
                    continue;
                };
                let (own, shown) = entry.expect("one that stands still");
                assert_eq!((own.rows, own.translation), (map.rows, map.translation), "{}", member.index);
                assert!(shown.shape.is_same(&placed.shape) && shown.mask == placed.mask, "{}", member.index);
            }
        }
        let placed = (0..scene.slots.len()).filter(|&i| scene.placed(i).is_some()).count();
        assert_eq!(found.iter().filter(|&&found| found).count(), placed, "all are there");
    }

    #[test]
    fn entries_follow_the_slots() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let triangle = crate::Triangles { positions: &corners, indices: &[[0, 1, 2]] };
        let build =
            || Arc::new(ObjectTree::build(&[triangle], &crate::BuildOptions::default(), Threads::Single));
        let objects = [build(), build(), build()];
        let mut random = Random::new(5);
        let mut any = |kind: u32| {
            let mut columns = [[0.5, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
            columns[3] = random.point().map(|x| 100.0 * f64::from(x));
            let object = objects[random.below(3)].clone();
            match kind % 10 {
                0 => Instance::identity(object),
                1 => {
                    let mut end = columns;
                    end[3][0] += 3.0;
                    Instance::moving(object, Arc::new(MotionPath::new(&[columns, end]).expect("two places")))
                }
                2 => Instance::new(object, columns).with_mask(6),
                _ => Instance::new(object, columns),
            }
        };
        let instances: Vec<Instance> = (0..3000).map(&mut any).collect();
        let mut scene = SceneTree::build(&instances, &crate::BuildOptions::default(), Threads::Single);
        check(&scene);
        let size = scene.entries.memory_bytes();
        assert!((64 * 3000..200 * 3000).contains(&size), "{size} bytes");
        for (step, count) in [1, 5, 300, 2000, 3].into_iter().enumerate() {
            let edits: Vec<(u32, Option<Instance>)> =
                (0..count).map(|i| ((7 * i + step as u32) % 3000, (i % 9 != 8).then(|| any(i)))).collect();
            let after = scene.updated(3000 + step, &edits, Threads::Single);
            check(&after);
            check(&scene);
            let pairs = scene.entries.0.iter().zip(after.entries.0.iter());
            let shared = pairs.filter(|(before, after)| Arc::ptr_eq(before, after)).count();
            assert!(
                count > 5 || shared + 3 * count as usize >= after.top.treelet_count(),
                "{shared} are shared"
            );
            scene = after;
        }
    }
}
