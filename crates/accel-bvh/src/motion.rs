// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangles that move while the shutter is open, under a wide BVH whose boxes move with them.
//! Source: [WBS06] for one tree whose boxes follow the motion; boxes that are interpolated between keys,
//! instead of unions, are those of Embree's `AABBNodeMB`; one list of nodes for each key, for any number of
//! keys, is original.
//!
//! The tree is built over the triangles in the middle of the shutter time, and refitted to each key: all keys
//! have the same nodes and blocks, with other boxes and corners. A ray interpolates between the two keys next
//! to its time.
//! Invariant: an interpolated box encloses its subtree, because interpolation never reverses an order
//! (`KeyInterval`); traversals interpolate slopes instead of planes, and stay within the slack of slabs. So
//! hits are those of a tree over the interpolated triangles, bit for bit. Absent children have a box that is
//! finite, so that its interpolation is no NaN, and inverted, so that no ray hits it.
//! Space: object. Tests: `tests/surfaces/motion.rs` of `gnurt-accel`.

mod walk;

use gnurt_accel_core::blocks::TriangleBlock;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::surfaces::Surfaces;
use gnurt_accel_core::threads::extend;
use gnurt_accel_core::{
    Aabb, BadPrimitives, BuildError, INVALID_ID, KeyInterval, LARGEST_COORDINATE, Quality, Threads, TreeStats,
};

use crate::build::try_build;
use crate::index::BvhIndex;
use crate::interpolated::{empty_nothing, hide_nothing};
use crate::leaves::Leaves;
use crate::node::{Node8, WIDTH};

/// A tree and triangles at each key.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionIndex {
    /// One or more, with the same nodes and blocks. None of them is compact.
    keys: Vec<BvhIndex>,
    /// Around all of them.
    bounds: Aabb,
    greatest: f32,
}

impl MotionIndex {
    /// Builds over the triangles that can be traced at every key, given all of them at each; `None` where there are none.
    /// The others are counted, and so are those with two coincident corners at every key.
    ///
    /// # Errors
    /// That `watch` stopped it, or that there are more blocks than leaves can number.
    ///
    /// # Panics
    /// If there is no key.
    pub fn build(
        keys: &[Surfaces],
        bad: &mut BadPrimitives,
        quality: Quality,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Option<Self>, BuildError> {
        let (good, boxes) = screen(keys, bad, threads);
        if good.is_empty() {
            return Ok(None);
        }
        let mut tree = try_build(&&boxes[..], Vec::new(), quality, threads, watch)?;
        drop(boxes);
        let in_blocks = std::mem::take(&mut tree.blocks);
        let number = |valid_index: u32| good.get(valid_index as usize).copied().unwrap_or(INVALID_ID);
        let mut made: Vec<BvhIndex> = Vec::with_capacity(keys.len());
        for surfaces in keys {
            watch.take(tree.node_bytes() + size_of::<TriangleBlock>() * in_blocks.len());
            watch.result()?;
            made.push(threads.run(|parallel| {
                let mut blocks = Vec::new();
                extend(parallel, &mut blocks, in_blocks.len(), |i| {
                    TriangleBlock::new(|number| surfaces.corners(number), &in_blocks[i].map(number))
                });
                let mut boxes = Vec::new();
                extend(parallel, &mut boxes, blocks.len(), |i| around(&blocks[i]));
                let mut tree = tree.clone();
                tree.refit(&boxes, parallel, &mut Vec::new());
                hide_nothing(&mut tree.nodes);
                let stats = tree.measure();
                BvhIndex { leaves: Leaves { blocks, ..Leaves::default() }, ..BvhIndex::of_tree(tree, stats) }
            }));
        }
        let bounds = made.iter().fold(Aabb::EMPTY, |all, key| all.union(&key.bounds()));
        Ok(Some(Self { keys: made, bounds, greatest: bounds.greatest() }))
    }

    /// Box around all triangles at all times.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Size and shape; the cost is the mean of the keys'.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        let first = self.keys[0].stats();
        let sum = |of: fn(&TreeStats) -> u64| self.keys.iter().map(|key| of(&key.stats())).sum();
        let cost: f64 = self.keys.iter().map(|key| key.stats().sah_cost).sum();
        TreeStats {
            sah_cost: cost / self.keys.len() as f64,
            tree_bytes: sum(|stats| stats.tree_bytes),
            primitive_bytes: sum(|stats| stats.primitive_bytes),
            ..first
        }
    }

