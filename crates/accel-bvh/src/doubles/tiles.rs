// SPDX-License-Identifier: GPL-3.0-or-later
//! The closest hits of 64 lines in double precision. Those that go side by side go through the tree together, in leaves one by one.
//! Source: as `tiles.rs` of floats: intervals of [RSH05], masks of [SIP06] where they leave several children, and a few remaining lines
//! go on singly.
//! Invariant: each line has the answer that it has alone, with the same bits. Tests: `tests/doubles.rs` of `gnurt-accel`.

use std::ops::Range;

use gnurt_accel_core::bits::{TILE, each};
use gnurt_accel_core::chunks::Chunks;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::exact::{EIGHT, Line};
use gnurt_accel_core::tile::{LANES, NearestTile, RayTile};
use gnurt_simd::{Level, Simd, StackBuffer, dispatch_wide, prefetch, prelude::*};

use super::index::DoubleIndex;
use super::line::{Given, Lanes, Prepared};
use super::rays::{Best, exact};
use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::planes::TilePlanes;
use crate::walk::{Ahead, MOST_WAIT, farthest_first, walk};

/// This number of lines or fewer go on singly.
const FEW: u32 = 5;
/// Where intervals leave this many children, lines are tested one by one against each.
const MANY: u32 = 2;
/// The greatest coordinate of an origin, in multiples of a tree's size: intervals of others are of no use.
const FARTHEST: f32 = 64.0;

/// Room for lines side by side, used again and again.
pub struct LineTile {
    rays: RayTile,
    nearest: NearestTile,
    prepared: Vec<Prepared>,
    best: Vec<Best>,
    /// Of the second and the third corner.
    weights: [[f64; 2]; TILE],
    greatest: f32,
}

impl Default for LineTile {
    fn default() -> Self {
        let (prepared, best) = (Vec::with_capacity(TILE), Vec::with_capacity(TILE));
        let (rays, nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
        Self { rays, nearest, prepared, best, weights: [[0.0; 2]; TILE], greatest: 0.0 }
    }
}

/// A child that waits, the lines that may meet it, and the steps to where the first of them may.
#[derive(Clone, Copy)]
struct Entry {
    steps: f32,
    child: Child,
    lines: u64,
}

impl LineTile {
    /// Makes lines of one direction class ready, if they may go together.
    #[inline(always)]
    fn prepare(&mut self, index: &DoubleIndex, lines: &[Line; TILE]) -> bool {
        let over = &index.over;
        if over.tree.nodes.is_empty() {
            return false;
        }
        self.prepared.clear();
        self.best.clear();
        self.greatest = 0.0;
        for (i, line) in lines.iter().enumerate() {
            let Some(prepared) = Prepared::new(&exact(line), &over.grid, over.greatest) else { return false };
            let ray = &prepared.for_nodes;
            if ray.org.iter().any(|x| x.abs() > FARTHEST) {
                return false;
            }
            for k in 0..3 {
                self.rays.org[k][i] = ray.org[k];
                self.rays.dir[k][i] = ray.dir[k];
            }
            self.rays.t_near[i] = ray.t_near;
            self.nearest.t[i] = prepared.reach(line.far);
            self.greatest = self.greatest.max(prepared.greatest);
            self.prepared.push(prepared);
            self.best.push(Best::none(line));
        }
        true
    }

    /// The weights of the triangles that lines met; always true.
    #[inline(always)]
    fn weigh<S: Simd>(&mut self, simd: S, lines: &[Line; TILE]) -> bool {
        let weights = self.weights.as_chunks_mut::<EIGHT>().0;
        let (lines, best) = (lines.as_chunks::<EIGHT>().0, self.best.as_chunks::<EIGHT>().0);
        for ((lines, best), weights) in lines.iter().zip(best).zip(weights) {
            if !best.iter().any(Best::is_met) {
                continue;
            }
            let (found, good) = Line::weights_of_eight(simd, lines, best.each_ref().map(Best::corners));
            *weights = found;
            for (i, best) in best.iter().enumerate() {
                if good >> i & 1 == 0 && best.is_met() {
                    weights[i] = best.weights(&lines[i]);
                }
            }
        }
        true
    }
}

impl DoubleIndex {
    /// [`closest`](Self::closest) of 64 lines, one after the other to `answer`. `class`: that of all of them, if they have one.
    pub fn closest_of_tile(
        &self,
        level: Level,
        lines: &[Line; TILE],
        class: Option<DirectionClass>,
        tile: &mut LineTile,
        mut answer: impl FnMut(Option<(u32, [f64; 3])>),
    ) {
        let is_together = class.is_some_and(
            |class| dispatch_wide!(level, simd => self.walk_tile(simd, lines, class, tile), else false),
        );
        if !is_together {
            tile.best.clear();
            tile.best.extend(lines.iter().map(|line| self.best(level, line)));
        }
        let is_weighed = dispatch_wide!(level, simd => tile.weigh(simd, lines), else false);
        for ((best, &at), line) in tile.best.iter().zip(&tile.weights).zip(lines) {
            answer(best.weighed(|| if is_weighed { at } else { best.weights(line) }));
        }
    }

