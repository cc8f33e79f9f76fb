// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile of rays through the tree: multi-level ray tracing, and packets where it does not pay.
//! Source: [RSH05]: subtrees, then triangles, are discarded for all rays at once. Differs: the interval test
//! is made on the eight children of a node, then on the eight triangles of a block. The tree is searched
//! front to back, so that a tile's common entry point is found during the descent, and nodes behind all hits
//! are skipped. Where intervals leave [`MANY`] children or more, rays are tested against each child, sixteen
//! to a step, and only those that hit it go on (masks, [SIP06], Figure 4). A few remaining rays go on singly
//! ([BWW*12]), and a few that reach a leaf are tested there one by one. Rays that need any hit visit children
//! in the builder's order, which maximises hits, instead of front to back. In: a tile whose first `count`
//! rays have one direction class. Each ray gets the hit that it would get as a single ray.
//! Tests: `tests/brute_force.rs` of `gnurt-accel`.

use gnurt_accel_core::beam::Slopes;
use gnurt_accel_core::bits::{TILE, all};
use gnurt_accel_core::chunks::Chunks;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::nearest::Kind;
use gnurt_accel_core::tile::{LANES, NearestTile, RayTile};
use gnurt_accel_core::tile_test::TileTest;
use gnurt_accel_core::traversal::TileTraversal;
use gnurt_accel_core::triangle::axes_from;
use gnurt_simd::{Simd, StackBuffer, prelude::*};

use crate::index::BvhIndex;
use crate::leaves::prefetch_child;
use crate::node::{Child, WIDTH};
use crate::planes::TilePlanes;
use crate::single_rays::{ClassesOf, SingleRays};
use crate::walk::{MOST_WAIT, farthest_first};

/// Where intervals leave this many children of a node, rays are tested one by one.
const MANY: u32 = 2;
/// This number of rays or fewer go on singly. Where a register holds sixteen lanes five take up to 5 % less
/// time than three (docs/explanation/tried.md).
const fn few<S: Simd>() -> u32 {
    if S::LANES >= LANES { 5 } else { 3 }
}

/// This number of rays of a chunk or fewer are tested one by one against the eight triangles of a block.
/// Tests of sixteen rays, of which there is one for each triangle that may be met, take twice as long where a
/// register holds eight; with sixteen, six are up to 4 % better than four (docs/explanation/tried.md).
const fn few_in_leaf<S: Simd>() -> u32 {
    if S::LANES >= LANES { 6 } else { 7 }
}

/// A stack entry: a child, the rays that may hit it, and the number of steps to the first possible hit.
#[derive(Clone, Copy)]
struct Entry {
    steps: f32,
    child: Child,
    rays: u64,
}

