// SPDX-License-Identifier: GPL-3.0-or-later
//! A top tree after some boxes moved, came or went, which shares unchanged parts with the previous one.
//! Source: [WBS06] for refits and for rebuilding when the cost has risen; original for the rest.
//! A box that stays within its treelet's box is moved there; one that leaves goes to the treelet whose box
//! grows least. Edited treelets are refitted; degraded or full ones are rebuilt, split where they are too
//! large. The upper one is refitted, or rebuilt after new treelets. If the total cost has grown too far since
//! the build, all is rebuilt.
//! Invariant: as for any build; independent of threads. Tests: `tests`, `tests/moving_instances.rs` of
//! `gnurt-accel`.

use gnurt_accel_core::control::Watch;
use gnurt_accel_core::threads::map;
use gnurt_accel_core::{Aabb, Threads};

use super::BoxIndex;
use super::build::{FEW, MOST, bounds_at, upper};
use crate::build::parts::{PartOptions, build_parts};
use crate::treelet::{BoxesAt, Treelet, growth};

/// Edits that a thread looks at, at a time.
const PIECE: usize = 1 << 8;

/// A tree that costs this much more than when all of it was built is built again.
const WORN: f64 = 1.5;

/// If more than one of this number of boxes is edited, all is rebuilt: that takes less time.
const MANY: usize = 4;

/// A new or removed box at an index.
pub type BoxEdit = (u32, Option<Aabb>);

/// The edits of a treelet.
struct DirtyTreelet<'a> {
    number: usize,
    edits: &'a [BoxEdit],
}

impl BoxIndex {
    /// The tree with other boxes at some indices, which ascend: `None` and empty boxes are removed.
    /// `boxes_at` returns the boxes of all members that move then.
    #[must_use]
    pub fn updated(&self, edits: &[BoxEdit], boxes_at: BoxesAt, threads: Threads) -> Self {
        let length = edits.last().map_or(0, |edit| edit.0 as usize + 1).max(self.owners.len());
        let fits = if self.treelets.len() == 1 { length <= FEW } else { self.treelets.len() > 1 };
        if !fits || edits.len() > self.count / MANY {
            return self.built_again(edits, length, boxes_at, threads);
        }
        let orders = threads.run(|parallel| self.orders(edits, parallel));
        let made = self.made(&orders, boxes_at, threads);
        let mut after = self.clone();
        after.owners.grow(length);
        after.rehome(&orders, edits, threads);
        let mut touched: Vec<(u32, Option<Aabb>)> = Vec::with_capacity(made.len());
        for (number, mut pieces) in made {
            if let Some(first) = pieces.first() {
                touched.push((number as u32, Some(first.bounds())));
            }
            for (i, piece) in pieces.drain(..).enumerate() {
                if i == 0 {
                    after.treelets[number] = piece;
                    continue;
                }
                after.treelets.push(piece);
                let owner = after.treelets.len() as u32;
                let members =
                    after.treelets[owner as usize - 1].members().map(|(member_index, _)| member_index);
                let mut members: Vec<u32> = members.collect();
                members.sort_unstable();
                after.owners.set_all(&members, false, |_| owner);
            }
        }
        after.settle(self.treelets.len(), &touched, threads);
        let grown = after.treelets.len() > 2 * after.built_treelets.max(8);
        if grown || after.cost() > WORN * after.built_cost {
            return after.built_again(&[], length, boxes_at, threads);
        }
        after
    }

    /// The number of the treelet with the box of an index.
    fn owner(&self, member_index: u32) -> Option<usize> {
        self.owners.get(member_index as usize).and_then(|&owner| (owner as usize).checked_sub(1))
    }

    /// All of it from scratch.
    fn built_again(&self, edits: &[BoxEdit], length: usize, boxes_at: BoxesAt, threads: Threads) -> Self {
        let mut boxes = vec![Aabb::EMPTY; length];
        for (member_index, bounds) in self.treelets.iter().flat_map(Treelet::members) {
            boxes[member_index as usize] = bounds;
        }
        for &(member_index, bounds) in edits {
            boxes[member_index as usize] = bounds.unwrap_or(Aabb::EMPTY);
        }
        let watch = Watch::new(&());
        // A billion boxes take a hundred times the memory of their tree before.
        Self::build(&boxes, boxes_at, self.origin, self.quality, threads, &watch)
            .unwrap_or_else(|error| panic!("{error}"))
            .with_slack(self.slack)
    }

