// SPDX-License-Identifier: GPL-3.0-or-later
//! Trees over triangles in double precision, and over boxes. Tests: `tests/doubles.rs` of `gnurt-accel`.

use std::ops::Range;

use gnurt_accel_core::{Aabb, BuildError, BuildOptions, INVALID_ID, Threads, TreeStats};
use gnurt_simd::{Level, Simd, dispatch, prefer_huge_pages};

use super::block::DoubleBlock;
use super::grid::{Box64, Grid};
use super::line::{DoubleLine, Lanes, Prepared};
use crate::build::build;
use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::tree::Tree;
use crate::walk::walk;

/// Triangles as they were given, under a tree of floats.
#[derive(Clone, Debug)]
pub struct DoubleIndex {
    pub(super) over: Over<DoubleBlock>,
    /// The block and the lane of each number.
    places: Vec<u32>,
}

/// Boxes of what instances show.
#[derive(Clone, Debug)]
pub struct DoubleBoxes {
    over: Over<[u32; WIDTH]>,
}

/// A triangle that a line may touch.
type Candidate<'a> = (u32, &'a [[f64; 3]; 3], bool);

#[derive(Clone, Debug)]
pub(super) struct Over<B> {
    pub(super) tree: Tree,
    pub(super) blocks: Vec<B>,
    /// The greatest coordinate of any plane.
    pub(super) greatest: f32,
    stats: TreeStats,
    pub(super) grid: Grid,
    bounds: Box64,
}

const NOWHERE: Box64 = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

fn grown([min, max]: Box64, point: &[f64; 3]) -> Box64 {
    [[0, 1, 2].map(|k| min[k].min(point[k])), [0, 1, 2].map(|k| max[k].max(point[k]))]
}

impl<B> Over<B> {
    /// Over `count` boxes.
    fn build(
        count: usize,
        each: impl Fn(usize) -> Box64,
        options: &BuildOptions,
        threads: Threads,
        block: impl Fn(&[u32; WIDTH]) -> B,
    ) -> Result<Self, BuildError> {
        let bounds = (0..count).fold(NOWHERE, |all, i| each(i).iter().fold(all, grown));
        let grid = Grid::around(&bounds);
        let boxes: Vec<Aabb> = (0..count).map(|i| grid.outwards(&each(i))).collect();
        let mut tree = build(&&boxes[..], options.quality, threads)?;
        tree.settle(options.memory);
        let stats = tree.measure();
        let numbers = std::mem::take(&mut tree.blocks);
        let mut blocks = Vec::with_capacity(numbers.len());
        prefer_huge_pages(&blocks);
        blocks.extend(numbers.iter().map(block));
        Ok(Self { blocks, greatest: tree.greatest(), tree, stats, grid, bounds })
    }

    /// Calls `leaf` with blocks that the line may meet, and with a parameter as its depth; it answers with the new reach.
    #[inline(always)]
    fn walk<S: Simd>(
        &self,
        simd: S,
        line: &Prepared,
        reach: f64,
        mut leaf: impl FnMut(Range<usize>) -> f64,
    ) -> u32 {
        let for_nodes = NodeRay::new(simd, &line.for_nodes, line.greatest);
        walk(
            &self.tree,
            simd,
            Child::node(0),
            &for_nodes,
            line.reach(reach),
            #[inline(always)]
            |range| line.reach(leaf(range)),
        )
    }

    pub(super) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    fn stats(&self) -> TreeStats {
        TreeStats {
            primitives: self.stats.references,
            tree_bytes: self.tree.node_bytes() as u64,
            primitive_bytes: size_of_val(&self.blocks[..]) as u64,
            ..self.stats
        }
    }
}

impl DoubleIndex {
    /// Over the triangles with these numbers.
    ///
    /// # Errors
    /// That there are too many.
    pub fn build(
        numbers: &[u32],
        corners: impl Fn(u32) -> [[f64; 3]; 3],
        options: &BuildOptions,
        threads: Threads,
    ) -> Result<Self, BuildError> {
        let around = |i: usize| corners(numbers[i]).iter().fold(NOWHERE, grown);
        let of = |i: u32| numbers.get(i as usize).copied().unwrap_or(INVALID_ID);
        let block = |indices: &[u32; WIDTH]| DoubleBlock::new(&corners, &indices.map(of));
        let over = Over::build(numbers.len(), around, options, threads, block)?;
        let count = numbers.iter().max().map_or(0, |&most| most as usize + 1);
        let mut places = vec![INVALID_ID; count];
        for (i, block) in over.blocks.iter().enumerate() {
            for lane in block.lanes() {
                places[block.numbers[lane] as usize] = (WIDTH * i + lane) as u32;
            }
        }
        Ok(Self { over, places })
    }

