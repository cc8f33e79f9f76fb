// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's triangles in a grid. Source: [WIK*06]. Space: object. Triangles are stored once, in the
//! caller's order; cells refer to them. Large triangles are in many cells: if references would exceed
//! [`BuildOptions::reference_budget`], cells are larger.
//! Tests: `tests/grids.rs` of `gnurt-accel`.

use gnurt_accel_core::blocks::TriangleBlock;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::slab::SLACK;
use gnurt_accel_core::threads::extend;
use gnurt_accel_core::valid_triangles::ValidTriangles;
use gnurt_accel_core::{Aabb, BuildError, BuildOptions, Threads, TreeStats};

use super::build::{Slice, slices};
use super::cells::{Cells, Span};

/// Cells for each triangle: with more of them rays pass more cells than they save tests, eight of which are one.
const DENSITY: f64 = 1.0;

/// A triangle and its number in the object.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(super) struct Triangle {
    pub(super) corners: [[f32; 3]; 3],
    pub(super) number: u32,
}

/// Cells and triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct GridIndex {
    pub(super) cells: Cells,
    /// Along the axis `along`, and there by the next axis and the next but one.
    slices: Vec<Slice>,
    along: usize,
    pub(super) triangles: Vec<Triangle>,
    pub(super) bounds: Aabb,
    /// The greatest coordinate.
    pub(super) greatest: f32,
    stats: TreeStats,
}

impl GridIndex {
    /// Builds over the good triangles, one or more.
    ///
    /// # Errors
    /// That `watch` stopped it.
    pub fn build(
        valid_triangles: &ValidTriangles,
        options: &BuildOptions,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let (count, bounds) = (valid_triangles.good.len(), valid_triangles.bounds);
        watch.start(3);
        let passing = count * size_of::<Span>();
        watch.take(count * size_of::<Triangle>() + passing);
        watch.result()?;
        let mut triangles = Vec::with_capacity(count);
        threads.run(|parallel| {
            extend(parallel, &mut triangles, count, |i| {
                let number = valid_triangles.good[i];
                Triangle { corners: valid_triangles.corners(number), number }
            });
        });
        watch.advance(1);

        let most = (f64::from(options.reference_budget).max(1.0) * count as f64).min(f64::from(u32::MAX));
        let (mut expected, mut spans) = (DENSITY * count as f64, Vec::with_capacity(count));
        let (cells, references) = loop {
            watch.result()?;
            let cells = Cells::new(&bounds, expected);
            spans.clear();
            threads.run(|parallel| {
                extend(parallel, &mut spans, count, |i| cells.span(&triangles[i].corners));
            });
            let references = spans.iter().map(Span::cells).sum::<u64>();
            if references as f64 <= most || cells.total() == 1 {
                break (cells, references);
            }
            expected = expected.min(cells.total() as f64) * (most / references as f64).clamp(0.05, 0.5);
        };
        let lists = 4 * (cells.total() + references as usize);
        watch.take(lists);
        watch.result()?;
        let along = cells.longest();
        let slices = slices(&cells, along, &spans, threads, watch)?;
        drop(spans);
        watch.give(passing);
        watch.advance(1);

        let empty = |slice: &Slice| slice.starts.windows(2).filter(|two| two[0] == two[1]).count() as u64;
        let total = cells.total() as u64;
        let tests = references as f64 * f64::from(options.triangle_cost);
        let starts: usize = slices.iter().map(|slice| 4 * slice.starts.len()).sum();
        let stats = TreeStats {
            primitives: count as u64,
            nodes: total,
            leaves: total,
            empty_leaves: slices.iter().map(empty).sum(),
            references,
            depth: 0,
            sah_cost: cells.share(&bounds) * (total as f64 + tests),
            tree_bytes: (starts + slices.len() * size_of::<Slice>()) as u64 + 4 * references,
            primitive_bytes: (count * size_of::<Triangle>()) as u64,
        };
        Ok(Self { cells, slices, along, triangles, bounds, greatest: bounds.greatest(), stats })
    }

    /// Box around all triangles.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Size and shape; cells are nodes and leaves.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.stats
    }

    /// Indices of a cell's triangles.
    #[inline(always)]
    pub(super) fn items(&self, cell: [u32; 3]) -> &[u32] {
        let [x, y] = [(self.along + 1) % 3, (self.along + 2) % 3];
        let Slice { starts, items } = &self.slices[cell[self.along] as usize];
        let at = cell[y] as usize * self.cells.count[x] as usize + cell[x] as usize;
        &items[starts[at] as usize..starts[at + 1] as usize]
    }

    /// Makes a block of triangles, eight at most.
    #[inline(always)]
    pub(super) fn put(&self, positions: &[u32], block: &mut TriangleBlock) {
        let at = |position: u32| &self.triangles[position as usize];
        if let Some((&first, others)) = positions.split_first() {
            block.put_everywhere(&at(first).corners, at(first).number);
            for (lane, &position) in others.iter().enumerate() {
                block.put(lane + 1, &at(position).corners, at(position).number);
            }
        }
    }

    /// By how much a point may be off that rays which start `away` from the origin are found to hit, the planes between cells among it.
    #[inline(always)]
    pub(super) fn slack(&self, away: f32) -> f32 {
        // Twice the value of boxes, which are not rounded.
        SLACK * (4.0 * self.greatest + away)
    }
}