    /// The edits: treelet, index and box, ascending.
    fn orders(&self, edits: &[BoxEdit], parallel: bool) -> Vec<(u32, BoxEdit)> {
        let order = |&(member_index, bounds): &BoxEdit| {
            let bounds = bounds.filter(|bounds| !bounds.is_empty());
            let leave = |owner: usize| (owner as u32, (member_index, None));
            let enter = |owner: usize, bounds| (owner as u32, (member_index, Some(bounds)));
            match (self.owner(member_index), bounds) {
                (None, None) => [None, None],
                (Some(owner), None) => [Some(leave(owner)), None],
                (None, Some(bounds)) => [Some(enter(self.best_owner(&bounds), bounds)), None],
                (Some(owner), Some(bounds)) => match self.better_owner(owner, &bounds) {
                    Some(other) => [Some(leave(owner)), Some(enter(other, bounds))],
                    None => [Some(enter(owner, bounds)), None],
                },
            }
        };
        let of_piece =
            |edits: &[BoxEdit]| -> Vec<(u32, BoxEdit)> { edits.iter().flat_map(order).flatten().collect() };
        let pieces: Vec<&[BoxEdit]> = edits.chunks(PIECE).collect();
        let mut orders = map(parallel, pieces.len(), |i| of_piece(pieces[i])).concat();
        orders.sort_unstable_by_key(|&(number, (member_index, _))| (number, member_index));
        orders
    }

    /// The treelet whose box grows least.
    fn best_owner(&self, bounds: &Aabb) -> usize {
        if self.treelets.len() == 1 { 0 } else { self.upper.best_member(bounds) as usize }
    }

    /// Another treelet that would grow less by a box than its home.
    fn better_owner(&self, owner: usize, bounds: &Aabb) -> Option<usize> {
        let by = |number: usize| growth(&self.treelets[number].bounds(), bounds);
        let here = by(owner);
        if here == 0.0 || self.treelets.len() == 1 {
            return None;
        }
        let other = self.best_owner(bounds);
        (other != owner && by(other) < here).then_some(other)
    }

    /// Treelets after their orders: one each, several where it had to be parted.
    fn made(
        &self,
        orders: &[(u32, BoxEdit)],
        boxes_at: BoxesAt,
        threads: Threads,
    ) -> Vec<(usize, Vec<Treelet>)> {
        let edits: Vec<BoxEdit> = orders.iter().map(|(_, edit)| *edit).collect();
        let mut rest = &edits[..];
        let mut dirty = Vec::new();
        for run in orders.chunk_by(|a, b| a.0 == b.0) {
            let (edits, others) = rest.split_at(run.len());
            rest = others;
            dirty.push(DirtyTreelet { number: run[0].0 as usize, edits });
        }
        threads.run(|parallel| {
            let make = |dirty: &DirtyTreelet| (dirty.number, self.remade(dirty, boxes_at));
            map(parallel, dirty.len(), |i| make(&dirty[i]))
        })
    }

