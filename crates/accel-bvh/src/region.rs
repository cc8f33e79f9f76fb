// SPDX-License-Identifier: GPL-3.0-or-later
//! All primitives under a wide BVH that may meet a region.
//! Invariant: leaves return primitives by boxes of their own, so that few need exact tests. A primitive may
//! come several times. Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/overlaps.rs`.

use std::ops::Range;

use gnurt_accel_core::bits::each;
use gnurt_accel_core::filter_region::{NOTHING, filter_triangles};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::{Region, RegionFilter, Rows};
use gnurt_simd::StackBuffer;

use crate::boxes::BoxIndex;
use crate::index::BvhIndex;
use crate::node::{Child, Node8, WIDTH};
use crate::pools::Pools;
use crate::tree::{DEEPEST, Tree};
use crate::treelet::Treelet;

impl Tree {
    /// Shows `leaf` the blocks of leaves that may meet it.
    pub(crate) fn filter_region(&self, region_filter: &RegionFilter, leaf: &mut dyn FnMut(Range<usize>)) {
        if self.nodes.is_empty() && self.compact.is_empty() {
            return;
        }
        let mut buffer = StackBuffer::<Child, { 8 * DEEPEST }>::new();
        let mut waiting = buffer.stack();
        waiting.push(Child::node(0));
        while let Some(child) = waiting.pop() {
            if child.is_leaf() {
                leaf(child.blocks());
                continue;
            }
            match self.nodes.get(child.index()) {
                Some(node) => {
                    overlapping(node, region_filter, |child_lane| waiting.push(node.child(child_lane)))
                }
                None => {
                    let (node, children) = self.compact_node(child.index());
                    let mut rows = NOTHING;
                    let boxes: [_; WIDTH] = std::array::from_fn(|child_lane| node.bounds(child_lane));
                    for k in 0..3 {
                        rows[2 * k] = boxes.map(|bounds| bounds.min[k]);
                        rows[2 * k + 1] = boxes.map(|bounds| bounds.max[k]);
                    }
                    each(u64::from(region_filter.overlap_mask(&rows)), |child_lane| {
                        waiting.push(Child::at(children, child_lane))
                    });
                }
            }
        }
    }
}

/// Calls `visit` with the slots of boxes that may meet it.
fn overlapping(node: &Node8, region_filter: &RegionFilter, visit: impl FnMut(usize)) {
    let rows: &Rows = node.rows.first_chunk().unwrap_or(&NOTHING);
    each(u64::from(region_filter.overlap_mask(rows)), visit);
}

impl Pools {
    /// The corners of one triangle of a block.
    pub(crate) fn triangle(&self, block: usize, lane: usize) -> [[f32; 3]; 3] {
        let block = &self.blocks[block];
        let pool = self.corners.get(block.pool as usize..).unwrap_or(&[]);
        // Behind the corners of a damaged file lie zeros, as for rays.
        let float = |i: usize| pool.get(i).copied().unwrap_or(0.0);
        [0, 1, 2].map(|corner: usize| [0, 1, 2].map(|k| float(usize::from(block.offsets[corner][lane]) + k)))
    }

    /// Shows those triangles of a block that may meet it.
    fn filter_region(
        &self,
        index: usize,
        region_filter: &RegionFilter,
        visit: &mut dyn FnMut(u32, Primitive),
    ) {
        let mut corners = [[[0.0; WIDTH]; 3]; 3];
        for lane in 0..WIDTH {
            for (rows, corner) in corners.iter_mut().zip(self.triangle(index, lane)) {
                (rows[0][lane], rows[1][lane], rows[2][lane]) = (corner[0], corner[1], corner[2]);
            }
        }
        filter_triangles(&corners, &self.blocks[index].numbers, region_filter, visit);
    }
}

impl BvhIndex {
    /// Shows the triangles that may meet it.
    pub fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(u32, Primitive)) {
        let Self { tree, leaves, .. } = self;
        tree.filter_region(region_filter, &mut |range| {
            for index in range {
                match (leaves.blocks.get(index), &leaves.posed) {
                    (Some(block), _) => block.filter_region(region_filter, visit),
                    (None, Some(posed)) => posed.filter_region(index, region_filter, visit),
                    (None, None) => leaves.pools.filter_region(index, region_filter, visit),
                }
            }
        });
    }
}

impl Treelet {
    /// Shows `visit` the members whose boxes may meet it.
    fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(usize)) {
        let mut buffer = StackBuffer::<Child, { 8 * DEEPEST }>::new();
        let mut waiting = buffer.stack();
        waiting.push(Child::node(0));
        while let Some(child) = waiting.pop() {
            if child.is_leaf() {
                for block in &self.nodes()[child.blocks()] {
                    overlapping(block, region_filter, |child_lane| visit(block.child(child_lane).index()));
                }
            } else {
                let node = &self.nodes()[child.index()];
                overlapping(node, region_filter, |child_lane| waiting.push(node.child(child_lane)));
            }
        }
    }
}

impl BoxIndex {
    /// Calls `enter` with the indices of boxes that may meet a region, which is not relative to their origin.
    pub fn filter_region(&self, region: &Region, enter: &mut dyn FnMut(usize)) {
        let region_filter = region.moved(self.origin()).region_filter(self.greatest());
        match self.treelets() {
            [] => {}
            [only] => only.filter_region(&region_filter, enter),
            treelets => self.upper().filter_region(&region_filter, &mut |number| {
                treelets[number].filter_region(&region_filter, enter)
            }),
        }
    }
}
