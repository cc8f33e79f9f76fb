// SPDX-License-Identifier: GPL-3.0-or-later
//! Grids and subdivision surfaces as quads of a tree: from the numbers of these back to the program's primitives.
//! Source: Embree's manual, for the parameters of grids and of faces. Tests: `tests/c/grids.c`, `tests/c/subdivision.c`.

use std::sync::Arc;

use gnurt_accel::Grid;
use gnurt_subdivision::{Place, Tessellation};

use crate::control::Control;
use crate::ffi_memory::View;

/// One of the program's primitives that are cut, in a tree of quads.
#[derive(Debug)]
pub(crate) enum Cells {
    /// How many cells all grids before have; one more at the end.
    Grids(Vec<u32>),
    Patches(Arc<Patches>),
}

/// A subdivision surface as it was cut.
#[derive(Debug)]
pub(crate) struct Patches {
    pub(crate) control: Arc<Control>,
    pub(crate) cut: Tessellation,
}

/// A row of the program's grids; `None` behind the last.
pub(crate) fn grid_of(grids: &View, i: usize) -> Option<Grid> {
    let [first, stride, size] = grids.get::<u32, 3>(i)?;
    let [a, b, c, d] = size.to_ne_bytes();
    let [width, height] = [[a, b], [c, d]].map(u16::from_ne_bytes);
    Some(Grid { first, stride, width, height })
}

/// All of the program's grids.
pub(crate) fn grids_of(grids: &View) -> Vec<Grid> {
    (0..grids.len()).filter_map(|i| grid_of(grids, i)).collect()
}

/// How many cells all grids before each have, one more at the end; `None` for too many.
pub(crate) fn cells_before(grids: &View) -> Option<Vec<u32>> {
    let mut before = vec![0_u32];
    for i in 0..grids.len() {
        let [columns, rows] = grid_of(grids, i)?.cells();
        before.push(before[i].checked_add(columns.checked_mul(rows)?)?);
    }
    Some(before)
}

/// The vertices of all cells of all grids.
pub(crate) fn quads_of_grids(grids: &View) -> Vec<[u32; 4]> {
    let cells = grids_of(grids).into_iter().flat_map(|grid| {
        let [columns, rows] = grid.cells();
        (0..rows).flat_map(move |row| (0..columns).map(move |column| grid.quad(column, row)))
    });
    cells.collect()
}

/// The grid of a cell, and its column and row there.
pub(crate) fn find(before: &[u32], grids: &View, cell: u32) -> Option<(u32, Grid, [u32; 2])> {
    // Grids are most often of one size.
    let all = before.last().map_or(0, |&all| u64::from(all)).max(1);
    let guess = (u64::from(cell) * grids.len() as u64 / all) as usize;
    let is_there = before.get(guess..guess + 2).is_some_and(|ends| (ends[0]..ends[1]).contains(&cell));
    let i = if is_there { guess } else { before.partition_point(|&before| before <= cell) - 1 };
    let grid = grid_of(grids, i)?;
    let [columns, _] = grid.cells();
    let at = cell - before[i];
    (columns > 0).then(|| (i as u32, grid, [at % columns, at / columns]))
}

/// Parameters of a face that is no quadrangle hold the part, too.
pub(crate) fn encoded(part: u32, corners: usize, [u, v]: [f32; 2]) -> [f32; 2] {
    match corners {
        4 => [u, v],
        _ => [2.0 * (part % 4) as f32 + 0.5 + u, 2.0 * (part / 4) as f32 + 0.5 + v],
    }
}

/// The part of such parameters, and those there.
pub(crate) fn decoded(corners: usize, [u, v]: [f32; 2]) -> (u32, [f64; 2]) {
    let [u, v] = [u, v].map(f64::from);
    if corners == 4 {
        return (0, [u, v]);
    }
    let whole = [u, v].map(|x| (0.5 * x).floor().clamp(0.0, 3.0));
    let part = (4.0 * whole[1] + whole[0]) as u32;
    (part.min(corners as u32 - 1), [u - 2.0 * whole[0] - 0.5, v - 2.0 * whole[1] - 0.5])
}

impl Cells {
    /// The program's primitive and the parameters there, from those of a quad of the tree.
    pub(crate) fn seen(&self, grids: &View, cell: u32, [u, v]: [f32; 2]) -> (u32, [f32; 2]) {
        match self {
            Self::Grids(before) => match find(before, grids, cell) {
                Some((prim_id, grid, [column, row])) => {
                    let [columns, rows] = grid.cells();
                    let at = |i: u32, x: f32, of: u32| (i as f32 + x) / of as f32;
                    (prim_id, [at(column, u, columns), at(row, v, rows)])
                }
                None => (cell, [u, v]),
            },
            Self::Patches(patches) => {
                let Patches { control, cut } = &**patches;
                let (Place { face, part }, [a, b, c, d]) = cut.find(&control.cage, cell);
                let inside = [0, 1].map(|k| match u + v <= 1.0 {
                    true => a[k] + u * (b[k] - a[k]) + v * (d[k] - a[k]),
                    false => c[k] + (1.0 - u) * (d[k] - c[k]) + (1.0 - v) * (b[k] - c[k]),
                });
                let corners = control.cage.faces().range(face as usize).len();
                (control.prim_id(face), encoded(part, corners, inside))
            }
        }
    }
}
