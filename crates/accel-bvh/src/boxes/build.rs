// SPDX-License-Identifier: GPL-3.0-or-later
//! Builds a top tree: boxes into parts, a treelet for each, then the upper one. Source: [Wald07] for both.
//! Space: that of the boxes. Invariant: threads do not matter. Tests: `tests`.

use gnurt_accel_core::control::Watch;
use gnurt_accel_core::{Aabb, BuildError, Quality, SharedList, Threads};

use super::BoxIndex;
use crate::build::build;
use crate::build::parts::{PartOptions, build_parts};
use crate::treelet::{BoxesAt, NodesAtKeys, Treelet};

/// Most boxes of a treelet when it is built: the fewer, the less an edit copies, and the more often rays change treelets.
pub(super) const MOST: usize = 128;

/// The largest number of boxes in one treelet without an upper one.
pub(super) const FEW: usize = 1024;

impl BoxIndex {
    /// Over boxes relative to `origin`, those that are not empty; `boxes_at` returns the boxes of moving
    /// ones. High quality optimises treelets; the upper one has the quality `quality`.
    ///
    /// # Errors
    /// That `watch` stopped it, or that there are too many boxes (some 2^30).
    pub fn build(
        boxes: &[Aabb],
        boxes_at: BoxesAt,
        origin: [f32; 3],
        quality: Quality,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let most = if boxes.len() <= FEW { FEW } else { MOST };
        let treelets = build_parts(boxes, PartOptions { most, quality }, threads, watch, |tree| {
            Treelet::new(&tree, |member_index| (member_index, boxes[member_index as usize])).moving(boxes_at)
        })?;
        let bytes: usize = treelets.iter().map(Treelet::memory_bytes).sum();
        watch.take(bytes + size_of::<u32>() * boxes.len());
        watch.result()?;
        let mut owners = vec![0; boxes.len()];
        let mut count = 0;
        for (owner, treelet) in (1..).zip(&treelets) {
            for (member_index, _) in treelet.members() {
                owners[member_index as usize] = owner;
                count += 1;
            }
        }
        let owners = threads
            .run(|parallel| SharedList::new(owners.len(), parallel, |member_index| owners[member_index]));
        let upper = upper(&treelets, quality, threads)?;
        let built_treelets = treelets.len();
        let mut index = Self {
            treelets,
            upper,
            owners,
            origin,
            bounds: Aabb::EMPTY,
            greatest: 0.0,
            slack: 1.0,
            quality,
            count,
            built_cost: 0.0,
            built_treelets,
        };
        index.measure();
        index.built_cost = index.cost();
        Ok(index)
    }
}

/// The treelet over others; an empty one where it is not needed.
pub(super) fn upper(treelets: &[Treelet], quality: Quality, threads: Threads) -> Result<Treelet, BuildError> {
    if treelets.len() < 2 {
        return Ok(Treelet::default());
    }
    let all = (0..).zip(treelets).map(|(number, treelet)| (number, treelet.bounds()));
    let members: Vec<(u32, Aabb)> = all.filter(|(_, bounds)| !bounds.is_empty()).collect();
    let boxes: Vec<Aabb> = members.iter().map(|(_, bounds)| *bounds).collect();
    let tree = build(&&boxes[..], quality, threads)?;
    Ok(Treelet::new(&tree, |number| members[number as usize]).moving(|number| bounds_at(&treelets[number])))
}

/// The box of a treelet at keys, if it moves.
pub(super) fn bounds_at(treelet: &Treelet) -> Option<Vec<Aabb>> {
    treelet.at_keys().map(NodesAtKeys::bounds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    /// Boxes of all sizes, a few in one position, some empty.
    fn boxes(count: usize) -> Vec<Aabb> {
        let mut random = Random::new(count as u64);
        let mut next = |i: usize| match i % 50 {
            0 => Aabb::EMPTY,
            1 => Aabb { min: [0.5; 3], max: [0.5; 3] },
            _ => {
                let (corner, size) = (random.point(), random.between(0.0, 0.1));
                Aabb { min: corner, max: corner.map(|x| x + size) }
            }
        };
        (0..count).map(&mut next).collect()
    }

    #[test]
    fn every_box_is_in_one_treelet() {
        for count in [0, 1, 2, 9, FEW, FEW + 1, 5000] {
            let boxes = boxes(count);
            for quality in [Quality::Fast, Quality::Medium, Quality::High] {
                let watch = Watch::new(&());
                let index = BoxIndex::build(&boxes, &|_| None, [0.0; 3], quality, Threads::Single, &watch)
                    .expect("nobody stops it");
                let mut visited = vec![0; count];
                for (owner, treelet) in (1..).zip(&index.treelets) {
                    assert!(
                        treelet.members().count() <= if count > FEW { MOST } else { FEW },
                        "not too many"
                    );
                    for (member_index, bounds) in treelet.members() {
                        assert_eq!(bounds, boxes[member_index as usize], "it has its box");
                        assert_eq!(index.owners[member_index as usize], owner, "and knows its home");
                        visited[member_index as usize] += 1;
                    }
                }
                let shown = |i: usize| usize::from(!boxes[i].is_empty());
                assert!(visited.iter().enumerate().all(|(i, &n)| n == shown(i)), "each is there once");
                assert_eq!(index.count(), visited.iter().sum::<usize>(), "as many as there are");
                let numbers: Vec<u32> = index.upper.members().map(|(number, _)| number).collect();
                let expected = if index.treelets.len() > 1 { index.treelets.len() } else { 0 };
                assert_eq!(numbers.len(), expected, "all treelets are in the upper one");
                let whole = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(bounds));
                assert_eq!(index.bounds(), whole, "around all");
            }
        }
    }

    #[test]
    fn threads_do_not_show() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads start");
        let boxes = boxes(20_000);
        let build = |threads| {
            let watch = Watch::new(&());
            let index = BoxIndex::build(&boxes, &|_| None, [0.0; 3], Quality::Medium, threads, &watch);
            index.expect("nobody stops it")
        };
        let (single, joint) = (build(Threads::Single), build(Threads::Pool(&pool)));
        assert_eq!(single.treelets.len(), joint.treelets.len(), "as many treelets");
        for (a, b) in single.treelets.iter().zip(&joint.treelets).chain([(&single.upper, &joint.upper)]) {
            assert_eq!(a.nodes(), b.nodes(), "the same nodes");
        }
    }
}
