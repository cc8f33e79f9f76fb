// SPDX-License-Identifier: GPL-3.0-or-later
//! Primitives near a point, or in a region, in a grid; and its contents by numbers. Boxes of cells are halved
//! in the descent to one cell. Space: object. Tests: `tests/grids.rs`,
//! `tests/surfaces/{crossings,overlaps,normals}.rs` of `gnurt-accel`.

use gnurt_accel_core::blocks::{TriangleBlock, WIDTH};
use gnurt_accel_core::filter_region::NOTHING;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::{RegionFilter, Rows};
use gnurt_accel_core::{Aabb, INVALID_ID};

use super::index::GridIndex;

/// Cells from one corner to the other, both included.
#[derive(Clone, Copy)]
struct Part {
    low: [u32; 3],
    high: [u32; 3],
}

impl GridIndex {
    /// The region that points of triangles in the cells may be in, up to rounding.
    fn region(&self, part: &Part) -> Aabb {
        let slack = self.slack(0.0);
        let end = |k: usize, cell: u32| self.cells.plane(k, cell);
        Aabb {
            min: [0, 1, 2].map(|k| end(k, part.low[k]).max(self.bounds.min[k]) - slack),
            max: [0, 1, 2].map(|k| end(k, part.high[k] + 1).min(self.bounds.max[k]) + slack),
        }
    }

    /// Calls `leaf` with triangles of cells whose region, and that of all boxes of cells around it, is
    /// `expected`, eight at most at a time; of two halves first the one with the lesser `rank`.
    fn descend(
        &self,
        expected: &mut dyn FnMut(&Aabb) -> bool,
        rank: &dyn Fn(&Aabb) -> f64,
        leaf: &mut dyn FnMut(&TriangleBlock),
    ) {
        let mut waiting = vec![Part { low: [0; 3], high: self.cells.count.map(|count| count - 1) }];
        while let Some(part) = waiting.pop() {
            if !expected(&self.region(&part)) {
                continue;
            }
            let long = |k: usize| part.high[k] - part.low[k];
            let axis = (0..3).fold(0, |most, k| if long(k) > long(most) { k } else { most });
            if long(axis) == 0 {
                for positions in self.items(part.low).chunks(WIDTH) {
                    let mut numbers = [INVALID_ID; WIDTH];
                    numbers[..positions.len()].copy_from_slice(positions);
                    let mut block = TriangleBlock::new(|at| self.triangles[at as usize].corners, &numbers);
                    block.numbers = block.numbers.map(|at| self.triangles[at as usize].number);
                    leaf(&block);
                }
                continue;
            }
            let (mut below, mut above) = (part, part);
            below.high[axis] = part.low[axis] + long(axis) / 2;
            above.low[axis] = below.high[axis] + 1;
            let mut halves = [below, above];
            if rank(&self.region(&below)) < rank(&self.region(&above)) {
                halves.reverse();
            }
            waiting.extend(halves);
        }
    }

    /// Improves `nearest` by the triangles.
    pub fn nearest(&self, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        let reach = std::cell::Cell::new(probe.radius_for(nearest.distance()));
        let far = |region: &Aabb| region.distance(&probe.point);
        self.descend(&mut |region| far(region) <= reach.get(), &far, &mut |block| {
            block.nearest(probe, slot, nearest);
            reach.set(probe.radius_for(nearest.distance()));
        });
    }

    /// Shows the triangles that may meet a region.
    pub fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(u32, Primitive)) {
        let mut expected = |region: &Aabb| {
            let mut rows: Rows = NOTHING;
            for k in 0..3 {
                (rows[2 * k][0], rows[2 * k + 1][0]) = (region.min[k], region.max[k]);
            }
            region_filter.overlap_mask(&rows) & 1 != 0
        };
        self.descend(&mut expected, &|_| 0.0, &mut |block| block.filter_region(region_filter, visit));
    }

    /// Numbers of triangles, eight by eight, and how many eights there are.
    pub fn numbers(&self, visit: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
        for (i, triangles) in self.triangles.chunks(WIDTH).enumerate() {
            let mut numbers = [INVALID_ID; WIDTH];
            numbers.iter_mut().zip(triangles).for_each(|(to, triangle)| *to = triangle.number);
            visit(i, &numbers);
        }
        self.triangles.len().div_ceil(WIDTH)
    }

    /// The corners of one triangle.
    #[must_use]
    pub fn corners_at(&self, block: usize, lane: usize) -> [[f32; 3]; 3] {
        self.triangles[block * WIDTH + lane].corners
    }
}
