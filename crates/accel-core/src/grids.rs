// SPDX-License-Identifier: GPL-3.0-or-later
//! Grids of vertices as geometry. Rows of a grid are Embree's. Space: object. Tests: `patches::tests`.

/// Regular rectangles of vertices: borrowed arrays.
///
/// A cell, between four vertices, is a quad as those of [`Quads`](crate::Quads), and takes about a quarter of its memory.
/// Its vertices 0 and 1 are in one row of its grid. Cells are counted grid by grid, then row by row: a cell's index is its `prim_id`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Grids<'a> {
    /// Vertex positions, object space.
    pub positions: &'a [[f32; 3]],
    /// Where the vertices of each grid are.
    pub grids: &'a [Grid],
}

/// One grid: which of the vertices are its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Grid {
    /// Its first vertex.
    pub first: u32,
    /// From a row's first vertex to that of the next one.
    pub stride: u32,
    /// Vertices of a row. There are no cells where it is below 2.
    pub width: u16,
    /// Rows. There are no cells where it is below 2.
    pub height: u16,
}

impl Grid {
    /// How many cells there are along a row, and how many rows of them.
    #[must_use]
    pub fn cells(&self) -> [u32; 2] {
        let [columns, rows] = [self.width, self.height].map(|vertices| u32::from(vertices).saturating_sub(1));
        if columns == 0 || rows == 0 { [0, 0] } else { [columns, rows] }
    }

    /// The vertices around a cell. Those beyond all numbers are the last number, which no array has.
    #[must_use]
    pub fn quad(&self, column: u32, row: u32) -> [u32; 4] {
        [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[x, y]| self.vertex(column + x, row + y))
    }

    pub(crate) fn vertex(&self, column: u32, row: u32) -> u32 {
        let at = u64::from(self.first) + u64::from(row) * u64::from(self.stride) + u64::from(column);
        u32::try_from(at).unwrap_or(u32::MAX)
    }
}

impl Grids<'_> {
    /// How many cells there are.
    #[must_use]
    pub fn cells(&self) -> usize {
        let cells = |grid: &Grid| grid.cells().iter().map(|&n| n as usize).product::<usize>();
        self.grids.iter().map(cells).sum()
    }
}