/// Improves the hits of a tile's first rays, all of them active and of one direction class. Lanes beyond them
/// up to the next multiple of 16 hold copies of rays without an extent (`t` is -inf).
#[inline(always)]
pub(crate) fn walk_tile<S: Simd>(
    simd: S,
    index: &BvhIndex,
    direction_class: DirectionClass,
    traversal: &mut TileTraversal,
) {
    let TileTraversal { rays, kind, slot, .. } = *traversal;
    let count = TILE - traversal.active.leading_zeros() as usize;
    let BvhIndex { tree, leaves, greatest, .. } = index;
    let test = TileTest { simd, rays, kind, slot, direction_class };
    let waits = index.waits_for_memory();
    let Some(mut chunks) =
        Chunks::new(simd, rays, count, direction_class, *greatest, traversal.nearest, |_| false)
    else {
        return;
    };
    let mut planes = TilePlanes::EMPTY;
    let mut planes_ready = false;
    // The unfinished rays; only any-hit rays finish early.
    let looking = |nearest: &NearestTile| if kind == Kind::Any { nearest.looking(simd) } else { u64::MAX };
    let mut still = looking(traversal.nearest);

    let mut buffer = StackBuffer::<Entry, MOST_WAIT>::new();
    let mut stack = buffer.stack();
    stack.push(Entry { steps: 0.0, child: Child::node(0), rays: all(count) });
    while let Some(Entry { steps, child, rays: mut bits }) = stack.pop() {
        if steps > chunks.farthest {
            continue;
        }
        bits &= still;
        if bits == 0 {
            continue;
        }
        let here = bits.count_ones();
        traversal.counters.nodes += u64::from(here);
        if here <= few::<S>() {
            if !planes_ready {
                planes.prepare(simd, rays, count, *greatest);
                planes_ready = true;
            }
            let single_rays = one_by_one(rays, &planes, &chunks.slopes, direction_class);
            let touched = single_rays.walk(simd, index, child, &mut traversal.only(bits));
            if touched != 0 {
                chunks.update_reach(simd, traversal.nearest, touched);
                still = looking(traversal.nearest);
            }
            continue;
        }
        if child.is_leaf() {
            for index in child.blocks() {
                let mut buffer = None;
                let block = leaves.block(simd, index, &mut buffer);
                let few = few_of::<S>(bits);
                let single_rays = one_by_one(rays, &planes, &chunks.slopes, direction_class);
                let touched = single_rays.meet(simd, block, &mut traversal.only(few));
                if touched != 0 {
                    chunks.update_reach(simd, traversal.nearest, touched);
                }
                let bits = bits & !few;
                if bits == 0 {
                    continue;
                }
                let counters = &mut *traversal.counters;
                chunks.block(
                    simd,
                    block,
                    bits,
                    traversal.nearest,
                    #[inline(always)]
                    |candidate, slopes, nearest| {
                        let tested = bits >> (candidate.chunk * LANES) & 0xffff;
                        counters.triangles += u64::from(tested.count_ones());
                        test.meet(block, &candidate, slopes, nearest)
                    },
                );
            }
            still = looking(traversal.nearest);
            continue;
        }

        let expanded;
        let node = match tree.nodes.get(child.index()) {
            Some(node) => node,
            None => {
                let (node, children) = tree.compact_node(child.index());
                expanded = node.expand(simd, children);
                &expanded
            }
        };
        let (mut child_mask, near) = chunks.beam.meet(simd, &node.rows, chunks.farthest);
        let near = near.as_array();
        let one_by_one = child_mask.count_ones() >= MANY;
        if one_by_one && !planes_ready {
            planes.prepare(simd, rays, count, *greatest);
            planes_ready = true;
        }
        let mut pushed = 0;
        // Chunks outside, children inside: the data of a chunk's rays stays in registers.
        let mut masks = [0u64; WIDTH];
        if one_by_one {
            for at in (0..count).step_by(LANES) {
                if bits >> at & 0xffff != 0 {
                    let planes = planes.chunk(simd, direction_class, rays, traversal.nearest, at);
                    let mut left = child_mask;
                    while left != 0 {
                        let lane = left.trailing_zeros() as usize & (WIDTH - 1);
                        left &= left - 1;
                        masks[lane] |= planes.meet(simd, node, lane) << at;
                    }
                }
            }
        }
        while child_mask != 0 {
            let lane = child_mask.trailing_zeros() as usize & (WIDTH - 1);
            child_mask &= child_mask - 1;
            let mut those = bits;
            if one_by_one {
                those &= masks[lane];
                if those == 0 {
                    continue;
                }
            }
            let child = node.child(lane);
            if waits {
                prefetch_child(tree, leaves, child);
            }
            stack.push(Entry { steps: near[lane], child, rays: those });
            pushed += 1;
        }
        if kind == Kind::Closest {
            farthest_first(stack.top(pushed), |entry: &Entry| entry.steps);
        }
    }
}

/// The rays, all of one direction class, as far as they have been prepared.
#[inline(always)]
fn one_by_one<'a>(
    rays: &'a RayTile,
    planes: &'a TilePlanes,
    slopes: &'a Slopes,
    direction_class: DirectionClass,
) -> SingleRays<'a> {
    let [x, y, z] = axes_from(direction_class.longest_axis);
    let org = [&rays.org[x], &rays.org[y], &rays.org[z]];
    let (dir, t_near) = (&rays.dir, &rays.t_near);
    SingleRays { planes, org, shear: &slopes.shear, dir, t_near, classes: ClassesOf::One(direction_class) }
}

/// Those in `bits` that have few others in their chunks.
#[inline(always)]
fn few_of<S: Simd>(bits: u64) -> u64 {
    let mut few = 0;
    for at in (0..TILE).step_by(LANES) {
        let chunk = bits & 0xffff << at;
        if chunk.count_ones() <= few_in_leaf::<S>() {
            few |= chunk;
        }
    }
    few
}
