// SPDX-License-Identifier: GPL-3.0-or-later
//! Fitting a tree over triangles: corners of all blocks are gathered anew, boxes come with them.
//! Source: [WBS06] section 4; what becomes of triangles that cannot be traced for a while is original. Space: object.
//! Invariant: the tree holds what a build would take. A triangle that is bad for a while leaves its block, and comes back;
//! where one comes that was bad when the tree was built, or a whole block goes, there is no refit.
//! Proof: `tests/refit.rs` of `gnurt-accel`.

use gnurt_accel_core::blocks::TriangleBlock;
use gnurt_accel_core::surfaces::{Mesh, Surfaces};
use gnurt_accel_core::{Aabb, BadPrimitives, INVALID_ID, LARGEST_COORDINATE, RefitError, Threads, Triangles};
use gnurt_simd::{Level, Simd, dispatch_two, f32x4, f32x8, prefetch, prelude::*};
use rayon::prelude::*;

use crate::index::BvhIndex;
use crate::leaves::Leaves;
use crate::node::WIDTH;
use crate::pools::{Filling, transposed};
use crate::refit::state::Moving;

/// Blocks that one thread takes at a time.
const PIECE: usize = if cfg!(test) { 1 << 2 } else { 1 << 9 };

/// What came of a refit.
pub struct Refitted {
    /// What cannot be traced, as a build counts it.
    pub bad: BadPrimitives,
    /// What can.
    pub primitives: u64,
    /// Whether all triangles are where they were in their blocks.
    pub same_places: bool,
}

impl BvhIndex {
    /// Fits the tree to triangles that have moved.
    ///
    /// # Errors
    /// That it has to be built again. It is of no use then.
    pub fn refit(&mut self, surfaces: &Surfaces, threads: Threads) -> Result<Refitted, RefitError> {
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
        let same_places = !had_absent && moving.absent.is_empty();
        let primitives = moving.count - (moving.strays.len() + moving.absent.len()) as u64;
        self.moving = Some(moving);
        Ok(Refitted { bad, primitives, same_places })
    }

    /// How much more a ray is expected to do than when the tree was built: 1 where it has not been refitted.
    #[must_use]
    pub fn decline(&self) -> f64 {
        let moving = self.moving.as_deref();
        let now = moving.and_then(|moving| Some((moving.costs.first()?, moving.built.first()?)));
        now.map_or(1.0, |(now, built)| f64::from(1.0 + now) / f64::from(1.0 + built))
    }

