// SPDX-License-Identifier: GPL-3.0-or-later
//! From a point to the nearest primitive under a wide BVH: nearest boxes first, boxes beyond the best are skipped.
//! Source: [WBB08] for the eight boxes at once; nearest first after [RKV95]. Space: that of the tree.
//! Invariant: a box is skipped only where it surely is farther: the point is rounded outwards, and squares of distances
//! count as a millionth less than they were computed. Tests: `tests/closest_point.rs`.

use std::ops::Range;

use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_simd::{Simd, StackBuffer, f32x8, prelude::*};

use crate::index::BvhIndex;
use crate::node::{Boxes, Child, WIDTH};
use crate::tree::{DEEPEST, Tree};
use crate::walk::farthest_first;

/// A point in lanes: least and greatest floats around each coordinate.
#[derive(Clone, Copy)]
pub(crate) struct Around<S: Simd>([[f32x8<S>; 2]; 3]);

impl<S: Simd> Around<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, point: &[f64; 3]) -> Self {
        let at = |x: f64| {
            let near = x as f32;
            [f32x8::splat(simd, near.next_down()), f32x8::splat(simd, near.next_up())]
        };
        Self([at(point[0]), at(point[1]), at(point[2])])
    }

    /// Squares of the distances to the boxes of a node, or a little less; infinite where there is none.
    #[inline(always)]
    pub(crate) fn squares<B: Boxes>(&self, simd: S, node: &B) -> f32x8<S> {
        let row = |i: usize| node.row(simd, i / 2, i);
        let zero = f32x8::splat(simd, 0.0);
        let [[x0, x1], [y0, y1], [z0, z1]] = self.0;
        let x = (row(0) - x1).max(x0 - row(1)).max(zero);
        let y = (row(2) - y1).max(y0 - row(3)).max(zero);
        let z = (row(4) - z1).max(z0 - row(5)).max(zero);
        (x * x + y * y + z * z) * f32x8::splat(simd, 1.0 - 1e-6)
    }
}

/// The square of a distance as a float, or a little more.
pub(crate) fn square_of(reach: f64) -> f32 {
    ((reach * reach) as f32).next_up()
}

impl Tree {
    /// Calls `leaf` with the blocks of leaves within `reach`; it answers with the new reach. The tree is not empty.
    #[inline(always)]
    pub(crate) fn near<S: Simd>(
        &self,
        simd: S,
        point: &[f64; 3],
        reach: f64,
        leaf: impl FnMut(Range<usize>) -> f64,
    ) {
        let around = Around::new(simd, point);
        walk_near(
            simd,
            reach,
            #[inline(always)]
            |index| match self.nodes.get(index) {
                Some(node) => (around.squares(simd, node), node.children()),
                None => {
                    let (node, children) = self.compact_node(index);
                    (around.squares(simd, node), children)
                }
            },
            leaf,
        );
    }
}

/// Calls `leaf` with the blocks of leaves within `reach`; it answers with the new reach. `squares` returns
/// the squares of the distances to the boxes of a node, and its children; the first node is the root.
#[inline(always)]
pub(crate) fn walk_near<'a, S: Simd>(
    simd: S,
    reach: f64,
    squares: impl Fn(usize) -> (f32x8<S>, &'a [f32; WIDTH]),
    mut leaf: impl FnMut(Range<usize>) -> f64,
) {
    let mut buffer = StackBuffer::<(f32, Child), { 8 * DEEPEST }>::new();
    let mut waiting = buffer.stack();
    let mut reach = square_of(reach);
    waiting.push((0.0, Child::node(0)));
    while let Some((distance, child)) = waiting.pop() {
        if distance > reach {
            continue;
        }
        if child.is_leaf() {
            reach = square_of(leaf(child.blocks()));
            continue;
        }
        let (squares, children) = squares(child.index());
        let mut bits = squares.simd_le(f32x8::splat(simd, reach)).to_bitmask();
        let mut count = 0;
        while bits != 0 {
            let child_lane = bits.trailing_zeros() as usize & (WIDTH - 1);
            bits &= bits - 1;
            // Boxes from +inf to -inf are at an infinite distance, which an infinite reach reaches.
            if Child::at(children, child_lane) != Child::NONE {
                waiting.push((squares[child_lane], Child::at(children, child_lane)));
                count += 1;
            }
        }
        farthest_first(waiting.top(count), |&(square, _)| square);
    }
}

impl BvhIndex {
    /// Improves `nearest` by the triangles.
    #[inline(always)]
    pub(crate) fn nearest<S: Simd>(&self, simd: S, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        let Self { tree, leaves, .. } = self;
        tree.near(simd, &probe.point, probe.radius_for(nearest.distance()), |range| {
            for index in range {
                leaves.block(simd, index, &mut None).nearest(probe, slot, nearest);
            }
            probe.radius_for(nearest.distance())
        });
    }
}
