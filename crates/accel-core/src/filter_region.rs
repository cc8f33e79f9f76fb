// SPDX-License-Identifier: GPL-3.0-or-later
//! Those of eight triangles that may meet a region, by boxes of their own. Space: object.
//! Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/overlaps.rs` of `gnurt-accel`.

use crate::bits::each;
use crate::blocks::{TriangleBlock, WIDTH};
use crate::primitive::Primitive;
use crate::region::{RegionFilter, Rows};

/// Boxes that nothing is in.
pub const NOTHING: Rows = {
    let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
    [low, high, low, high, low, high]
};

/// Shows those of eight triangles that may meet it.
pub fn filter_triangles(
    corners: &[[[f32; WIDTH]; 3]; 3],
    numbers: &[u32; WIDTH],
    region_filter: &RegionFilter,
    visit: &mut dyn FnMut(u32, Primitive),
) {
    let [a, b, c] = corners;
    let mut rows = NOTHING;
    for k in 0..3 {
        for i in 0..WIDTH {
            rows[2 * k][i] = a[k][i].min(b[k][i]).min(c[k][i]);
            rows[2 * k + 1][i] = a[k][i].max(b[k][i]).max(c[k][i]);
        }
    }
    each(u64::from(region_filter.overlap_mask(&rows)), |i| {
        // Spare slots repeat the first triangle.
        if i == 0 || numbers[i] != numbers[0] {
            let triangle = [a, b, c].map(|corner| [corner[0][i], corner[1][i], corner[2][i]]);
            visit(numbers[i], Primitive::Triangle(triangle));
        }
    });
}

impl TriangleBlock {
    /// Shows those triangles that may meet it.
    pub fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(u32, Primitive)) {
        filter_triangles(&self.corners, &self.numbers, region_filter, visit);
    }

    /// The corners of one triangle.
    #[must_use]
    pub fn triangle(&self, lane: usize) -> [[f32; 3]; 3] {
        self.corners_of(lane, [0, 1, 2])
    }
}
