// SPDX-License-Identifier: GPL-3.0-or-later
//! The nodes of a treelet whose members move during an open shutter: with other boxes at keys, which are
//! times evenly spaced from 0 to 1. A ray interpolates those of the two keys next to its time, so that it
//! tests a member's position instead of its whole path. Boxes that are interpolated, instead of unions, are
//! those of Embree's `AABBNodeMB`. Keys are one more than a power of two in each treelet, so that an upper
//! one has a key at each time of its lower ones.
//! Space: that of the boxes. Invariant: the interpolated box of a member lies in the interpolated boxes above
//! it, because interpolation never reverses an order. Tests: `tests`, `tests/surfaces/motion.rs` of
//! `gnurt-accel`.

use gnurt_accel_core::{Aabb, KeyInterval};

use super::fit::refit;
use crate::interpolated::{InterpolatedNodes, hide_nothing};
use crate::node::{Child, Node8, WIDTH};

/// Boxes of a slot at keys, one more than a power of two; `None` for a static one.
pub type BoxesAt<'a> = &'a (dyn Fn(usize) -> Option<Vec<Aabb>> + Sync);

/// Nodes and blocks at each key.
#[derive(Debug)]
pub(crate) struct NodesAtKeys {
    /// Those of one key behind those of another.
    nodes: Vec<Node8>,
    keys: usize,
    /// By block: bits of the members that move.
    moving: Vec<u8>,
    first_block: usize,
}

impl NodesAtKeys {
    /// Of nodes whose boxes enclose all paths; `None` if no member moves.
    pub(super) fn new(
        nodes: &[Node8],
        first_block: usize,
        boxes_at: impl Fn(usize) -> Option<Vec<Aabb>>,
    ) -> Option<Self> {
        let mut paths = Vec::new();
        let mut moving = vec![0; nodes.len() - first_block];
        for (at, block) in nodes.iter().enumerate().skip(first_block) {
            for lane in (0..WIDTH).filter(|&lane| block.child(lane) != Child::NONE) {
                if let Some(boxes) = boxes_at(block.child(lane).index()) {
                    moving[at - first_block] |= 1 << lane;
                    paths.push((at, lane, boxes));
                }
            }
        }
        let pieces = paths.iter().map(|(.., boxes)| boxes.len() - 1).max()?;
        let mut all = Vec::with_capacity((pieces + 1) * nodes.len());
        for key in 0..=pieces {
            let first = all.len();
            all.extend_from_slice(nodes);
            let nodes = &mut all[first..];
            for (at, lane, boxes) in &paths {
                let child = nodes[*at].child(*lane);
                nodes[*at].set(*lane, &at_key(boxes, key, pieces), child);
            }
            refit(nodes, first_block);
            hide_nothing(nodes);
        }
        Some(Self { nodes: all, keys: pieces + 1, moving, first_block })
    }

    pub(super) fn memory_bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&self.nodes[..]) + self.moving.len()
    }

    /// How many pieces the time is in.
    #[inline(always)]
    pub(crate) fn pieces(&self) -> usize {
        self.keys - 1
    }

    /// The nodes at one key.
    #[inline(always)]
    pub(crate) fn nodes(&self, key: usize) -> &[Node8] {
        let count = self.nodes.len() / self.keys;
        &self.nodes[key * count..][..count]
    }

    /// The nodes at a time.
    #[inline(always)]
    pub(crate) fn interpolated(&self, time: f32) -> InterpolatedNodes<'_> {
        let KeyInterval { key, next, weights } = KeyInterval::of(time, self.keys);
        InterpolatedNodes { from: self.nodes(key), to: self.nodes(next), weights }
    }

    /// Whether a member of a block moves; the block is counted with the nodes.
    #[inline(always)]
    pub(crate) fn moves(&self, block: usize, child_lane: usize) -> bool {
        self.moving[block - self.first_block] >> child_lane & 1 != 0
    }

    /// Boxes around all members at each key.
    pub(crate) fn bounds(&self) -> Vec<Aabb> {
        (0..self.keys).map(|key| self.nodes(key)[0].whole()).collect()
    }
}

