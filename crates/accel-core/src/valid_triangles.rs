// SPDX-License-Identifier: GPL-3.0-or-later
//! The triangles of an object, halves of quads among them, without untraceable ones.
//! Space: object. Invariant: each of them has finite, in-range, non-flat corners.
//! Tests: `tests::each_fault_is_counted_once`, `tests::quads_have_two_numbers`.

use std::ops::Range;

use rayon::prelude::*;

use crate::aabb::Aabb;
use crate::geometry::{BadPrimitives, Geometry, Numbering, Triangles};
use crate::surfaces::{Surface, Surfaces, check, check_quad};
use crate::threads::Threads;

/// Triangles of some geometries under the object's numbers; bad ones keep their number and have no corners.
pub struct ValidTriangles<'a> {
    pub surfaces: Surfaces<'a>,
    /// Numbers of the triangles that can be traced, ascending.
    pub good: Vec<u32>,
    pub bad: BadPrimitives,
    pub bounds: Aabb,
}

/// The good and the bad ones of some triangles.
struct Filtered {
    good: Vec<u32>,
    bad: BadPrimitives,
    bounds: Aabb,
}

impl Default for Filtered {
    fn default() -> Self {
        Self { good: Vec::new(), bad: BadPrimitives::default(), bounds: Aabb::EMPTY }
    }
}

/// Numbers that one thread processes. Both halves of a quad are in the same piece.
const PIECE: u32 = if cfg!(test) { 1 << 3 } else { 1 << 14 };

