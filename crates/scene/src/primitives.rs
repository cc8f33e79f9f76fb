// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves and spheres over the vertices of a mesh, in place of triangles: hair, grass, wires, particles.
//! Space: object. Invariant: after `Scene::check` there is a radius for each vertex, and each segment has all of its vertices.
//! Tests: `tests`, those of `check`; crates/render/tests/curves.rs.

use serde::{Deserialize, Serialize};

/// The surfaces that vertices make.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Primitives {
    /// The triangles of `Mesh::indices`.
    #[default]
    Triangles,
    /// Curves with a width.
    Curves(Box<Curves>),
    /// A sphere around each vertex, of the vertex's radius in object space.
    Spheres(Vec<f32>),
}

/// Curves with a width. A segment is a primitive: a hit's `prim_id` is an index into `segments`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Curves {
    /// How vertices make points.
    pub basis: CurveBasis,
    /// Their surface.
    pub form: CurveForm,
    /// By vertex, at least 0, in object space. A sphere or a curve of radius 0 is not shown.
    pub radii: Vec<f32>,
    /// The first vertex of each segment; it takes the next ones, too: two in all, or four of cubics.
    pub segments: Vec<u32>,
    /// By segment: how far along its strand it begins and ends, from 0 at the root to 1 at the tip. Empty = each is a
    /// strand of its own.
    pub spans: Vec<[f32; 2]>,
    /// Whether rays hit round curves from inside, too, as pipes and rods of glass. Fibres are hit from outside alone, and
    /// their lobes say how light leaves them.
    pub has_inside: bool,
}

/// How the vertices of a curve make its points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum CurveBasis {
    /// Straight, between a vertex and the next one.
    #[default]
    Linear,
    /// A cubic of four vertices that starts at the first and ends at the last.
    Bezier,
    /// A cubic of four vertices; neighbours with three of them in common join smoothly.
    BSpline,
    /// A cubic from the second to the third of four vertices.
    CatmullRom,
}

/// The surface of a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum CurveForm {
    /// A ribbon that faces each ray, shaded as the tube that it stands for: for hair thinner than a pixel.
    Flat,
    /// A tube, seen from outside.
    #[default]
    Round,
    /// A ribbon across the normals of the vertices: for blades of grass. Radii are half its width.
    Oriented,
}

impl Primitives {
    /// Bytes that its arrays hold.
    pub(crate) fn memory_bytes(&self) -> usize {
        match self {
            Self::Triangles => 0,
            Self::Curves(curves) => {
                let Curves { radii, segments, spans, .. } = &**curves;
                size_of_val(&radii[..]) + size_of_val(&segments[..]) + size_of_val(&spans[..])
            }
            Self::Spheres(radii) => size_of_val(&radii[..]),
        }
    }
}

impl CurveBasis {
    /// Vertices of a segment.
    #[must_use]
    pub fn order(self) -> usize {
        if self == Self::Linear { 2 } else { 4 }
    }

    /// Of those, the ones between which values of vertices change over the segment.
    pub(crate) fn ends(self) -> [u32; 2] {
        match self {
            Self::Linear => [0, 1],
            Self::Bezier => [0, 3],
            Self::BSpline | Self::CatmullRom => [1, 2],
        }
    }

    /// Vertices from one segment to the next on a strand.
    #[must_use]
    pub fn step(self) -> usize {
        if self == Self::Bezier { 3 } else { 1 }
    }
}

impl Curves {
    /// Strands of these numbers of vertices, which follow each other; strands too short for a segment have none. The
    /// radii are still missing.
    #[must_use]
    pub fn of_strands(basis: CurveBasis, form: CurveForm, lengths: impl IntoIterator<Item = usize>) -> Self {
        let (mut segments, mut spans, mut first) = (Vec::new(), Vec::new(), 0);
        for length in lengths {
            let count = (length + basis.step()).saturating_sub(basis.order()) / basis.step();
            let along = |i: usize| i as f32 / count as f32;
            segments.extend((0..count).map(|i| (first + i * basis.step()) as u32));
            spans.extend((0..count).map(|i| [along(i), along(i + 1)]));
            first += length;
        }
        Self { basis, form, segments, spans, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strands_become_segments() {
        let of = |basis, lengths: &[usize]| {
            Curves::of_strands(basis, CurveForm::Round, lengths.iter().copied()).segments
        };
        assert_eq!(of(CurveBasis::Linear, &[3, 1, 2]), [0, 1, 4], "a strand of one vertex has none");
        assert_eq!(of(CurveBasis::Bezier, &[7, 3, 4]), [0, 3, 10], "three vertices further each");
        assert_eq!(of(CurveBasis::BSpline, &[6, 4]), [0, 1, 2, 6], "one vertex further each");
        let curves = Curves::of_strands(CurveBasis::Linear, CurveForm::Flat, [3]);
        assert_eq!(curves.spans, [[0.0, 0.5], [0.5, 1.0]], "from root to tip");
    }
}
