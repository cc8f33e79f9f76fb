// SPDX-License-Identifier: GPL-3.0-or-later
//! What a tree is built over, and the screening of what cannot be traced.
//! Source: original. Space: object. Invariant: what passes [`Screened::new`] has finite, in-range, non-flat triangles.
//! Proof: `tests::each_fault_is_counted_once`.

use crate::Aabb;

/// Coordinates beyond this are dropped: squares of their differences still fit a float.
pub const LARGEST_COORDINATE: f32 = 1.8e18;

/// Most triangles of one object: what an event of the builder can number.
pub const MOST_TRIANGLES: usize = (1 << 30) - 1;

/// One mesh: borrowed arrays. Its `geom_id` is its place in the list that is built over.
#[derive(Clone, Copy, Debug, Default)]
pub struct Triangles<'a> {
    /// Vertex positions, object space.
    pub positions: &'a [[f32; 3]],
    /// Vertices of each triangle; its place is its `prim_id`.
    pub indices: &'a [[u32; 3]],
}

/// Triangles that were left out of a tree, by the first fault found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BadPrimitives {
    /// An index that is not below the number of positions.
    pub bad_index: u64,
    /// A coordinate that is not a number.
    pub nan: u64,
    /// An infinite coordinate.
    pub infinite: u64,
    /// A coordinate beyond [`LARGEST_COORDINATE`].
    pub too_large: u64,
    /// Corners on one line or in one point.
    pub zero_area: u64,
    /// More than [`MOST_TRIANGLES`] in one object.
    pub too_many: u64,
}

impl BadPrimitives {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.bad_index + self.nan + self.infinite + self.too_large + self.zero_area + self.too_many
    }
}

/// The triangles of all meshes under one numbering; bad ones keep their number and have no corners.
pub(crate) struct Screened<'a> {
    meshes: &'a [Triangles<'a>],
    /// First number of each mesh, and one past the last.
    pub(crate) starts: Vec<u32>,
    /// Numbers of the triangles that can be traced, ascending.
    pub(crate) good: Vec<u32>,
    pub(crate) bad: BadPrimitives,
    pub(crate) bounds: Aabb,
}

impl<'a> Screened<'a> {
    /// Looks at every triangle once.
    pub(crate) fn new(meshes: &'a [Triangles<'a>]) -> Self {
        let mut screened = Self {
            meshes,
            starts: vec![0],
            good: Vec::new(),
            bad: BadPrimitives::default(),
            bounds: Aabb::EMPTY,
        };
        let total: usize = meshes.iter().map(|mesh| mesh.indices.len()).sum();
        screened.good.reserve_exact(total.min(MOST_TRIANGLES));
        let mut number = 0;
        for mesh in meshes {
            let room = MOST_TRIANGLES - number as usize;
            let taken = &mesh.indices[..mesh.indices.len().min(room)];
            screened.bad.too_many += (mesh.indices.len() - taken.len()) as u64;
            for &corners in taken {
                if let Some(triangle) = screened.check(mesh, corners) {
                    screened.bounds = screened.bounds.union(&Aabb::around(&triangle));
                    screened.good.push(number);
                }
                number += 1;
            }
            screened.starts.push(number);
        }
        screened
    }

    /// The corners of triangle `number`, which must be one of `good`.
    #[inline]
    pub(crate) fn corners(&self, number: u32) -> [[f32; 3]; 3] {
        let mesh = mesh_of(&self.starts, number);
        let Triangles { positions, indices } = self.meshes[mesh];
        indices[(number - self.starts[mesh]) as usize].map(|i| positions[i as usize])
    }

    /// How many numbers there are.
    pub(crate) fn count(&self) -> usize {
        self.starts[self.starts.len() - 1] as usize
    }

    fn check(&mut self, mesh: &Triangles, corners: [u32; 3]) -> Option<[[f32; 3]; 3]> {
        let bad = &mut self.bad;
        if corners.iter().any(|&i| i as usize >= mesh.positions.len()) {
            bad.bad_index += 1;
            return None;
        }
        let triangle = corners.map(|i| mesh.positions[i as usize]);
        let any = |test: fn(f32) -> bool| triangle.iter().flatten().any(|&x| test(x));
        let fault = if any(f32::is_nan) {
            &mut bad.nan
        } else if any(f32::is_infinite) {
            &mut bad.infinite
        } else if any(|x| x.abs() > LARGEST_COORDINATE) {
            &mut bad.too_large
        } else if is_flat(&triangle) {
            &mut bad.zero_area
        } else {
            return Some(triangle);
        };
        *fault += 1;
        None
    }
}

/// The mesh that holds triangle `number`, given where each mesh starts.
#[inline]
pub(crate) fn mesh_of(starts: &[u32], number: u32) -> usize {
    if starts.len() == 2 { 0 } else { starts.partition_point(|&start| start <= number) - 1 }
}

/// Whether the corners span no area, in double precision.
fn is_flat([a, b, c]: &[[f32; 3]; 3]) -> bool {
    let edge = |p: &[f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k]));
    let ([ux, uy, uz], [vx, vy, vz]) = (edge(b), edge(c));
    uy * vz == uz * vy && uz * vx == ux * vz && ux * vy == uy * vx
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_is_counted_once() {
        let positions = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [f32::NAN, 0.0, f32::INFINITY],
            [0.0, f32::NEG_INFINITY, 0.0],
            [2e18, 0.0, 0.0],
            [2.0, 0.0, 0.0],
        ];
        let indices = [
            [0, 1, 2],
            [0, 1, 7],
            [0, 1, 3],
            [0, 1, 4],
            [0, 2, 5],
            [0, 1, 6],
            [1, 1, 2],
            [2, 1, 0],
            [9, 3, 3],
        ];
        let meshes = [Triangles::default(), Triangles { positions: &positions, indices: &indices }];
        let screened = Screened::new(&meshes);
        let wanted =
            BadPrimitives { bad_index: 2, nan: 1, infinite: 1, too_large: 1, zero_area: 2, too_many: 0 };
        assert_eq!(screened.bad, wanted, "one count per bad triangle");
        assert_eq!(screened.bad.total(), 7, "all of them");
        assert_eq!(screened.good, [0, 7], "what is left keeps its number");
        assert_eq!(screened.corners(7)[0], [0.0, 1.0, 0.0], "found through an empty mesh");
        assert_eq!(mesh_of(&screened.starts, 0), 1, "the empty mesh holds nothing");
    }
}