    /// The box around all triangles; from +inf to -inf where there is none.
    #[must_use]
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        self.over.bounds
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        let places = size_of_val(&self.places[..]) as u64;
        let stats = self.over.stats();
        TreeStats { primitive_bytes: stats.primitive_bytes + places, ..stats }
    }

    /// The corners of a triangle, if it is in the tree.
    #[must_use]
    pub fn corners(&self, number: u32) -> Option<[[f64; 3]; 3]> {
        let place = *self.places.get(number as usize).filter(|place| **place != INVALID_ID)? as usize;
        Some(self.over.blocks[place / WIDTH].corners(place % WIDTH))
    }

    /// Calls `meet` with the number and the corners of each triangle that the line may touch before `reach`, and whether it
    /// certainly passes inside; it answers with the new reach, in the line's parameter.
    pub fn search(
        &self,
        level: Level,
        line: &DoubleLine,
        reach: f64,
        meet: &mut dyn FnMut(Candidate) -> f64,
    ) {
        if self.over.is_empty() {
            return;
        }
        if let Some(line) = Prepared::new(line, &self.over.grid, self.over.greatest) {
            dispatch!(level, simd => self.search_with(simd, &line, reach, meet));
        }
    }

    #[inline(always)]
    fn search_with<S: Simd>(
        &self,
        simd: S,
        line: &Prepared,
        mut reach: f64,
        meet: &mut dyn FnMut(Candidate) -> f64,
    ) {
        let lanes = Lanes::new(simd, line);
        let blocks = &self.over.blocks;
        self.over.walk(
            simd,
            line,
            reach,
            #[inline(always)]
            |range| {
                for block in &blocks[range] {
                    for (lane, is_certain) in block.candidates(simd, &lanes, line.depth(reach)) {
                        reach = meet((block.numbers[lane], &block.corners(lane), is_certain));
                    }
                }
                reach
            },
        );
    }

    /// Calls `near` with the triangles of boxes within `reach` of a point; it answers with the new reach.
    pub fn near(
        &self,
        level: Level,
        point: [f64; 3],
        reach: f64,
        near: &mut dyn FnMut(u32, [[f64; 3]; 3]) -> f64,
    ) {
        if self.over.is_empty() {
            return;
        }
        let blocks = &self.over.blocks;
        self.over.near(level, point, reach, &mut |range| {
            let mut reach = f64::INFINITY;
            for block in &blocks[range] {
                for lane in block.lanes() {
                    reach = near(block.numbers[lane], block.corners(lane));
                }
            }
            reach
        });
    }
}

impl<B> Over<B> {
    fn near(&self, level: Level, point: [f64; 3], reach: f64, leaf: &mut dyn FnMut(Range<usize>) -> f64) {
        let (at, scale) = (self.grid.local(point), self.grid.scale);
        // Floats have no greater ones; farther points are at least as far.
        let at = at.map(|x| x.clamp(-1e18, 1e18));
        let local = |reach: f64| if reach < 0.0 { 0.0 } else { reach * scale * (1.0 + 1e-6) + 1e-30 };
        dispatch!(level, simd => self.tree.near(simd, &at, local(reach), |range| local(leaf(range))));
    }
}

impl DoubleBoxes {
    /// Over boxes by their numbers.
    ///
    /// # Errors
    /// That there are too many.
    pub fn build(
        boxes: &[[[f64; 3]; 2]],
        options: &BuildOptions,
        threads: Threads,
    ) -> Result<Self, BuildError> {
        let over = Over::build(boxes.len(), |i| boxes[i], options, threads, |numbers| *numbers)?;
        Ok(Self { over })
    }

    /// The box around all.
    #[must_use]
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        self.over.bounds
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.over.stats()
    }

    /// Calls `enter` with the numbers of boxes that the line may meet before `reach`; it answers with the new reach.
    pub fn search(&self, level: Level, line: &DoubleLine, reach: f64, enter: &mut dyn FnMut(u32) -> f64) {
        if self.over.is_empty() {
            return;
        }
        let Some(line) = Prepared::new(line, &self.over.grid, self.over.greatest) else { return };
        let blocks = &self.over.blocks;
        let mut leaf = |range: Range<usize>| {
            let mut reach = f64::INFINITY;
            for &number in blocks[range].iter().flatten().filter(|number| **number != INVALID_ID) {
                reach = enter(number);
            }
            reach
        };
        let leaf: &mut dyn FnMut(Range<usize>) -> f64 = &mut leaf;
        dispatch!(level, simd => self.over.walk(simd, &line, reach, leaf));
    }

    /// Calls `enter` with the numbers of boxes within `reach` of a point; it answers with the new reach.
    pub fn near(&self, level: Level, point: [f64; 3], reach: f64, enter: &mut dyn FnMut(u32) -> f64) {
        if self.over.is_empty() {
            return;
        }
        let blocks = &self.over.blocks;
        self.over.near(level, point, reach, &mut |range| {
            let mut reach = f64::INFINITY;
            for &number in blocks[range].iter().flatten().filter(|number| **number != INVALID_ID) {
                reach = enter(number);
            }
            reach
        });
    }
}
