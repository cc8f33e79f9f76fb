// SPDX-License-Identifier: GPL-3.0-or-later
//! Refit of a tree over triangles: corners of all blocks are gathered again, boxes come with them.
//! Source: [WBS06] section 4; the treatment of temporarily untraceable triangles is original. Space: object.
//! Invariant: the tree holds the triangles that a build would take. A triangle that is bad for a while leaves
//! its block, and returns. If a triangle becomes good that was bad at the build, or if a whole block becomes
//! empty, the refit fails.
//! Tests: `tests/refit.rs` of `gnurt-accel`.

use gnurt_accel_core::blocks::TriangleBlock;
use gnurt_accel_core::surfaces::{Mesh, Surfaces};
use gnurt_accel_core::threads::{Pieces, map};
use gnurt_accel_core::{Aabb, BadPrimitives, INVALID_ID, RefitError, Threads};
use gnurt_simd::{Level, Simd, dispatch_two};

use crate::gather::{Eight, are_certain, store};
use crate::index::BvhIndex;
use crate::leaves::Leaves;
use crate::node::WIDTH;
use crate::pools::Filling;
use crate::refit::state::Moving;

/// Blocks that one thread takes at a time.
const PIECE: usize = if cfg!(test) { 1 << 2 } else { 1 << 9 };

/// The result of a refit.
pub struct Refitted {
    /// Untraceable primitives, as a build counts them.
    pub bad: BadPrimitives,
    /// Traceable primitives.
    pub primitives: u64,
    /// Whether all triangles are where they were in their blocks.
    pub same_slots: bool,
}

impl BvhIndex {
    /// Fits the tree to triangles that have moved.
    ///
    /// # Errors
    /// That it has to be built again. It is of no use then.
    pub fn refit(&mut self, surfaces: &Surfaces, threads: Threads) -> Result<Refitted, RefitError> {
        if self.is_posed() {
            return self.refit_pose(surfaces, threads);
        }
        let mut moving = match self.moving.take() {
            Some(moving) => moving,
            None => Box::new(first(self, surfaces)),
        };
        let mut bad = BadPrimitives::default();
        for &number in &moving.strays {
            if surfaces.judge(number, &mut bad) {
                return Err(RefitError::OtherPrimitives);
            }
        }
        let had_absent = !moving.absent.is_empty();
        if self.is_compact() {
            self.gather_compact(surfaces, &mut moving.boxes)?;
        } else {
            self.bring_back(&mut moving);
            self.gather(surfaces, threads, &mut moving, &mut bad)?;
        }
        let Moving { boxes, costs, .. } = &mut *moving;
        let tree = &mut self.tree;
        self.stats.sah_cost = threads.run(|parallel| tree.refit(boxes, parallel, costs));
        self.greatest = self.tree.greatest();
        let same_slots = !had_absent && moving.absent.is_empty();
        let primitives = moving.count - (moving.strays.len() + moving.missing().len()) as u64;
        self.moving = Some(moving);
        Ok(Refitted { bad, primitives, same_slots })
    }

    /// How much more a ray is expected to do than when the tree was built: 1 where it has not been refitted.
    #[must_use]
    pub fn decline(&self) -> f64 {
        if let Some(posed) = &self.leaves.posed {
            return f64::from(1.0 + self.cost) / f64::from(1.0 + posed.structure.built);
        }
        let moving = self.moving.as_deref();
        let now = moving.and_then(|moving| Some((moving.costs.first()?, moving.built.first()?)));
        now.map_or(1.0, |(now, built)| f64::from(1.0 + now) / f64::from(1.0 + built))
    }

    /// Puts triangles that were left out back into their blocks.
    fn bring_back(&mut self, moving: &mut Moving) {
        for (block, number) in moving.absent.drain(..) {
            let numbers = &mut self.leaves.blocks[block as usize].numbers;
            let first = numbers[0];
            if let Some(other_lane) = numbers.iter().skip(1).position(|&other| other == first) {
                numbers[other_lane + 1] = number;
            }
        }
    }