    fn remade(&self, DirtyTreelet { number, edits }: &DirtyTreelet, boxes_at: BoxesAt) -> Vec<Treelet> {
        let before = &self.treelets[*number];
        if let Some(after) = before.edited(edits).filter(|after| !after.is_worn()) {
            return vec![after.moving(boxes_at)];
        }
        let members = before.members_after(edits);
        let boxes: Vec<Aabb> = members.iter().map(|(_, bounds)| *bounds).collect();
        let full = if self.treelets.len() == 1 { FEW } else { MOST + MOST / 4 };
        let most = if members.len() <= full { full } else { MOST };
        let options = PartOptions { most, quality: self.quality };
        let watch = Watch::new(&());
        let make = |tree| Treelet::new(&tree, |number| members[number as usize]).moving(boxes_at);
        build_parts(&boxes, options, Threads::Single, &watch, make).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Updates the owners of boxes that came and left.
    fn rehome(&mut self, orders: &[(u32, BoxEdit)], edits: &[BoxEdit], threads: Threads) {
        let mut owners: Vec<(u32, u32)> = orders
            .iter()
            .filter_map(|&(number, (member_index, bounds))| bounds.map(|_| (member_index, number + 1)))
            .collect();
        owners.sort_unstable();
        let owner = |member_index: u32| match owners.binary_search_by_key(&member_index, |owner| owner.0) {
            Ok(at) => owners[at].1,
            Err(_) => 0,
        };
        let other = |&member_index: &u32| self.owners[member_index as usize] != owner(member_index);
        let indices: Vec<u32> = edits.iter().map(|edit| edit.0).filter(other).collect();
        let before = self.owner_count(&indices);
        threads.run(|parallel| {
            self.owners.set_all(&indices, parallel, |member_index| owner(member_index as u32))
        });
        self.count = self.count + self.owner_count(&indices) - before;
    }

    /// The number of these indices with a box.
    fn owner_count(&self, indices: &[u32]) -> usize {
        indices.iter().filter(|&&member_index| self.owners[member_index as usize] != 0).count()
    }

    /// Updates the upper treelet, given the former number of treelets and the changed boxes.
    fn settle(&mut self, before: usize, touched: &[(u32, Option<Aabb>)], threads: Threads) {
        if self.treelets.len() == 1 {
            self.measure();
            return;
        }
        let refitted = match self.treelets.len() == before {
            true => self.upper.edited(touched).filter(|upper| !upper.is_worn()),
            false => None,
        };
        self.upper = match refitted {
            Some(refitted) => refitted.moving(|number| bounds_at(&self.treelets[number])),
            None => upper(&self.treelets, self.quality, threads).unwrap_or_else(|error| panic!("{error}")),
        };
        self.measure();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_accel_core::Quality;
    use gnurt_testkit::Random;

    /// Every box is in one treelet that is its home, and the upper treelet has the box of each.
    fn check(index: &BoxIndex, boxes: &[Aabb]) {
        let mut visited = vec![0; boxes.len()];
        for (number, treelet) in index.treelets.iter().enumerate() {
            for (member_index, bounds) in treelet.members() {
                assert_eq!(bounds, boxes[member_index as usize], "place {member_index}");
                assert_eq!(index.owner(member_index), Some(number), "the home of {member_index}");
                visited[member_index as usize] += 1;
            }
        }
        for (member_index, &n) in visited.iter().enumerate() {
            assert_eq!(
                n,
                usize::from(!boxes[member_index].is_empty()),
                "place {member_index} is there as often"
            );
            assert_eq!(index.owner(member_index as u32).is_some(), n == 1, "and has a home");
        }
        assert_eq!(index.count, visited.iter().sum::<usize>(), "as many as there are");
        for (number, bounds) in index.upper.members() {
            assert_eq!(bounds, index.treelets[number as usize].bounds(), "treelet {number} in the upper one");
        }
        let whole = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(bounds));
        assert_eq!(index.bounds(), whole, "around all");
    }

    fn small(corner: [f32; 3]) -> Aabb {
        Aabb { min: corner, max: corner.map(|x| x + 0.01) }
    }

    #[test]
    fn any_edits_leave_a_sound_tree() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
        let mut random = Random::new(1);
        let mut boxes: Vec<Aabb> = (0..3000).map(|_| small(random.point())).collect();
        let build = |boxes: &[Aabb]| {
            BoxIndex::build(boxes, &|_| None, [0.0; 3], Quality::Medium, Threads::Single, &Watch::new(&()))
                .expect("nobody stops it")
        };
        let mut index = build(&boxes);
        let mut parted = 0;
        for step in 0..60 {
            let len = boxes.len() + 40 * usize::from(step % 3 == 0);
            boxes.resize(len, Aabb::EMPTY);
            let mut edits: Vec<BoxEdit> = Vec::new();
            for member_index in 0..len as u32 {
                let is_new = member_index as usize + 40 >= len && step % 3 == 0;
                if is_new || random.below(100) == 0 {
                    // Many come to one corner, whose treelets are soon full.
                    let near = random.point().map(|x| 0.05 * x);
                    let bounds = match random.below(4) {
                        0 => None,
                        1 => Some(small(random.point())),
                        _ => Some(small(near)),
                    };
                    edits.push((member_index, bounds));
                    boxes[member_index as usize] = bounds.unwrap_or(Aabb::EMPTY);
                }
            }
            let before = index.treelets.len();
            let single = index.updated(&edits, &|_| None, Threads::Single);
            index = index.updated(&edits, &|_| None, Threads::Pool(&pool));
            check(&index, &boxes);
            let pairs = single.treelets.iter().zip(&index.treelets).chain([(&single.upper, &index.upper)]);
            assert!(pairs.into_iter().all(|(a, b)| a.nodes() == b.nodes()), "threads do not show");
            parted += usize::from(index.treelets.len() > before);
            let fresh = build(&boxes);
            let (cost, least) = (index.cost(), fresh.cost());
            assert!(cost < 2.0 * least, "step {step}: it costs {cost}, built again {least}");
        }
        assert!(parted > 3, "treelets were parted {parted} times");
        let all: Vec<BoxEdit> =
            (0..boxes.len() as u32 / 8).map(|member_index| (member_index, None)).collect();
        for (member_index, _) in &all {
            boxes[*member_index as usize] = Aabb::EMPTY;
        }
        check(&index.updated(&all, &|_| None, Threads::Single), &boxes);
    }
}
