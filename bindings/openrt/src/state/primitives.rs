// SPDX-License-Identifier: GPL-3.0-or-later
//! Which triangles the vertices of a block make.
//! Source: OpenGL 1.x for strips, fans and polygons; quads are cut along their second and fourth vertex.
//! Tests: `tests::every_mode`, against the table written out; tests/c/primitives.c.

use super::enums::Primitive;

/// Up to two triangles, as numbers of vertices within their block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Completed {
    triangles: [[u32; 3]; 2],
    count: usize,
}

impl Completed {
    const NONE: Self = Self { triangles: [[0; 3]; 2], count: 0 };

    fn one(triangle: [u32; 3]) -> Self {
        Self { triangles: [triangle, [0; 3]], count: 1 }
    }

    fn two(triangles: [[u32; 3]; 2]) -> Self {
        Self { triangles, count: 2 }
    }

    /// The triangles.
    pub(crate) fn iter(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.triangles[..self.count].iter().copied()
    }
}

impl Primitive {
    /// How many vertices one primitive takes in the modes whose primitives share none; `None` in the others.
    #[must_use]
    pub(crate) fn independent_size(self) -> Option<u32> {
        match self {
            Self::Triangles => Some(3),
            Self::Quads => Some(4),
            Self::TriangleStrip | Self::TriangleFan | Self::QuadStrip | Self::Polygon => None,
        }
    }

    /// The triangles that vertex `i` of a block completes, counted from 0.
    #[must_use]
    #[inline]
    pub(crate) fn completed_by(self, i: u32) -> Completed {
        match self {
            Self::Triangles if i % 3 == 2 => Completed::one([i - 2, i - 1, i]),
            // Every other triangle of a strip swaps two vertices, so that all wind the same way.
            Self::TriangleStrip if i >= 2 && i.is_multiple_of(2) => Completed::one([i - 2, i - 1, i]),
            Self::TriangleStrip if i >= 2 => Completed::one([i - 1, i - 2, i]),
            Self::TriangleFan | Self::Polygon if i >= 2 => Completed::one([0, i - 1, i]),
            Self::Quads if i % 4 == 3 => Completed::two([[i - 3, i - 2, i], [i, i - 2, i - 1]]),
            Self::QuadStrip if i >= 3 && i % 2 == 1 => {
                Completed::two([[i - 3, i - 2, i - 1], [i - 1, i - 2, i]])
            }
            _ => Completed::NONE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(mode: Primitive, vertices: u32) -> Vec<[u32; 3]> {
        (0..vertices).flat_map(|i| mode.completed_by(i).iter().collect::<Vec<_>>()).collect()
    }

    #[test]
    fn every_mode() {
        let table: [(Primitive, u32, &[[u32; 3]]); 8] = [
            (Primitive::Triangles, 7, &[[0, 1, 2], [3, 4, 5]]),
            (Primitive::TriangleStrip, 6, &[[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]]),
            (Primitive::TriangleFan, 5, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]]),
            (Primitive::Polygon, 4, &[[0, 1, 2], [0, 2, 3]]),
            (Primitive::Quads, 8, &[[0, 1, 3], [3, 1, 2], [4, 5, 7], [7, 5, 6]]),
            (Primitive::QuadStrip, 6, &[[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]]),
            (Primitive::QuadStrip, 5, &[[0, 1, 2], [2, 1, 3]]),
            (Primitive::Polygon, 2, &[]),
        ];
        for (mode, vertices, expected) in table {
            assert_eq!(triangles(mode, vertices), expected, "{mode:?} of {vertices} vertices");
        }
    }
}