    /// How many there are.
    #[must_use]
    pub fn keys(&self) -> u32 {
        self.keys.len() as u32
    }

    /// The tree at time 0.
    #[must_use]
    pub fn first(&self) -> &BvhIndex {
        &self.keys[0]
    }

    /// The corners of one triangle at a time.
    #[must_use]
    pub fn corners_at(&self, block: usize, lane: usize, time: f32) -> [[f32; 3]; 3] {
        let interval = KeyInterval::of(time, self.keys.len());
        let [from, to] = [interval.key, interval.next].map(|key| self.keys[key].corners_at(block, lane));
        [0, 1, 2].map(|corner| interval.mix3(from[corner], to[corner]))
    }

    /// The tree at one time, for callers that need only that time.
    #[must_use]
    pub fn at(&self, time: f32) -> BvhIndex {
        let interval = KeyInterval::of(time, self.keys.len());
        let (mut mixed, to) = (self.keys[interval.key].clone(), &self.keys[interval.next]);
        let mix = |rows: &mut [f32], to: &[f32]| {
            rows.iter_mut().zip(to).for_each(|(from, &to)| *from = interval.mix(*from, to));
        };
        for (node, to) in mixed.tree.nodes.iter_mut().zip(&to.tree.nodes) {
            mix(node.rows[..6].as_flattened_mut(), to.rows[..6].as_flattened());
        }
        empty_nothing(&mut mixed.tree.nodes);
        for (block, to) in mixed.leaves.blocks.iter_mut().zip(&to.leaves.blocks) {
            let rows = block.corners.as_flattened_mut().as_flattened_mut();
            mix(rows, to.corners.as_flattened().as_flattened());
        }
        let root = mixed.tree.nodes.first().map_or(Aabb::EMPTY, Node8::whole);
        mixed.tree.bounds = root;
        mixed.stats = mixed.tree.measure();
        mixed.greatest = mixed.tree.greatest();
        mixed
    }
}

/// Numbers of the triangles that can be traced at every key, ascending, and their boxes in the middle of the time.
fn screen(keys: &[Surfaces], bad: &mut BadPrimitives, threads: Threads) -> (Vec<u32>, Vec<Aabb>) {
    let numbers: Vec<u32> = keys[0].numbers().flatten().collect();
    let middle = KeyInterval::of(0.5, keys.len());
    let judged = threads.run(|parallel| {
        let mut judged: Vec<Result<Aabb, BadPrimitives>> = Vec::new();
        extend(parallel, &mut judged, numbers.len(), |i| judge(keys, numbers[i], &middle));
        judged
    });
    let (mut good, mut boxes) = (Vec::with_capacity(numbers.len()), Vec::with_capacity(numbers.len()));
    for (number, judged) in numbers.into_iter().zip(judged) {
        match judged {
            Ok(bounds) => {
                good.push(number);
                boxes.push(bounds);
            }
            Err(fault) => *bad += fault,
        }
    }
    (good, boxes)
}

/// A triangle's box in the middle, or its first fault.
fn judge(keys: &[Surfaces], number: u32, middle: &KeyInterval) -> Result<Aabb, BadPrimitives> {
    let mut bad = BadPrimitives::default();
    let mut is_flat = true;
    for surfaces in keys {
        let (positions, corners) = surfaces.indices(number);
        if corners.iter().any(|&i| i as usize >= positions.len()) {
            bad.bad_index += 1;
            return Err(bad);
        }
        let [a, b, c] = corners.map(|i| positions[i as usize]);
        let coordinates = [a, b, c];
        let coordinates = coordinates.iter().flatten().copied();
        if !coordinates.clone().all(|x| x.abs() <= LARGEST_COORDINATE) {
            if let Some(fault) = bad.fault(coordinates) {
                *fault += 1;
            }
            return Err(bad);
        }
        is_flat &= a == b || b == c || c == a;
    }
    if is_flat {
        // A quad with one flat half is a triangle.
        let is_half = keys[0].mesh(number).is_quads();
        bad.zero_area += u64::from(!is_half);
        return Err(bad);
    }
    let [from, to] = [middle.key, middle.next].map(|key| keys[key].corners(number));
    Ok(Aabb::around(&[0, 1, 2].map(|corner| middle.mix3(from[corner], to[corner]))))
}

fn around(block: &TriangleBlock) -> Aabb {
    let boxes = (0..WIDTH).map(|lane| Aabb::around(&block.triangle(lane)));
    boxes.fold(Aabb::EMPTY, |all, one| all.union(&one))
}
