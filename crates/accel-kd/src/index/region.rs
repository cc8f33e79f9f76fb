// SPDX-License-Identifier: GPL-3.0-or-later
//! The triangles of a kd-tree that may meet a region.
//! Projected triangles keep no corners: theirs are reconstructed with the precision of the stored form.
//! Tests: `tests/surfaces/crossings.rs`.

use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::RegionFilter;

use super::{KdIndex, Prepared};

impl KdIndex {
    /// Shows the triangles that may meet it.
    pub fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(u32, Primitive)) {
        self.tree.filter_region(region_filter, &mut |leaf| match &self.triangles {
            Prepared::Watertight(leaves) => {
                leaves.blocks[leaves.of(leaf)]
                    .iter()
                    .for_each(|block| block.filter_region(region_filter, visit));
            }
            Prepared::Projected(triangles) => {
                for &number in self.tree.leaf_items(leaf) {
                    let corners = triangles.corners(number).map(|corner| corner.map(|x| x as f32));
                    visit(number, Primitive::Triangle(corners));
                }
            }
        });
    }
}
