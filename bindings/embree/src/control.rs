// SPDX-License-Identifier: GPL-3.0-or-later
//! Control meshes of subdivision surfaces, from the program's arrays. Source: Embree's manual.
//!
//! Faces that cannot be are left out, as holes are: with fewer than 3 corners or more than 16, with vertices that are not there
//! or come twice. Numbers of faces and of half edges are the program's. Tests: `tests/c/subdivision.c`.

use std::collections::HashMap;

use gnurt_subdivision::{Boundary, Cage, Faces, Scheme, Surface, boundary_vertices};

use crate::device::Problem;
use crate::ffi_memory::View;

/// The most corners of a face: its parts are counted in four bits of `u` and `v`.
const MOST_CORNERS: usize = 16;

/// `RTCSubdivisionMode`.
pub(crate) const MODES: std::ops::RangeInclusive<u32> = 0..=4;

/// The arrays of a topology.
pub(crate) struct Input<'a> {
    pub(crate) mode: u32,
    pub(crate) faces: &'a View,
    pub(crate) indices: &'a View,
    /// Of the first topology, whose vertices creases name.
    pub(crate) first_indices: &'a View,
    /// How many vertices there are; of later topologies: the number of different vertices named.
    pub(crate) vertices: Option<usize>,
    pub(crate) holes: &'a View,
    /// Edges and their weights.
    pub(crate) edge_creases: [&'a View; 2],
    /// Vertices and their weights.
    pub(crate) vertex_creases: [&'a View; 2],
}

/// A control mesh.
#[derive(Debug)]
pub(crate) struct Control {
    pub(crate) cage: Cage,
    /// By face of the cage: the program's.
    prim_ids: Vec<u32>,
    /// By face of the program's: that of the cage.
    kept: Vec<Option<u32>>,
    /// Where the half edges of each of the program's faces begin; one more at the end.
    starts: Vec<u32>,
    /// By vertex of the cage: its row, where that is another number.
    rows: Option<Vec<u32>>,
    /// By half edge of the program's: the one behind it.
    opposite: Vec<u32>,
}

fn numbers(view: &View) -> impl Iterator<Item = u32> {
    (0..view.len()).map_while(|i| view.number(i, 0))
}

/// Rows of an array and their weights, of which there must be as many.
fn weights<const N: usize>([keys, weights]: [&View; 2], what: &str) -> Result<Vec<([u32; N], f32)>, Problem> {
    if keys.len() != weights.len() {
        let (keys, weights) = (keys.len(), weights.len());
        return Err(Problem::operation(format!("{keys} {what} creases have {weights} weights")));
    }
    Ok((0..keys.len()).filter_map(|i| Some((keys.get(i)?, weights.number(i, 0)?))).collect())
}

impl Control {
    /// Reads a control mesh.
    ///
    /// # Errors
    /// Arrays of lengths that do not fit.
    pub(crate) fn new(input: &Input) -> Result<Self, Problem> {
        let mut starts = vec![0_u32];
        let mut sum = 0_u64;
        for corners in numbers(input.faces) {
            sum += u64::from(corners);
            starts.push(u32::try_from(sum).unwrap_or(u32::MAX));
        }
        for indices in [input.indices, input.first_indices] {
            // More are not read, as by Embree.
            if sum > indices.len() as u64 {
                let given = indices.len();
                return Err(Problem::operation(format!(
                    "the faces have {sum} corners, but the index buffer has {given}"
                )));
            }
        }
        let mut indices: Vec<u32> = numbers(input.indices).take(sum as usize).collect();
        let (vertices, rows) = match input.vertices {
            Some(vertices) => (vertices, None),
            None => {
                let mut rows = indices.clone();
                rows.sort_unstable();
                rows.dedup();
                let number = |row: &mut u32| *row = rows.binary_search(row).unwrap_or(0) as u32;
                indices.iter_mut().for_each(number);
                (rows.len(), Some(rows))
            }
        };
        let edges: HashMap<[u32; 2], f32> = weights(input.edge_creases, "edge")?
            .into_iter()
            .map(|([a, b], weight)| ([a.min(b), a.max(b)], weight))
            .collect();
        let sharp: HashMap<[u32; 1], f32> = weights(input.vertex_creases, "vertex")?.into_iter().collect();
        let mut kept = vec![None; starts.len() - 1];
        let (mut prim_ids, mut counts, mut corners) = (Vec::new(), Vec::new(), Vec::new());
        let (mut creases, mut sharp_vertices) = (Vec::new(), Vec::new());
        let mut is_hole = vec![false; kept.len()];
        for hole in numbers(input.holes) {
            if let Some(is_hole) = is_hole.get_mut(hole as usize) {
                *is_hole = true;
            }
        }
        for (prim_id, kept) in kept.iter_mut().enumerate().filter(|&(prim_id, _)| !is_hole[prim_id]) {
            let range = starts[prim_id] as usize..starts[prim_id + 1] as usize;
            let face = &indices[range.clone()];
            let is_there = |&vertex: &u32| (vertex as usize) < vertices && i32::try_from(vertex).is_ok();
            let is_twice = |i: usize| face[..i].contains(&face[i]);
            if !(3..=MOST_CORNERS).contains(&face.len())
                || !face.iter().all(is_there)
                || (1..face.len()).any(is_twice)
            {
                continue;
            }
            *kept = Some(prim_ids.len() as u32);
            prim_ids.push(prim_id as u32);
            counts.push(face.len() as i32);
            corners.extend(face.iter().map(|&vertex| vertex as i32));
            // Creases are those of the first topology's edges.
            let first = |i: usize| input.first_indices.number::<u32>(range.start + i % range.len(), 0);
            for (i, &vertex) in face.iter().enumerate() {
                let (Some(a), Some(b)) = (first(i), first(i + 1)) else { continue };
                if let Some(&weight) = edges.get(&[a.min(b), a.max(b)]) {
                    creases.push(([vertex, face[(i + 1) % face.len()]], weight));
                }
                if let Some(&weight) = sharp.get(&[a]) {
                    sharp_vertices.push((vertex, weight));
                }
            }
        }
        let faces = Faces::new(&counts, &corners, vertices)
            .map_err(|error| Problem::operation(format!("a subdivision surface: {error}")))?;
        const PIN_BOUNDARY: u32 = 3;
        const PIN_ALL: u32 = 4;
        if input.mode == PIN_BOUNDARY {
            sharp_vertices
                .extend(boundary_vertices(&faces).into_iter().map(|vertex| (vertex, f32::INFINITY)));
        }
        let boundary = match input.mode {
            0 => Boundary::None,
            2 => Boundary::EdgeAndCorner,
            _ => Boundary::EdgeOnly,
        };
        let scheme = if input.mode == PIN_ALL { Scheme::Bilinear } else { Scheme::CatmullClark };
        let cage = Cage::new(Surface { scheme, boundary, faces, creases, corners: sharp_vertices });
        let mut control = Self { cage, prim_ids, kept, starts, rows, opposite: Vec::new() };
        control.opposite = control.find_opposite();
        Ok(control)
    }

    fn find_opposite(&self) -> Vec<u32> {
        let mut opposite: Vec<u32> = (0..self.half_edges()).collect();
        let mut seen = vec![None; self.cage.edge_count()];
        for (face, &prim_id) in self.prim_ids.iter().enumerate() {
            for (i, corner) in self.cage.faces().range(face).enumerate() {
                let (edge, own) =
                    (self.cage.edges()[corner] as usize, self.starts[prim_id as usize] + i as u32);
                match seen[edge] {
                    Some(other) if self.cage.faces_of_edge(edge) == 2 => {
                        opposite[own as usize] = other;
                        opposite[other as usize] = own;
                    }
                    _ => seen[edge] = Some(own),
                }
            }
        }
        opposite
    }

    /// The program's number of a face of the cage.
    pub(crate) fn prim_id(&self, face: u32) -> u32 {
        self.prim_ids[face as usize]
    }

    /// The face of the cage; `None` where it was left out.
    pub(crate) fn face(&self, prim_id: u32) -> Option<u32> {
        self.kept.get(prim_id as usize).copied().flatten()
    }

    /// How many faces the program has given.
    pub(crate) fn faces(&self) -> u32 {
        self.kept.len() as u32
    }

    /// How many half edges these have.
    pub(crate) fn half_edges(&self) -> u32 {
        self.starts.last().copied().unwrap_or(0)
    }

    /// The half edges of one of the program's faces.
    pub(crate) fn half_edges_of(&self, prim_id: u32) -> std::ops::Range<u32> {
        self.starts[prim_id as usize]..self.starts[prim_id as usize + 1]
    }

    /// The program's face of a half edge.
    pub(crate) fn face_of(&self, half_edge: u32) -> u32 {
        self.starts.partition_point(|&start| start <= half_edge) as u32 - 1
    }

    /// The half edge behind a half edge, or itself.
    pub(crate) fn opposite(&self, half_edge: u32) -> u32 {
        self.opposite[half_edge as usize]
    }

    /// The row of a vertex in the program's arrays.
    pub(crate) fn row(&self, vertex: u32) -> usize {
        self.rows.as_ref().map_or(vertex, |rows| rows[vertex as usize]) as usize
    }

    /// The level of the edge at a corner of the cage's faces, from an array by half edge.
    pub(crate) fn level(&self, levels: &View, corner: usize, face: usize) -> Option<f32> {
        let at = corner - self.cage.faces().range(face).start;
        levels.number(self.starts[self.prim_ids[face] as usize] as usize + at, 0)
    }
}
