// SPDX-License-Identifier: GPL-3.0-or-later
//! A surface cut to quadrangles by levels of its edges, without cracks.
//! An edge has one level, the greatest of its faces', and its points are vertices of both. A face has as many rows as the finer
//! of two opposite edges; at the coarser one, vertices of the last row fall together. A face that is no quadrangle has a part at
//! each corner; its edges have even levels, so that parts begin at vertices.
//! Cost: memory for shared vertices and patches, not for cells. Tests: `tests/tessellation.rs`.

use super::cage::{Cage, Place};

/// The greatest level of an edge.
pub const MOST_LEVEL: u32 = 4096;

/// A quadrangle of the surface that is cut evenly.
#[derive(Clone, Copy, Debug)]
struct Patch {
    place: Place,
    /// Cells along u and v.
    cells: [u32; 2],
    /// Cells of all patches before.
    before: u32,
    /// Its first vertex that no other patch has.
    inside: u32,
}

/// How a surface is cut.
#[derive(Debug)]
pub struct Tessellation {
    patches: Vec<Patch>,
    /// By edge: cells along it, and its first vertex between the ends.
    edges: Vec<[u32; 2]>,
    /// By face that is no quadrangle, in order: the face, cells from the middle of an edge to that of the face, the first of the
    /// vertices there: the middle, then those on the way from each edge.
    middles: Vec<[u32; 3]>,
    /// By shared vertex: the patch that it is computed with.
    owners: Vec<u32>,
    vertices: u32,
    cells: u32,
}

/// A surface that would have too many cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the surface would be cut to more than {0} quadrangles")]
pub struct TooManyCells(pub u64);

/// The vertices of a side, from one end to the other.
type Way = Vec<u32>;

impl Tessellation {
    /// Cuts the shown faces; `level` is that of the edge from a corner to the next one, by the place of the corner.
    ///
    /// # Errors
    /// [`TooManyCells`] above `most`.
    pub fn new(cage: &Cage, level: impl Fn(usize) -> f32, most: u64) -> Result<Self, TooManyCells> {
        let faces = cage.faces();
        let mut edges = vec![[1, 0]; cage.edge_count()];
        let mut is_halved = vec![false; edges.len()];
        let shown = || (0..faces.len()).filter(|&face| !cage.is_hidden(face));
        for face in shown() {
            for corner in faces.range(face) {
                let edge = cage.edges()[corner] as usize;
                // NaN is one.
                let cells = level(corner).ceil().max(1.0).min(MOST_LEVEL as f32) as u32;
                edges[edge][0] = edges[edge][0].max(cells);
                is_halved[edge] |= faces.range(face).len() != 4;
            }
        }
        let mut vertices = faces.vertices() as u64;
        for ([cells, first], is_halved) in edges.iter_mut().zip(is_halved) {
            *cells = if is_halved { cells.next_multiple_of(2) } else { *cells };
            *first = vertices.min(u64::from(u32::MAX)) as u32;
            vertices += u64::from(*cells - 1);
        }
        let mut middles = Vec::new();
        for face in shown().filter(|&face| faces.range(face).len() != 4) {
            let halves = cage.edges()[faces.range(face)].iter().map(|&edge| edges[edge as usize][0] / 2);
            let cells = halves.max().unwrap_or(1);
            middles.push([face as u32, cells, vertices.min(u64::from(u32::MAX)) as u32]);
            vertices += 1 + u64::from(cells - 1) * faces.range(face).len() as u64;
        }
        let shared = vertices;
        let (patches, owners) = (Vec::new(), Vec::new());
        let mut cut = Self { patches, edges, middles, owners, vertices: 0, cells: 0 };
        let mut before = 0;
        for face in shown() {
            let corners = faces.range(face).len();
            for part in 0..if corners == 4 { 1 } else { corners as u32 } {
                let place = Place { face: face as u32, part };
                let sides = [0, 1, 2, 3].map(|side| cut.cells_of(cage, place, side));
                let cells = [sides[0].max(sides[2]), sides[1].max(sides[3])];
                let inside = vertices.min(u64::from(u32::MAX)) as u32;
                cut.patches.push(Patch { place, cells, before: before as u32, inside });
                vertices += u64::from(cells[0] - 1) * u64::from(cells[1] - 1);
                before += u64::from(cells[0]) * u64::from(cells[1]);
                if before > most.min(u64::from(u32::MAX)) || vertices > u64::from(u32::MAX) {
                    return Err(TooManyCells(most));
                }
            }
        }
        cut.vertices = vertices as u32;
        cut.cells = before as u32;
        cut.owners = vec![u32::MAX; shared as usize];
        for patch in 0..cut.patches.len() {
            for vertex in cut.ways(cage, patch).concat() {
                let owner = &mut cut.owners[vertex as usize];
                *owner = (*owner).min(patch as u32);
            }
        }
        Ok(cut)
    }

