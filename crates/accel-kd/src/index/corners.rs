// SPDX-License-Identifier: GPL-3.0-or-later
//! The contents of leaf blocks, by block and slot; projected triangles are stored by number instead.
//! Tests: `tests/surfaces/normals.rs`.

use gnurt_accel_core::INVALID_ID;
use gnurt_accel_core::blocks::WIDTH;

use super::{KdIndex, Prepared};

impl KdIndex {
    /// Numbers of all leaf blocks, and how many there are. Projected triangles are numbered by themselves.
    pub fn numbers(&self, visit: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
        match &self.triangles {
            Prepared::Watertight(leaves) => {
                leaves.blocks.iter().enumerate().for_each(|(i, block)| visit(i, &block.numbers));
                leaves.blocks.len()
            }
            Prepared::Projected(_) => {
                // Where in a block is nobody's business: corners are found by number.
                let leaves = self.tree.nodes.iter().filter(|node| node.is_leaf());
                let mut count = 0;
                let mut block = [INVALID_ID; WIDTH];
                for (i, &number) in leaves.flat_map(|leaf| self.tree.leaf_items(*leaf)).enumerate() {
                    block[i % WIDTH] = number;
                    count = i / WIDTH + 1;
                    visit(i / WIDTH, &block);
                }
                count
            }
        }
    }

    /// The corners of one triangle.
    #[must_use]
    pub fn corners_at(&self, number: u32, block: usize, lane: usize) -> [[f32; 3]; 3] {
        match &self.triangles {
            Prepared::Watertight(leaves) => leaves.blocks[block].triangle(lane),
            Prepared::Projected(triangles) => {
                triangles.corners(number).map(|corner| corner.map(|x| x as f32))
            }
        }
    }
}
