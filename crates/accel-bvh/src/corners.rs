// SPDX-License-Identifier: GPL-3.0-or-later
//! The contents of leaf blocks, by block and slot. Tests: `tests/surfaces/normals.rs`.

use crate::index::BvhIndex;
use crate::node::WIDTH;
use crate::pose::PosedLeaves;

impl BvhIndex {
    /// Numbers of all leaf blocks, and how many there are.
    pub fn numbers(&self, visit: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
        let leaves = &self.leaves;
        leaves.blocks.iter().enumerate().for_each(|(i, block)| visit(i, &block.numbers));
        leaves.pools.blocks.iter().enumerate().for_each(|(i, block)| visit(i, &block.numbers));
        let posed = leaves.posed.iter().flat_map(PosedLeaves::blocks);
        posed.enumerate().for_each(|(i, block)| visit(i, &block.numbers));
        leaves.count()
    }

    /// The corners of the triangle at a [place](gnurt_accel_core::nearest::Nearest::place); `None` for `NOWHERE`, and in
    /// compact trees.
    #[must_use]
    #[inline]
    pub fn corners_of_place(&self, place: u32) -> Option<[[f32; 3]; 3]> {
        let place = place as usize;
        let [a, b, c] = &self.leaves.blocks.get(place / WIDTH)?.corners;
        // Not by `map`, which would be a separate call.
        let lane = place % WIDTH;
        Some([
            [a[0][lane], a[1][lane], a[2][lane]],
            [b[0][lane], b[1][lane], b[2][lane]],
            [c[0][lane], c[1][lane], c[2][lane]],
        ])
    }

    /// The corners of one triangle.
    #[must_use]
    pub fn corners_at(&self, block: usize, lane: usize) -> [[f32; 3]; 3] {
        let leaves = &self.leaves;
        match (leaves.blocks.get(block), &leaves.posed) {
            (Some(block), _) => block.triangle(lane),
            (None, Some(posed)) => posed.triangle(block, lane),
            (None, None) => leaves.pools.triangle(block, lane),
        }
    }
}