    /// How many vertices there are; some belong to no cell.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.vertices as usize
    }

    /// How many cells there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cells as usize
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.cells == 0
    }

    /// How many patches there are: faces, or parts of faces.
    #[must_use]
    pub fn patches(&self) -> usize {
        self.patches.len()
    }

    /// Where a patch is.
    #[must_use]
    pub fn place(&self, patch: usize) -> Place {
        self.patches[patch].place
    }

    /// The vertices that are computed with a patch, and where each is on it.
    #[must_use]
    pub fn points(&self, cage: &Cage, patch: usize) -> Vec<(u32, [f64; 2])> {
        let Patch { cells: [columns, rows], inside, .. } = self.patches[patch];
        let mut points = Vec::new();
        for (side, way) in self.ways(cage, patch).iter().enumerate() {
            let cells = way.len() as f64 - 1.0;
            for (i, &vertex) in way.iter().enumerate().take(way.len() - 1) {
                if self.owners[vertex as usize] == patch as u32 {
                    let t = i as f64 / cells;
                    points.push((vertex, [[t, 0.0], [1.0, t], [1.0 - t, 1.0], [0.0, 1.0 - t]][side]));
                }
            }
        }
        let at = |i: u32, cells: u32| f64::from(i) / f64::from(cells);
        let all = (1..rows).flat_map(|row| (1..columns).map(move |column| (row, column)));
        points.extend(
            all.zip(inside..).map(|((row, column), vertex)| (vertex, [at(column, columns), at(row, rows)])),
        );
        // A patch that meets itself has some vertices twice.
        points.sort_by_key(|&(vertex, _)| vertex);
        points.dedup_by_key(|&mut (vertex, _)| vertex);
        points
    }

    /// The vertices of all cells, around each, the first at the least parameters.
    #[must_use]
    pub fn cells(&self, cage: &Cage) -> Vec<[u32; 4]> {
        let mut cells = Vec::with_capacity(self.len());
        for (i, patch) in self.patches.iter().enumerate() {
            let ways = self.ways(cage, i);
            let [columns, rows] = patch.cells;
            let vertex = |column: u32, row: u32| match (column, row) {
                _ if row == 0 => ways[0][nearest(column, columns, &ways[0])],
                _ if row == rows => ways[2][ways[2].len() - 1 - nearest(column, columns, &ways[2])],
                _ if column == columns => ways[1][nearest(row, rows, &ways[1])],
                _ if column == 0 => ways[3][ways[3].len() - 1 - nearest(row, rows, &ways[3])],
                _ => patch.inside + (row - 1) * (columns - 1) + column - 1,
            };
            for row in 0..rows {
                for column in 0..columns {
                    let around = [[0, 0], [1, 0], [1, 1], [0, 1]];
                    cells.push(around.map(|[x, y]| vertex(column + x, row + y)));
                }
            }
        }
        cells
    }

    /// The place of a cell, and the parameters of its vertices there.
    #[must_use]
    pub fn find(&self, cage: &Cage, cell: u32) -> (Place, [[f32; 2]; 4]) {
        let i = self.patches.partition_point(|patch| patch.before <= cell) - 1;
        let Patch { place, cells: [columns, rows], before, .. } = self.patches[i];
        let (column, row) = ((cell - before) % columns, (cell - before) / columns);
        let along = |i: u32, of: u32, side: usize, is_side: bool| {
            let cells = if is_side { self.cells_of(cage, place, side) } else { of };
            rounded(i, of, cells) as f32 / cells as f32
        };
        let at = |[x, y]: [u32; 2]| {
            let (column, row) = (column + x, row + y);
            let (is_low, is_high) = (row == 0, row == rows);
            let (is_left, is_right) = (column == 0, column == columns);
            [
                along(column, columns, if is_low { 0 } else { 2 }, is_low || is_high),
                along(row, rows, if is_right { 1 } else { 3 }, is_left || is_right),
            ]
        };
        (place, [[0, 0], [1, 0], [1, 1], [0, 1]].map(at))
    }

    /// Cells along a side of a place.
    fn cells_of(&self, cage: &Cage, place: Place, side: usize) -> u32 {
        let range = cage.faces().range(place.face as usize);
        let (n, part) = (range.len(), place.part as usize);
        let edge = |corner: usize| self.edges[cage.edges()[range.start + corner % n] as usize][0];
        match side {
            _ if n == 4 => edge(side),
            0 => edge(part) / 2,
            3 => edge(part + n - 1) / 2,
            _ => self.middle(place.face)[1],
        }
    }

    fn middle(&self, face: u32) -> [u32; 3] {
        let at = self.middles.partition_point(|middle| middle[0] < face);
        self.middles[at]
    }

    /// The vertices of the four sides of a patch, each from a corner to the next.
    fn ways(&self, cage: &Cage, patch: usize) -> [Way; 4] {
        let place = self.patches[patch].place;
        let range = cage.faces().range(place.face as usize);
        let (n, part) = (range.len(), place.part as usize);
        let edge =
            |corner: usize| self.way_of_edge(cage, range.start + corner % n, range.start + (corner + 1) % n);
        if n == 4 {
            return [0, 1, 2, 3].map(edge);
        }
        let [_, cells, middle] = self.middle(place.face);
        let (own, before) = (edge(part), edge(part + n - 1));
        let half = |way: &Way| way.len() / 2;
        let inwards = |corner: usize, from: u32| {
            let first = middle + 1 + (corner % n) as u32 * (cells - 1);
            let mut way = vec![from];
            way.extend(first..first + cells - 1);
            way.push(middle);
            way
        };
        let mut outwards = inwards(part + n - 1, before[half(&before)]);
        outwards.reverse();
        [
            own[..=half(&own)].to_vec(),
            inwards(part, own[half(&own)]),
            outwards,
            before[half(&before)..].to_vec(),
        ]
    }

    /// The vertices of the edge between two corners, from the first to the second.
    fn way_of_edge(&self, cage: &Cage, from: usize, to: usize) -> Way {
        let edge = cage.edges()[from] as usize;
        let [cells, first] = self.edges[edge];
        let [from, to] = [from, to].map(|corner| cage.faces().corners()[corner]);
        let mut way = vec![from.min(to)];
        way.extend(first..first + cells - 1);
        way.push(from.max(to));
        if from > to {
            way.reverse();
        }
        way
    }
}

/// The place of `i` of `of` cells among so many others, the nearest one.
fn rounded(i: u32, of: u32, cells: u32) -> u32 {
    let (i, of, cells) = (u64::from(i), u64::from(of), u64::from(cells));
    ((2 * i * cells + of) / (2 * of)) as u32
}

fn nearest(i: u32, of: u32, way: &Way) -> usize {
    rounded(i, of, way.len() as u32 - 1) as usize
}