    fn gather(
        &mut self,
        surfaces: &Surfaces,
        threads: Threads,
        moving: &mut Moving,
        bad: &mut BadPrimitives,
    ) -> Result<(), RefitError> {
        let level = Level::best();
        let blocks = &mut self.leaves.blocks[..];
        let piece = |(i, (blocks, boxes)): (usize, (&mut [TriangleBlock], &mut [Aabb]))| {
            let mut doubtful = Vec::new();
            dispatch_two!(level, simd => gather_piece(simd, surfaces, blocks, boxes, i * PIECE, &mut doubtful));
            doubtful
        };
        let boxes = &mut moving.boxes;
        let doubtful: Vec<usize> = threads.run(|parallel| {
            let (blocks, boxes) = (Pieces::new(blocks, PIECE), Pieces::new(boxes, PIECE));
            map(parallel, blocks.count(), |i| piece((i, (&mut blocks.lock(i), &mut boxes.lock(i))))).concat()
        });
        // Counted below, once for all blocks that one is in.
        let mut uncounted = BadPrimitives::default();
        for at in doubtful {
            let block = &mut self.leaves.blocks[at];
            let numbers = block.numbers;
            let mut good = [INVALID_ID; WIDTH];
            let mut count = 0;
            for (lane, &number) in numbers.iter().enumerate() {
                if lane > 0 && number == numbers[0] {
                    continue;
                }
                if surfaces.judge(number, &mut uncounted) {
                    good[count] = number;
                    count += 1;
                } else if surfaces.mesh(number).is_quads() {
                    // The other half, wherever it is, may have the fault of its quad, too.
                    return Err(RefitError::OtherPrimitives);
                } else {
                    moving.absent.push((at as u32, number));
                }
            }
            if count == 0 {
                return Err(RefitError::OtherPrimitives);
            }
            *block = TriangleBlock::new(|number| surfaces.corners(number), &good);
            let corners = |number: &u32| Aabb::around(&surfaces.corners(*number));
            moving.boxes[at] = block.numbers.iter().map(corners).fold(Aabb::EMPTY, |a, b| a.union(&b));
        }
        for number in moving.missing() {
            surfaces.judge(number, bad);
        }
        Ok(())
    }

    /// The same for a compact tree, whose blocks are filled again.
    fn gather_compact(&mut self, surfaces: &Surfaces, boxes: &mut [Aabb]) -> Result<(), RefitError> {
        let old = std::mem::take(&mut self.leaves);
        let mut filling = Filling::new(old.pools.blocks.len());
        let mut bad = BadPrimitives::default();
        for (block, bounds) in old.pools.blocks.iter().zip(boxes) {
            *bounds = Aabb::EMPTY;
            for &number in &block.numbers {
                if !surfaces.judge(number, &mut bad) {
                    return Err(RefitError::OtherPrimitives);
                }
                *bounds = bounds.union(&Aabb::around(&surfaces.corners(number)));
            }
            filling.push(&block.numbers, |number| surfaces.corners(number));
        }
        self.leaves = Leaves { pools: filling.finish(), ..Leaves::default() };
        Ok(())
    }
}

/// Distance of prefetches of indices, in blocks.
const AHEAD: usize = 6;

/// Corners and boxes of some blocks; notes those of which some triangle may be bad, counted from `first`.
#[inline(always)]
fn gather_piece<S: Simd>(
    simd: S,
    surfaces: &Surfaces,
    blocks: &mut [TriangleBlock],
    boxes: &mut [Aabb],
    first: usize,
    doubtful: &mut Vec<usize>,
) {
    let mut mesh = Mesh::NONE;
    for at in 0..blocks.len() {
        let ahead = blocks.get(at + AHEAD).map(|block| block.numbers);
        let block = &mut blocks[at];
        let triangles = Eight::gather(simd, surfaces, &mut mesh, &block.numbers, ahead.as_ref());
        let (rows, bounds) = (triangles.rows(), triangles.bounds());
        store(&rows, block);
        boxes[at] = bounds;
        if !are_certain(simd, &rows, &bounds) {
            doubtful.push(first + at);
        }
    }
}

/// The state before the first refit.
fn first(index: &BvhIndex, surfaces: &Surfaces) -> Moving {
    let mut is_there = vec![false; surfaces.starts.last().map_or(0, |&end| end as usize)];
    index.numbers(&mut |_, numbers| {
        for &number in numbers {
            is_there[number as usize] = true;
        }
    });
    let strays = surfaces.numbers().flatten().filter(|&number| !is_there[number as usize]).collect();
    Moving {
        count: surfaces.numbers().map(|numbers| numbers.len() as u64).sum(),
        strays,
        absent: Vec::new(),
        boxes: vec![Aabb::EMPTY; index.leaves.count()],
        built: index.tree.costs(),
        costs: Vec::new(),
    }
}