impl<'a> ValidTriangles<'a> {
    /// Visits every triangle and quad of the accepted geometries once.
    pub fn over(
        geometries: &[Geometry<'a>],
        numbering: &Numbering,
        accept: impl Fn(&Geometry) -> bool,
        threads: Threads,
    ) -> Self {
        let surfaces = Surfaces::new(geometries, numbering, accept);
        let mut pieces = Vec::new();
        for (i, surface) in surfaces.meshes.iter().enumerate() {
            let Range { start, end } = numbering.range(i);
            if !matches!(surface, Surface::None) {
                let starts = (start..end).step_by(PIECE as usize);
                pieces.extend(starts.map(|at| (surface, start, at..end.min(at.saturating_add(PIECE)))));
            }
        }
        let filter = |(surface, start, range): &(&Surface, u32, Range<u32>)| {
            let mut filtered = Filtered::default();
            filtered.good.reserve_exact(range.len());
            filtered.filter(surface, *start, range.clone());
            filtered
        };
        let pieces_filtered: Vec<Filtered> = threads.run(|parallel| match parallel {
            true => pieces.par_iter().map(filter).collect(),
            false => pieces.iter().map(filter).collect(),
        });
        let mut valid = Self {
            surfaces,
            good: Vec::with_capacity(pieces_filtered.iter().map(|filtered| filtered.good.len()).sum()),
            bad: BadPrimitives::default(),
            bounds: Aabb::EMPTY,
        };
        for Filtered { good, bad, bounds } in pieces_filtered {
            valid.good.extend_from_slice(&good);
            valid.bad += bad;
            valid.bounds = valid.bounds.union(&bounds);
        }
        valid
    }

    /// Those of triangle meshes only.
    #[must_use]
    pub fn new(meshes: &[Triangles<'a>]) -> Self {
        let geometries: Vec<Geometry> = meshes.iter().map(|&mesh| mesh.into()).collect();
        Self::over(&geometries, &Numbering::new(&geometries), |_| true, Threads::Single)
    }

    /// The corners of triangle `number`, which must be one of `good`.
    #[inline]
    pub fn corners(&self, number: u32) -> [[f32; 3]; 3] {
        self.surfaces.corners(number)
    }

    /// One past the greatest number.
    #[inline]
    pub fn count(&self) -> usize {
        self.good.last().map_or(0, |&last| last as usize + 1)
    }
}

impl Filtered {
    /// Takes the good ones among `numbers` of a geometry whose first number is `start`.
    fn filter(&mut self, surface: &Surface, start: u32, numbers: Range<u32>) {
        let range = (numbers.start - start) as usize..(numbers.end - start) as usize;
        match surface {
            Surface::Triangles(mesh) => {
                for (number, &corners) in numbers.zip(&mesh.indices[range]) {
                    self.take(number, mesh.positions, corners);
                }
            }
            Surface::Quads(mesh) => {
                for (number, quad) in numbers.step_by(2).zip(&mesh.indices[range.start / 2..]) {
                    self.take_quad(number, mesh.positions, quad);
                }
            }
            Surface::None => {}
        }
    }

    fn take(&mut self, number: u32, positions: &[[f32; 3]], corners: [u32; 3]) {
        match check(&mut self.bad, positions, corners) {
            Ok(triangle) => self.keep(number, &triangle),
            Err(fault) => *fault += 1,
        }
    }

    fn take_quad(&mut self, number: u32, positions: &[[f32; 3]], quad: &[u32; 4]) {
        for (i, triangle) in (0..).zip(check_quad(&mut self.bad, positions, quad)) {
            if let Some(triangle) = triangle {
                self.keep(number + i, &triangle);
            }
        }
    }

    fn keep(&mut self, number: u32, triangle: &[[f32; 3]; 3]) {
        self.bounds = self.bounds.union(&Aabb::around(triangle));
        self.good.push(number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{GeometryKind, Quads, geometry_of};

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
        let valid = ValidTriangles::new(&meshes);
        let accept =
            BadPrimitives { bad_index: 2, nan: 1, infinite: 1, too_large: 1, zero_area: 2, too_many: 0 };
        assert_eq!(valid.bad, accept, "one count per bad triangle");
        assert_eq!(valid.bad.total(), 7, "all of them");
        assert_eq!(valid.good, [0, 7], "what is left keeps its number");
        assert_eq!(valid.corners(7)[0], [0.0, 1.0, 0.0], "found through an empty mesh");
        assert_eq!(geometry_of(&valid.surfaces.starts, 0), 1, "the empty mesh holds nothing");
    }

    #[test]
    fn quads_have_two_numbers() {
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN, 1.0, 0.0]];
        let quads = Quads {
            positions: &positions,
            indices: &[[0, 1, 2, 3], [0, 1, 3, 3], [0, 1, 2, 4], [0, 0, 0, 0], [9, 1, 2, 3]],
        };
        let triangles = Triangles { positions: &positions, indices: &[[0, 1, 2]] };
        let geometries = [Geometry::from(triangles), quads.into(), triangles.into()];
        let numbering = Numbering::new(&geometries);
        assert_eq!(numbering.starts, [0, 1, 11, 12], "quads take two numbers each");
        let valid = ValidTriangles::over(&geometries, &numbering, |_| true, Threads::Single);
        assert_eq!(valid.good, [0, 1, 2, 3, 11], "a quad, and one that is a triangle");
        let accept = BadPrimitives { bad_index: 1, nan: 1, zero_area: 1, ..BadPrimitives::default() };
        assert_eq!(valid.bad, accept, "each quad is counted once");
        let [first, second] = [1, 2].map(|number| valid.corners(number));
        assert_eq!(first, [positions[0], positions[1], positions[3]], "the half at vertex 0");
        assert_eq!(second, [positions[2], positions[3], positions[1]], "the half at vertex 2");
        let locate = numbering.locate(2);
        assert_eq!((locate.geom_id, locate.prim_id, locate.second_half), (1, 0, true), "{locate:?}");
        assert_eq!(numbering.locate(11).geom_id, 2, "triangles again");
        let is_quad = |geometry: &Geometry| matches!(geometry.kind, GeometryKind::Quads(_));
        let single = ValidTriangles::over(&geometries, &numbering, is_quad, Threads::Single);
        assert_eq!(single.good, [1, 2, 3], "what is not wanted is left out");
    }
}