    /// Whether the lines could go together; then `tile` has the first triangle of each.
    #[inline(always)]
    fn walk_tile<S: Simd>(
        &self,
        simd: S,
        lines: &[Line; TILE],
        class: DirectionClass,
        tile: &mut LineTile,
    ) -> bool {
        if !tile.prepare(self, lines) {
            return false;
        }
        let LineTile { rays, nearest, prepared, best, greatest, .. } = tile;
        let (tree, blocks) = (&self.over.tree, &self.over.blocks);
        let Some(mut chunks) = Chunks::new(simd, rays, TILE, class, *greatest, nearest, |_| false) else {
            return false;
        };
        let mut planes = TilePlanes::EMPTY;
        planes.prepare(simd, rays, TILE, *greatest);
        let mut buffer = StackBuffer::<Entry, MOST_WAIT>::new();
        let mut stack = buffer.stack();
        stack.push(Entry { steps: 0.0, child: Child::node(0), lines: u64::MAX });
        while let Some(Entry { steps, child, lines: bits }) = stack.pop() {
            if steps > chunks.farthest {
                continue;
            }
            let is_leaf = child.is_leaf();
            if is_leaf || bits.count_ones() <= FEW {
                let mut touched = 0;
                each(
                    bits,
                    #[inline(always)]
                    |i| {
                        let i = i % TILE;
                        let line = Alone { index: self, line: &lines[i], prepared: &prepared[i] };
                        let is_better = if is_leaf {
                            line.leaf(simd, child.blocks(), &mut best[i])
                        } else {
                            let for_nodes = planes.single_rays(simd, i, class.rows(), rays.t_near[i]);
                            line.walk(simd, child, &for_nodes, nearest.t[i], &mut best[i])
                        };
                        if is_better {
                            nearest.t[i] = prepared[i].reach(best[i].reach());
                            touched |= 1 << (i / LANES);
                        }
                    },
                );
                if touched != 0 {
                    chunks.update_reach(simd, nearest, touched);
                }
                continue;
            }
            let node = &tree.nodes[child.index()];
            let (mut children, near) = chunks.beam.meet(simd, &node.rows, chunks.farthest);
            let near = near.as_array();
            let mut masks = [bits; WIDTH];
            if children.count_ones() >= MANY {
                masks = [0; WIDTH];
                for at in (0..TILE).step_by(LANES).filter(|at| bits >> at & 0xffff != 0) {
                    let planes = planes.chunk(simd, class, rays, nearest, at);
                    each(
                        u64::from(children),
                        #[inline(always)]
                        |lane| masks[lane % WIDTH] |= planes.meet(simd, node, lane % WIDTH) << at,
                    );
                }
            }
            let mut pushed = 0;
            while children != 0 {
                let lane = children.trailing_zeros() as usize % WIDTH;
                children &= children - 1;
                let lines = bits & masks[lane];
                if lines != 0 {
                    let child = node.child(lane);
                    if child.is_leaf() {
                        prefetch(blocks, child.blocks().start);
                    } else {
                        prefetch(&tree.nodes, child.index());
                    }
                    stack.push(Entry { steps: near[lane], child, lines });
                    pushed += 1;
                }
            }
            farthest_first(stack.top(pushed), |entry: &Entry| entry.steps);
        }
        true
    }
}

/// One line of a tile.
struct Alone<'a> {
    index: &'a DoubleIndex,
    line: &'a Line,
    prepared: &'a Prepared,
}

impl Alone<'_> {
    /// Whether a leaf has a better triangle.
    #[inline(always)]
    fn leaf<S: Simd>(&self, simd: S, range: Range<usize>, best: &mut Best) -> bool {
        let Self { index, line, prepared } = self;
        let (lanes, given) = (Lanes::new(simd, prepared), Given::new(simd, line.org, line.dir));
        let mut is_better = false;
        for block in &index.over.blocks[range] {
            is_better |= block.improves(simd, line, &lanes, &given, prepared.depth(best.far()), best);
        }
        is_better
    }

    /// The same of all below a node.
    #[inline(never)]
    fn walk<S: Simd>(
        &self,
        simd: S,
        start: Child,
        for_nodes: &NodeRay<S>,
        reach: f32,
        best: &mut Best,
    ) -> bool {
        simd.vectorize(
            #[inline(always)]
            || {
                let over = &self.index.over;
                let ahead = Ahead { tree: &over.tree, blocks: &over.blocks, two_first: false };
                let (mut reach, mut is_better) = (reach, false);
                walk(
                    &ahead,
                    simd,
                    start,
                    for_nodes,
                    reach,
                    #[inline(always)]
                    |range| {
                        if self.leaf(simd, range, best) {
                            is_better = true;
                            reach = self.prepared.reach(best.reach());
                        }
                        reach
                    },
                );
                is_better
            },
        )
    }
}
