// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile of rays through a grid: slice by slice along the axis on which its rays move most, in each slice the cells that the tile's frustum
//! meets there. Source: [WIK*06] section 4: the frustum's box in each slice, early exit, mailboxes, triangles against the frustum before rays.
//! Differs: the frustum is made of intervals of origins and slopes, so that rays need not start in one point.
//! Triangles of a slice are tested in blocks of eight, against the whole tile and each sixteen rays of it, as
//! in `tiles.rs`.
//! Invariant: a cell that one of the rays may meet before its hit is visited. Tests: `tests/grids.rs` of `gnurt-accel`.

use std::cell::Cell;

use gnurt_accel_core::beam::Ranges;
use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::blocks::{TriangleBlock, WIDTH};
use gnurt_accel_core::chunks::Chunks;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::float::{least, most};
use gnurt_accel_core::tile::LANES;
use gnurt_accel_core::tile_test::TileTest;
use gnurt_accel_core::traversal::TileTraversal;
use gnurt_accel_core::triangle::axes_from;
use gnurt_simd::Simd;

use super::index::GridIndex;
use crate::mailbox::Mailbox;

/// Tiles may be this wide at the grid's other end, as a part of its size; rays of wider ones go one by one.
const FARTHEST_SPREAD: f32 = 1.0 / 16.0;

/// Rays of one direction class as intervals.
struct Frustum {
    org: [[f32; 2]; 3],
    /// Change along x and y of the sheared space per step along z.
    slope: [[f32; 2]; 2],
    axes: [usize; 3],
    back: bool,
    t_near: f32,
    slack: f32,
}

/// Cells of one slice.
struct Window {
    /// Least and greatest numbers along the two other axes.
    cells: [[u32; 2]; 2],
}

/// The relation of a frustum to a slice.
enum Passage {
    /// It has not reached the grid yet, or is outside of it.
    Nothing,
    /// It ends before.
    Over,
    Cells(Window),
}

impl Frustum {
    fn new(ranges: &Ranges, direction_class: DirectionClass, grid: &GridIndex) -> Self {
        let org = ranges.org();
        let away = org.iter().flatten().fold(0.0, |away, x| most(away, x.abs()));
        let axes = axes_from(direction_class.longest_axis);
        let back = direction_class.backwards[direction_class.longest_axis];
        Self { org, slope: ranges.slope(), axes, back, t_near: ranges.t_near, slack: grid.slack(away) }
    }

    /// The first slice in which a ray may start, and the last one.
    fn run(&self, grid: &GridIndex) -> [u32; 2] {
        let [_, _, z] = self.axes;
        let [low, high] = self.org[z];
        let of = |at: f32| grid.cells.of(z, at);
        let last = grid.cells.count[z] - 1;
        if self.back {
            [of(high - self.t_near + self.slack), 0]
        } else {
            [of(low + self.t_near - self.slack), last]
        }
    }

    /// Where rays that go no farther than `farthest` steps are in a slice.
    #[inline(always)]
    fn pass(&self, grid: &GridIndex, slice: u32, farthest: f32) -> Passage {
        let [x, y, z] = self.axes;
        let planes = [grid.cells.plane(z, slice) - self.slack, grid.cells.plane(z, slice + 1) + self.slack];
        let [low, high] = [planes[0] - self.org[z][1], planes[1] - self.org[z][0]];
        let [enter, leave] = if self.back { [-high, -low] } else { [low, high] };
        if enter > farthest {
            return Passage::Over;
        }
        let (enter, leave) = (most(enter, self.t_near), least(leave, farthest));
        if enter > leave {
            return Passage::Nothing;
        }
        let [low, high] = if self.back { [-leave, -enter] } else { [enter, leave] };
        let mut window = Window { cells: [[0; 2]; 2] };
        for (i, k) in [x, y].into_iter().enumerate() {
            let [flat, steep] = self.slope[i];
            let (a, b, c, d) = (flat * low, flat * high, steep * low, steep * high);
            let least = self.org[k][0] + least(least(a, b), least(c, d)) - self.slack;
            let most = self.org[k][1] + most(most(a, b), most(c, d)) + self.slack;
            if least > grid.bounds.max[k] || most < grid.bounds.min[k] {
                return Passage::Nothing;
            }
            window.cells[i] = [grid.cells.of(k, least), grid.cells.of(k, most)];
        }
        Passage::Cells(window)
    }
}

impl GridIndex {
    /// Improves the hits of a tile's first rays, all of them active and of one direction class.
    #[inline(always)]
    pub(crate) fn search_tile<S: Simd>(
        &self,
        simd: S,
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
    ) {
        let TileTraversal { rays, kind, slot, .. } = *traversal;
        let count = TILE - traversal.active.leading_zeros() as usize;
        let [x, y, z] = self.bounds.extent();
        let size = x.max(y).max(z) as f32;
        let ranges = Cell::new(Ranges::NONE);
        let chunks =
            Chunks::new(simd, rays, count, direction_class, self.greatest, traversal.nearest, |whole| {
                ranges.set(*whole);
                whole.spread(size) > FARTHEST_SPREAD * size
            });
        let Some(mut chunks) = chunks else {
            return traversal.one_by_one_outlined(
                simd,
                #[inline(always)]
                |traversal| self.search(simd, traversal),
            );
        };
        let test = TileTest { simd, rays, kind, slot, direction_class };
        let frustum = Frustum::new(&ranges.get(), direction_class, self);
        let [fx, fy, fz] = frustum.axes;
        let mut mailbox = Mailbox::<256>::EMPTY;
        let (mut positions, mut block) = (Vec::with_capacity(256), TriangleBlock::ZERO);
        let (mut visited, mut tested) = (0u64, 0u64);
        let [mut slice, last] = frustum.run(self);
        let mut cell = [0; 3];
        loop {
            match frustum.pass(self, slice, chunks.farthest) {
                Passage::Over => break,
                Passage::Nothing => {}
                Passage::Cells(Window { cells: [[x0, x1], [y0, y1]] }) => {
                    positions.clear();
                    cell[fz] = slice;
                    for j in y0..=y1 {
                        cell[fy] = j;
                        for i in x0..=x1 {
                            cell[fx] = i;
                            visited += 1;
                            let items = self.items(cell).iter().copied();
                            positions.extend(items.filter(|&position| !mailbox.has(position)));
                        }
                    }
                    for eight in positions.chunks(WIDTH) {
                        self.put(eight, &mut block);
                        chunks.block(
                            simd,
                            &block,
                            traversal.active,
                            traversal.nearest,
                            #[inline(always)]
                            |candidate, slopes, nearest| {
                                tested += LANES as u64;
                                test.meet(&block, &candidate, slopes, nearest)
                            },
                        );
                    }
                }
            }
            if slice == last {
                break;
            }
            slice = if frustum.back { slice - 1 } else { slice + 1 };
        }
        traversal.counters.nodes += visited * count as u64;
        traversal.counters.triangles += tested;
    }
}