/// A box at one of finer keys: mixed in double precision, and rounded outwards.
fn at_key(boxes: &[Aabb], key: usize, pieces: usize) -> Aabb {
    let each = pieces / (boxes.len() - 1);
    let (before, share) = (key / each, (key % each) as f64 / each as f64);
    if share == 0.0 {
        return boxes[before];
    }
    let (from, to) = (&boxes[before], &boxes[before + 1]);
    let mix = |from: f32, to: f32| (1.0 - share) * f64::from(from) + share * f64::from(to);
    let mixed = |k: usize| (mix(from.min[k], to.min[k]) as f32).next_down();
    let mixed_far = |k: usize| (mix(from.max[k], to.max[k]) as f32).next_up();
    Aabb { min: [0, 1, 2].map(mixed), max: [0, 1, 2].map(mixed_far) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::build;
    use crate::treelet::Treelet;
    use gnurt_accel_core::{Quality, Threads};
    use gnurt_testkit::Random;

    #[test]
    fn boxes_hold_their_members_at_all_times() {
        let mut random = Random::new(3);
        let paths: Vec<Option<Vec<Aabb>>> = (0..60)
            .map(|i| {
                let mut next = || Aabb::around(&[random.point(), random.point()]);
                [None, Some(2), Some(3), Some(9)][i % 4].map(|keys| (0..keys).map(|_| next()).collect())
            })
            .collect();
        let still = Aabb { min: [0.0; 3], max: [0.5; 3] };
        let around = |path: &Option<Vec<Aabb>>| match path {
            Some(boxes) => boxes.iter().fold(Aabb::EMPTY, |all, one| all.union(one)),
            None => still,
        };
        let boxes: Vec<Aabb> = paths.iter().map(around).collect();
        let tree = build(&&boxes[..], Quality::Medium, Threads::Single).expect("a few boxes");
        let treelet = Treelet::new(&tree, |number| (number, boxes[number as usize]));
        assert!(treelet.clone().moving(|_| None).at_keys().is_none(), "nothing moves");
        let treelet = treelet.moving(|child_lane| paths[child_lane].clone());
        let keys = treelet.at_keys().expect("some move");
        assert_eq!(keys.pieces(), 8, "as many as the finest way has");
        for step in 0..=64 {
            let time = step as f32 / 64.0;
            let InterpolatedNodes { from, to, weights: [a, b] } = keys.interpolated(time);
            let mix = |from: f32, to: f32| f64::from(a) * f64::from(from) + f64::from(b) * f64::from(to);
            // From below: the boxes in a node's child are within that child's box.
            let boxed = |at: usize, lane: usize| {
                let (from, to) = (from[at].bounds(lane), to[at].bounds(lane));
                [0, 1, 2].map(|k| [mix(from.min[k], to.min[k]), mix(from.max[k], to.max[k])])
            };
            let first_block = treelet.node_count();
            for (at, node) in from.iter().enumerate() {
                for lane in (0..WIDTH).filter(|&lane| node.child(lane) != Child::NONE) {
                    let here = boxed(at, lane);
                    let child = node.child(lane);
                    if at < first_block {
                        let below = if child.is_leaf() { child.blocks().start } else { child.index() };
                        for other in (0..WIDTH).filter(|&lane| from[below].child(lane) != Child::NONE) {
                            let inner = boxed(below, other);
                            let holds =
                                (0..3).all(|k| here[k][0] <= inner[k][0] && inner[k][1] <= here[k][1]);
                            assert!(holds, "{inner:?} in {here:?} at {time}");
                        }
                        continue;
                    }
                    assert_eq!(keys.moves(at, lane), paths[child.index()].is_some(), "who moves is known");
                    let Some(path) = &paths[child.index()] else { continue };
                    let KeyInterval { key, next, weights: [a, b] } = KeyInterval::of(time, path.len());
                    for (k, here) in here.iter().enumerate() {
                        let mix = |from: f32, to: f32| {
                            f64::from(a) * f64::from(from) + f64::from(b) * f64::from(to)
                        };
                        let (low, high) = (
                            mix(path[key].min[k], path[next].min[k]),
                            mix(path[key].max[k], path[next].max[k]),
                        );
                        let holds = here[0] <= low + 1e-6 && high - 1e-6 <= here[1];
                        assert!(holds, "{low} to {high} in {here:?} at {time}");
                    }
                }
            }
        }
    }
}
