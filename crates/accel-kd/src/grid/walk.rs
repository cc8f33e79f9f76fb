// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray through a grid, cell by cell, nearest first: a 3D-DDA of intervals.
//! Source: [AW87] for the traversal; intervals are original, as in the kd-tree's `slab.rs`. Where a ray
//! passes within rounding of a plane it visits the cells on both sides: for each slice of cells it has an
//! interval of distances, within that for each row, and so for each cell. Without rounding these are the
//! cells of the classic traversal, in its order.
//! Invariant: every triangle that the test can hit is in a visited cell. Tests: `tests/grids.rs` of
//! `gnurt-accel`.

use gnurt_accel_core::Ray;
use gnurt_accel_core::blocks::{BlockRay, TriangleBlock, WIDTH};
use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::float::{least, most};
use gnurt_accel_core::slab::Slabs;
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::triangle::{ShearedRay, axes_from};
use gnurt_simd::Simd;

use super::index::{GridIndex, Triangle};
use crate::mailbox::Mailbox;

/// A ray prepared for cells.
struct CellRay<'a> {
    grid: &'a GridIndex,
    org: [f32; 3],
    dir: [f32; 3],
    slabs: Slabs<f32>,
    slack: f32,
    back: [bool; 3],
    axes: [usize; 3],
}

/// Cells in a row, from the first to the last one, both included.
#[derive(Clone, Copy)]
struct Run {
    first: u32,
    last: u32,
}

impl<'a> CellRay<'a> {
    /// The ray is valid and regular.
    #[inline(always)]
    fn new(grid: &'a GridIndex, ray: &Ray) -> Self {
        let [x, y, z] = ray.org.map(f32::abs);
        Self {
            grid,
            org: ray.org,
            dir: ray.dir,
            // Planes between cells are rounded, those of boxes are not.
            slabs: Slabs::new(ray.org, ray.dir, 2.0 * grid.greatest, |x| x),
            slack: grid.slack(most(x, most(y, z))),
            back: ray.dir.map(f32::is_sign_negative),
            axes: axes_from(ray.longest_axis()),
        }
    }

    /// The part of `[t_min, t_max]` in which it may be between two planes.
    #[inline(always)]
    fn span(&self, axis: usize, [low, high]: [f32; 2], [t_min, t_max]: [f32; 2]) -> [f32; 2] {
        let Slabs { inv, near, far } = &self.slabs;
        let [first, last] = if self.back[axis] { [high, low] } else { [low, high] };
        [most(t_min, first * inv[axis] - near[axis]), least(t_max, last * inv[axis] - far[axis])]
    }

    /// The part in which it may be in cells of a number.
    #[inline(always)]
    fn within(&self, axis: usize, cell: u32, interval: [f32; 2]) -> [f32; 2] {
        let cells = &self.grid.cells;
        self.span(axis, [cells.plane(axis, cell), cells.plane(axis, cell + 1)], interval)
    }

    /// The cells that it may be in meanwhile.
    #[inline(always)]
    fn run(&self, axis: usize, [t_min, t_max]: [f32; 2]) -> Run {
        let at = |t: f32| self.org[axis] + t * self.dir[axis];
        let (cells, back) = (&self.grid.cells, self.back[axis]);
        let (enter, leave) = (at(t_min), at(t_max));
        let [low, high] = if back { [leave, enter] } else { [enter, leave] };
        let (low, high) = (cells.of(axis, low - self.slack), cells.of(axis, high + self.slack));
        if back { Run { first: high, last: low } } else { Run { first: low, last: high } }
    }

    /// From `t_min` to `t_max`: calls `visit` with the cells that it may meet, which answers with the new reach. Returns how many.
    #[inline(always)]
    fn walk(&self, interval: [f32; 2], mut visit: impl FnMut([u32; 3]) -> f32) -> u64 {
        let [x, y, z] = self.axes;
        let bounds = &self.grid.bounds;
        let mut whole = interval;
        for k in 0..3 {
            whole = self.span(k, [bounds.min[k], bounds.max[k]], whole);
        }
        if whole[0] > whole[1] {
            return 0;
        }
        let (mut cell, mut visited, mut reach) = ([0; 3], 0, whole[1]);
        for k in self.run(z, whole) {
            cell[z] = k;
            let in_slice = self.within(z, k, whole);
            if in_slice[0] > reach {
                break;
            }
            if in_slice[0] > in_slice[1] {
                continue;
            }
            let rows = self.run(y, in_slice);
            for j in rows {
                cell[y] = j;
                let in_row = if rows.is_one() { in_slice } else { self.within(y, j, in_slice) };
                if in_row[0] > least(in_row[1], reach) {
                    continue;
                }
                let row = self.run(x, in_row);
                for i in row {
                    cell[x] = i;
                    let in_cell = if row.is_one() { in_row } else { self.within(x, i, in_row) };
                    if in_cell[0] <= least(in_cell[1], reach) {
                        visited += 1;
                        reach = visit(cell);
                    }
                }
            }
        }
        visited
    }
}

impl Run {
    #[inline(always)]
    fn is_one(self) -> bool {
        self.first == self.last
    }
}

impl IntoIterator for Run {
    type Item = u32;
    type IntoIter = Steps;

    #[inline(always)]
    fn into_iter(self) -> Steps {
        let back = self.first > self.last;
        Steps { next: self.first, left: self.first.abs_diff(self.last) + 1, back }
    }
}

/// The cells of a [`Run`].
struct Steps {
    next: u32,
    left: u32,
    back: bool,
}

impl Iterator for Steps {
    type Item = u32;

    #[inline(always)]
    fn next(&mut self) -> Option<u32> {
        self.left = self.left.checked_sub(1)?;
        let now = self.next;
        self.next = if self.back { now.wrapping_sub(1) } else { now + 1 };
        Some(now)
    }
}

/// This number of triangles of a cell are tested one after the other: collecting them into a block takes
/// longer.
const FEW: usize = 2;

impl GridIndex {
    /// Offers the ray's hits; it is valid and regular.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        let RayTraversal { ray, slot, .. } = *traversal;
        let (lanes, single, t_near) = (BlockRay::new(simd, ray), ShearedRay::new(ray), ray.t_near);
        let (mut mailbox, mut block) = (Mailbox::<64>::EMPTY, TriangleBlock::ZERO);
        let mut tested = 0;
        let visited = CellRay::new(self, ray).walk(
            [t_near, traversal.reach()],
            #[inline(always)]
            |cell| {
                for positions in self.items(cell).chunks(WIDTH) {
                    let (mut unknown, mut count) = ([0; WIDTH], 0);
                    for &position in positions {
                        unknown[count & (WIDTH - 1)] = position;
                        count += usize::from(!mailbox.has(position));
                    }
                    tested += count as u64;
                    if const { S::LANES == 1 } || count <= FEW {
                        for &position in &unknown[..count] {
                            let Triangle { corners, number } = &self.triangles[position as usize];
                            if let Some(hit) =
                                single.meet(corners, traversal.needs_position(), t_near, traversal.reach())
                            {
                                traversal.offer(hit, *number, slot);
                            }
                        }
                    } else {
                        self.put(&unknown[..count], &mut block);
                        block.meet(simd, &lanes, slot, traversal);
                    }
                }
                traversal.reach()
            },
        );
        traversal.counters.nodes += visited;
        traversal.counters.triangles += tested;
    }
}