    /// Puts triangles that were left out back into their blocks.
    fn bring_back(&mut self, moving: &mut Moving) {
        for (block, number) in moving.absent.drain(..) {
            let numbers = &mut self.leaves.blocks[block as usize].numbers;
            let first = numbers[0];
            if let Some(place) = numbers.iter().skip(1).position(|&other| other == first) {
                numbers[place + 1] = number;
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
            if parallel {
                let pieces = blocks.par_chunks_mut(PIECE).zip(boxes.par_chunks_mut(PIECE));
                let lists: Vec<Vec<usize>> = pieces.enumerate().map(piece).collect();
                lists.concat()
            } else {
                let pieces = blocks.chunks_mut(PIECE).zip(boxes.chunks_mut(PIECE));
                pieces.enumerate().flat_map(piece).collect()
            }
        });
        for at in doubtful {
            let block = &mut self.leaves.blocks[at];
            let numbers = block.numbers;
            let mut good = [INVALID_ID; WIDTH];
            let mut count = 0;
            for (lane, &number) in numbers.iter().enumerate() {
                if lane > 0 && number == numbers[0] {
                    continue;
                }
                if surfaces.judge(number, bad) {
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
        Ok(())
    }

    /// The same for a compact tree, whose blocks are filled anew.
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

/// How far ahead indices are asked for, in blocks.
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
        let mut corners = [[f32x4::splat(simd, 0.0); WIDTH]; 3];
        if !mesh.holds(&block.numbers) {
            mesh = surfaces.mesh(block.numbers[0]);
        }
        match mesh.as_triangles().filter(|_| mesh.holds(&block.numbers)) {
            Some((start, Triangles { positions, indices })) => {
                for number in ahead.into_iter().flatten() {
                    prefetch(indices, number.wrapping_sub(start) as usize);
                }
                let positions = positions.as_flattened();
                for (lane, &number) in block.numbers.iter().enumerate() {
                    let [a, b, c] = indices[(number - start) as usize];
                    corners[0][lane] = vertex(simd, positions, a);
                    corners[1][lane] = vertex(simd, positions, b);
                    corners[2][lane] = vertex(simd, positions, c);
                }
            }
            None => {
                for (lane, &number) in block.numbers.iter().enumerate() {
                    let (positions, vertices) = surfaces.indices(number);
                    for (corner, at) in corners.iter_mut().zip(vertices) {
                        corner[lane] = vertex(simd, positions.as_flattened(), at);
                    }
                }
            }
        }
        let mut low = corners[0][0];
        let mut high = low;
        for &corner in corners.as_flattened() {
            low = low.min(corner);
            high = high.max(corner);
        }
        let rows = [rows(simd, &corners[0]), rows(simd, &corners[1]), rows(simd, &corners[2])];
        for (to, rows) in block.corners.as_flattened_mut().iter_mut().zip(rows.as_flattened()) {
            rows.store_slice(to);
        }
        let (low, high) = (low.to_array(), high.to_array());
        let bounds = Aabb { min: [low[0], low[1], low[2]], max: [high[0], high[1], high[2]] };
        boxes[at] = bounds;
        if !is_certain(simd, &rows) || bounds.greatest() > LARGEST_COORDINATE {
            doubtful.push(first + at);
        }
    }
}

/// A vertex and anything behind it; no numbers where there is none.
#[inline(always)]
fn vertex<S: Simd>(simd: S, positions: &[f32], vertex: u32) -> f32x4<S> {
    let at = 3 * vertex as usize;
    match positions.get(at..at + 4) {
        Some(vertex) => f32x4::from_slice(simd, vertex),
        None => f32x4::load_array(simd, last_vertex(positions, at)),
    }
}

#[cold]
#[inline(never)]
fn last_vertex(positions: &[f32], at: usize) -> [f32; 4] {
    match positions.get(at..at + 3) {
        Some(&[x, y, z]) => [x, y, z, 0.0],
        _ => [f32::NAN; 4],
    }
}

/// One corner of all triangles by axes.
#[inline(always)]
fn rows<S: Simd>(_: S, corner: &[f32x4<S>; WIDTH]) -> [f32x8<S>; 3] {
    let [a, b, c, d, e, f, g, h] = *corner;
    let ([x, y, z], [xx, yy, zz]) = (transposed([a, b, c, d]), transposed([e, f, g, h]));
    [x.combine(xx), y.combine(yy), z.combine(zz)]
}

/// Whether all triangles surely span an area: by far more than floats are rounded by. Where one does not one has to look
/// closely.
#[inline(always)]
fn is_certain<S: Simd>(simd: S, [a, b, c]: &[[f32x8<S>; 3]; 3]) -> bool {
    let (least, share) = (f32x8::splat(simd, 1e-30), f32x8::splat(simd, 1.0 / (1 << 20) as f32));
    let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    let along = |j: usize, k: usize| {
        let (p, q) = (u[j] * v[k], u[k] * v[j]);
        (p - q).abs().simd_gt((p.abs() + q.abs()).mul_add(share, least))
    };
    // What is no number in one coordinate spoils this.
    let all = u[0] + u[1] + u[2] + v[0] + v[1] + v[2];
    ((along(0, 1) | along(1, 2) | along(2, 0)) & all.simd_eq(all)).all_true()
}

/// What is known before the first refit.
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
