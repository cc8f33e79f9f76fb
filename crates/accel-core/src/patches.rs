// SPDX-License-Identifier: GPL-3.0-or-later
//! Patches of grids: two by two cells over three by three vertices, which are eight triangles.
//! Space: object. Invariant: cells are the quads of [`Quads`](crate::Quads), grid by grid and row by row, with the same faults.
//! Tests: `tests::patches_have_each_half_once`, `tests/grid_meshes.rs` of `gnurt-accel`.

use gnurt_simd::{Simd, f32x8, prelude::*};

use crate::aabb::Aabb;
use crate::bad_primitives::BadPrimitives;
use crate::blocks::BlockRay;
use crate::collect::Collect;
use crate::grids::{Grid, Grids};
use crate::surfaces::check_quad;
use crate::triangle::SingleRay;

/// Halves of cells in a patch.
pub const HALVES: usize = 8;

/// The corners of each half among the nine vertices of a patch: the first halves of all four cells, row by row, then the second ones.
pub const CORNERS: [[usize; 3]; HALVES] =
    [[0, 1, 3], [1, 2, 4], [3, 4, 6], [4, 5, 7], [4, 3, 1], [5, 4, 2], [7, 6, 4], [8, 7, 5]];

/// Up to two by two cells of one grid: those of three by three vertices.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub bounds: Aabb,
    /// Its first vertex.
    pub vertex: u32,
    /// From row to row of vertices.
    pub stride: u32,
    /// Cells in a row of the whole grid.
    pub columns: u16,
    /// By bits: the halves that can be traced.
    pub halves: u8,
}

impl Patch {
    /// The number of a half, where that of the patch is `first`: cells have two, as quads.
    #[inline(always)]
    pub fn number(first: u32, columns: u16, half: usize) -> u32 {
        let right = 2 * (half as u32 & 1);
        let below = 2 * u32::from(columns) * (half as u32 >> 1 & 1);
        first + right + below + (half as u32 >> 2)
    }
}

impl Grids<'_> {
    /// A patch of a grid whose first half has number `first`, of `numbers` in all; its faults are counted.
    fn patch(
        &self,
        grid: &Grid,
        [x, y]: [u32; 2],
        first: u32,
        numbers: u32,
        bad: &mut BadPrimitives,
    ) -> Patch {
        let [columns, rows] = grid.cells();
        let (columns, mut halves, mut bounds) = (columns as u16, 0, Aabb::EMPTY);
        for cell in 0..4 {
            let [column, row] = [x + (cell & 1), y + (cell >> 1)];
            let last = Patch::number(first, columns, cell as usize + 4);
            if column >= u32::from(columns) || row >= rows || last >= numbers {
                continue;
            }
            let quad = grid.quad(column, row);
            for (which, triangle) in (0..).zip(check_quad(bad, self.positions, &quad)) {
                if let Some(triangle) = triangle {
                    halves |= 1 << (cell + 4 * which);
                    bounds = bounds.union(&Aabb::around(&triangle));
                }
            }
        }
        Patch { bounds, vertex: grid.vertex(x, y), stride: grid.stride, columns, halves }
    }

    /// Visits all patches that can be traced with the numbers of their first halves, below `numbers`. Returns the number of halves.
    pub fn patches(&self, numbers: u32, bad: &mut BadPrimitives, visit: &mut dyn FnMut(u32, Patch)) -> u64 {
        let (mut before, mut halves) = (0u64, 0);
        for grid in self.grids {
            let [columns, rows] = grid.cells();
            for y in (0..rows).step_by(2) {
                for x in (0..columns).step_by(2) {
                    let first = before + 2 * (u64::from(y) * u64::from(columns) + u64::from(x));
                    if first >= u64::from(numbers) {
                        break;
                    }
                    let patch = self.patch(grid, [x, y], first as u32, numbers, bad);
                    if patch.halves != 0 {
                        halves += u64::from(patch.halves.count_ones());
                        visit(first as u32, patch);
                    }
                }
            }
            before += 2 * u64::from(columns) * u64::from(rows);
        }
        halves
    }
}

/// Floats of a row of three vertices, and others behind them.
pub type Row = [f32; 16];

/// Owned vertices of grids, and a few more, so that each row can be read whole.
#[derive(Clone, Debug)]
pub struct OwnedVertices(Vec<[f32; 3]>);

/// Vertices behind the last.
const PAD: usize = 5;

impl OwnedVertices {
    /// Copies vertices.
    pub fn new(positions: &[[f32; 3]]) -> Self {
        let mut all = Vec::with_capacity(positions.len() + PAD);
        all.extend_from_slice(positions);
        all.extend([[0.0; 3]; PAD]);
        Self(all)
    }

    /// The vertices that were copied.
    #[must_use]
    pub fn given(&self) -> &[[f32; 3]] {
        &self.0[..self.0.len() - PAD]
    }

    /// Bytes of it.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.0[..])
    }

    /// The rows of a patch; zeros where there is none, of which no half is made.
    #[inline(always)]
    pub fn rows(&self, vertex: u32, stride: u32) -> [&Row; 3] {
        const NONE: &Row = &[0.0; 16];
        let floats = self.0.as_flattened();
        let row = |y: usize| {
            let at = (vertex as usize).wrapping_add(y.wrapping_mul(stride as usize)).wrapping_mul(3);
            floats.get(at..).and_then(|row| row.first_chunk()).unwrap_or(NONE)
        };
        [row(0), row(1), row(2)]
    }

    /// Whether there are the vertices of these halves, which can be traced.
    pub fn holds(&self, vertex: u32, stride: u32, halves: u8) -> bool {
        (0..HALVES).filter(|half| halves >> half & 1 != 0).all(|half| {
            CORNERS[half].iter().all(|&corner| {
                let at = u64::from(vertex) + (corner / 3) as u64 * u64::from(stride) + (corner % 3) as u64;
                let point = usize::try_from(at).ok().and_then(|at| self.given().get(at));
                point.is_some_and(|p| p.iter().all(|x| x.abs() <= crate::LARGEST_COORDINATE))
            })
        })
    }
}

/// Offers the hits of a ray with the halves of a patch: as `BlockRay::meet`.
#[inline(always)]
pub fn meet_patch<S: Simd, C: Collect>(
    simd: S,
    [a, b, c]: [&Row; 3],
    halves: u8,
    ray: &BlockRay<S>,
    collect: &mut C,
    offer: impl FnOnce(u64, &[[f32; HALVES]; 3], &mut C),
    doubt: impl FnOnce([u64; 3], &[[f32; HALVES]; 3], ([usize; 3], SingleRay, f32), &mut C),
) {
    let mut nine = [[0.0; 16]; 3];
    for (k, along) in nine.iter_mut().enumerate() {
        *along = [
            a[k],
            a[3 + k],
            a[6 + k],
            b[k],
            b[3 + k],
            b[6 + k],
            c[k],
            c[3 + k],
            c[6 + k],
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
        ];
    }
    let mut corners = [ray.sheared.org; 3];
    for (which, corner) in corners.iter_mut().enumerate() {
        for (lanes, &axis) in corner.iter_mut().zip(&ray.axes) {
            let (from, mut own) = (&nine[axis], [0.0; HALVES]);
            for (x, half) in own.iter_mut().zip(&CORNERS) {
                *x = from[half[which]];
            }
            *lanes = f32x8::from_slice(simd, &own) - *lanes;
        }
    }
    ray.meet(simd, corners, u64::from(halves), collect, offer, doubt);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfaces::half;

    #[test]
    fn patches_have_each_half_once() {
        let grids = [
            Grid { first: 3, stride: 7, width: 6, height: 5 },
            Grid { first: 0, stride: 9, width: 1, height: 4 },
            Grid { first: 40, stride: 3, width: 3, height: 2 },
        ];
        let positions: Vec<[f32; 3]> =
            (0..60).map(|i| [i as f32, (i * i % 17) as f32, (i % 5) as f32]).collect();
        let grids = Grids { positions: &positions, grids: &grids };
        let quads: Vec<[u32; 4]> = grids
            .grids
            .iter()
            .flat_map(|grid| {
                let [columns, rows] = grid.cells();
                (0..rows).flat_map(move |y| (0..columns).map(move |x| grid.quad(x, y)))
            })
            .collect();
        assert_eq!((grids.cells(), quads.len()), (22, 22), "four by five, none, and two");
        let vertices = OwnedVertices::new(&positions);
        let mut seen = vec![0; 44];
        let halves = grids.patches(44, &mut BadPrimitives::default(), &mut |first, patch| {
            assert!(vertices.holds(patch.vertex, patch.stride, patch.halves), "all are there");
            let rows = vertices.rows(patch.vertex, patch.stride);
            let nine: [_; 9] = std::array::from_fn(|i| [0, 1, 2].map(|k| rows[i / 3][3 * (i % 3) + k]));
            for half_at in (0..HALVES).filter(|half| patch.halves >> half & 1 != 0) {
                let number = Patch::number(first, patch.columns, half_at);
                seen[number as usize] += 1;
                let expected = half(&quads[number as usize / 2], number & 1).map(|i| positions[i as usize]);
                assert_eq!(CORNERS[half_at].map(|corner| nine[corner]), expected, "corners of {number}");
            }
        });
        assert_eq!((halves, seen), (44, vec![1; 44]), "each half is in one patch");
    }
}
