// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves as programs give them: vertices, the first vertex of each curve, a basis and a form.
//! Invariant: a curve that [`Curves::check`] accepts has a [`Segment`]. Tests: `tests/curves.rs` of `gnurt-accel`.

use super::cubic::Cubic;
use super::ray::{Offer, RayFrame};
use super::segment::Segment;
use super::starts::Starts;
use super::{Vector, pieces, place, ribbon};
use crate::bad_primitives::{BadPrimitives, LARGEST_COORDINATE};

/// How the vertices of a curve make its points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CurveBasis {
    /// Straight, between a vertex and the next one.
    Linear,
    /// A cubic of four vertices: it starts at the first and ends at the last, and the others pull it.
    Bezier,
    /// A cubic of four vertices, none of which it meets; neighbours with three of them in common join smoothly.
    #[default]
    BSpline,
    /// A cubic from the second to the third of four vertices; neighbours join smoothly.
    CatmullRom,
    /// A cubic between a vertex and the next one, with a tangent at each.
    Hermite,
}

const SIXTH: f64 = 1.0 / 6.0;

impl CurveBasis {
    pub(super) const BEZIER: [[f64; 4]; 4] =
        [[1.0, 0.0, 0.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [3.0, -6.0, 3.0, 0.0], [-1.0, 3.0, -3.0, 1.0]];
    pub(super) const B_SPLINE: [[f64; 4]; 4] = [
        [SIXTH, 4.0 * SIXTH, SIXTH, 0.0],
        [-0.5, 0.0, 0.5, 0.0],
        [0.5, -1.0, 0.5, 0.0],
        [-SIXTH, 0.5, -0.5, SIXTH],
    ];
    pub(super) const CATMULL_ROM: [[f64; 4]; 4] =
        [[0.0, 1.0, 0.0, 0.0], [-0.5, 0.0, 0.5, 0.0], [1.0, -2.5, 2.0, -0.5], [-0.5, 1.5, -1.5, 0.5]];

    /// Weights of four vertices in the powers from 0 to 3, where there are four.
    #[inline(always)]
    fn weights(self) -> Option<&'static [[f64; 4]; 4]> {
        match self {
            Self::Linear | Self::Hermite => None,
            Self::Bezier => Some(&Self::BEZIER),
            Self::BSpline => Some(&Self::B_SPLINE),
            Self::CatmullRom => Some(&Self::CATMULL_ROM),
        }
    }
}

/// What a ray sees of a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CurveForm {
    /// A ribbon that faces each ray, as broad as twice the radius. The cheapest, and right for hair that is thinner than
    /// a pixel. Straight ones have round ends, others end across.
    Flat,
    /// A tube: the circles of the radius around the curve and across it, without caps. Straight ones are cones with
    /// spheres at their ends, and closed. Radii are less than those of the bends.
    #[default]
    Round,
    /// A ribbon across the normals that come with the vertices, for blades of grass.
    Oriented,
}

/// Curves: borrowed arrays. A curve's index among `indices` is its `prim_id`.
///
/// A curve without a length or without a radius is dropped and counted among the primitives of zero area, and one with a
/// negative radius, too. [`Hit`](crate::Hit) says how `u` and `v` run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Curves<'a> {
    /// How vertices make points.
    pub basis: CurveBasis,
    /// What a ray sees.
    pub form: CurveForm,
    /// Positions and radii, object space.
    pub vertices: &'a [[f32; 4]],
    /// The first vertex of each curve; it takes the next ones, too: two or four in all, as its basis says.
    pub indices: &'a [u32],
    /// By vertex: derivatives of positions and radii. Hermite curves only.
    pub tangents: &'a [[f32; 4]],
    /// By vertex. Oriented curves only.
    pub normals: &'a [[f32; 3]],
    /// By vertex: derivatives of normals. Oriented Hermite curves only.
    pub normal_tangents: &'a [[f32; 3]],
    /// By curve: bit 0 if it goes on from the curve that ends at its first vertex, bit 1 if another one goes on from it.
    /// Empty: where the neighbours in `indices` say so. Straight round curves have no cap where another goes on.
    pub joints: &'a [u8],
    /// Whether round curves are hit from outside only, as Embree's straight ones are.
    pub is_seen_from_outside: bool,
    /// In how many straight pieces of equal parameters a bent ribbon that faces rays is cut, as Embree does it; 0 for none.
    pub pieces: u8,
}

impl<'a> Curves<'a> {
    /// Curves without normals, tangents and joints of their own.
    #[must_use]
    pub fn new(basis: CurveBasis, form: CurveForm, vertices: &'a [[f32; 4]], indices: &'a [u32]) -> Self {
        Self { basis, form, vertices, indices, ..Self::default() }
    }

    /// The same with normals by vertex.
    #[must_use]
    pub fn with_normals(self, normals: &'a [[f32; 3]]) -> Self {
        Self { normals, ..self }
    }

    /// The same with tangents by vertex.
    #[must_use]
    pub fn with_tangents(self, tangents: &'a [[f32; 4]]) -> Self {
        Self { tangents, ..self }
    }

    /// The point of a curve at `u` in `[0, 1]`, and its radius there; `None` where a vertex does not exist.
    #[must_use]
    pub fn point(&self, prim_id: u32, u: f64) -> Option<[f64; 4]> {
        Some(self.cubic(prim_id)?.at(u))
    }

    /// Its derivative by `u`.
    #[must_use]
    pub fn tangent(&self, prim_id: u32, u: f64) -> Option<[f64; 3]> {
        Some(place(self.cubic(prim_id)?.slope(u)))
    }

    /// The normal of a hit at `point`, of any length: outwards, or on the side of the normals of oriented curves. `None` for
    /// ribbons that face each ray.
    #[must_use]
    pub fn normal(&self, prim_id: u32, [u, v]: [f64; 2], point: [f64; 3]) -> Option<[f64; 3]> {
        self.segment(prim_id)?.normal(u, v, Some(point))
    }

    /// How many vertices a curve has.
    #[inline(always)]
    fn order(&self) -> usize {
        match self.basis {
            CurveBasis::Linear | CurveBasis::Hermite => 2,
            _ => 4,
        }
    }

    /// The part of an array that is a curve's.
    #[inline(always)]
    pub(super) fn of<T>(&self, array: &'a [T], prim_id: u32) -> Option<&'a [T]> {
        let first = *self.indices.get(prim_id as usize)? as usize;
        array.get(first..first.checked_add(self.order())?)
    }

    /// Calls `hit` as [`Segment::meet`] of the curve does. Cubics that face the ray are tested here, compiled for the caller's
    /// instructions; others gain nothing by that.
    #[inline(always)]
    pub fn meet(&self, prim_id: u32, frame: &RayFrame, part: [f64; 2], hit: Offer) {
        let (points, weights) = match (self.of(self.vertices, prim_id), self.basis.weights()) {
            (Some(points), Some(weights)) if self.form == CurveForm::Flat => (points, weights),
            _ => return self.meet_other(prim_id, frame, part, hit),
        };
        let Some(points) = points.first_chunk() else { return };
        let cubic = &Cubic::weighted(points, weights);
        match self.pieces {
            0 => ribbon::meet_flat(cubic, frame, part, hit),
            pieces => pieces::meet(cubic, pieces, frame, part, hit),
        }
    }

    #[inline(never)]
    fn meet_other(&self, prim_id: u32, frame: &RayFrame, part: [f64; 2], hit: Offer) {
        if let Some(segment) = self.segment(prim_id) {
            segment.meet(frame, part, hit);
        }
    }

    /// As powers of the parameter.
    #[inline]
    fn cubic(&self, prim_id: u32) -> Option<Cubic> {
        let points = self.of(self.vertices, prim_id)?;
        if let (Some(weights), Some(points)) = (self.basis.weights(), points.first_chunk()) {
            return Some(Cubic::weighted(points, weights));
        }
        let tangents = match self.basis {
            CurveBasis::Hermite => self.of(self.tangents, prim_id)?,
            _ => &[],
        };
        Some(Cubic::new(bezier(self.basis, points, tangents)))
    }

    fn normals(&self, prim_id: u32) -> Option<[Vector; 4]> {
        let normals = self.of(self.normals, prim_id)?;
        let tangents = match self.basis {
            CurveBasis::Hermite => self.of(self.normal_tangents, prim_id)?,
            _ => &[],
        };
        Some(bezier(self.basis, normals, tangents))
    }

    /// Whether a curve goes on from another one, and another one from it.
    fn joints(&self, prim_id: u32) -> [bool; 2] {
        let i = prim_id as usize;
        match self.joints.get(i) {
            Some(bits) => [bits & 1 != 0, bits & 2 != 0],
            None => {
                let follows = |i: usize| {
                    let next = self.indices.get(i + 1)?;
                    (self.indices[i].checked_add(1)? == *next).then_some(())
                };
                [i > 0 && follows(i - 1).is_some(), follows(i).is_some()]
            }
        }
    }

    /// A curve made ready for tests; `None` where an array is too short for it.
    #[must_use]
    pub fn segment(&self, prim_id: u32) -> Option<Segment> {
        if self.form == CurveForm::Oriented {
            return Some(Segment::Oriented(self.cubic(prim_id)?, self.normals(prim_id)?));
        }
        if self.basis != CurveBasis::Linear {
            let cubic = self.cubic(prim_id)?;
            return Some(match (self.form, self.pieces) {
                (CurveForm::Flat, 0) => Segment::Flat(cubic),
                (CurveForm::Flat, pieces) => Segment::Pieces(cubic, pieces),
                _ => Segment::Round(cubic, self.is_seen_from_outside),
            });
        }
        let &[a, b] = self.of(self.vertices, prim_id)? else { return None };
        let ends = [a, b].map(|end| end.map(f64::from));
        if self.form == CurveForm::Flat {
            return Some(Segment::FlatLine(ends));
        }
        let [before, after] = self.joints(prim_id);
        let first = self.indices[prim_id as usize] as usize;
        let vertex = |i: Option<usize>| Some(self.vertices.get(i?)?.map(f64::from));
        let before = if before { vertex(first.checked_sub(1)) } else { None };
        let after = if after { vertex(first.checked_add(2)) } else { None };
        Some(Segment::Cone { ends, before, after, is_seen_from_outside: self.is_seen_from_outside })
    }

    /// Whether a curve can be traced; counts its fault.
    pub fn check(&self, prim_id: u32, bad: &mut BadPrimitives) -> Option<Segment> {
        let Some(segment) = self.segment(prim_id) else {
            bad.bad_index += 1;
            return None;
        };
        let points = self.of(self.vertices, prim_id)?;
        let (mut tangents, mut normals): (&[[f32; 4]], &[[f32; 3]]) = (&[], &[]);
        if self.basis == CurveBasis::Hermite {
            tangents = self.of(self.tangents, prim_id)?;
        }
        if self.form == CurveForm::Oriented {
            normals = self.of(self.normals, prim_id)?;
        }
        let floats =
            points.as_flattened().iter().chain(tangents.as_flattened()).chain(normals.as_flattened());
        if let Some(fault) = bad.fault(floats.copied()) {
            *fault += 1;
            return None;
        }
        // Curves may leave the box of their vertices.
        if segment.bounds().greatest() > 2.0 * LARGEST_COORDINATE {
            bad.too_large += 1;
            return None;
        }
        let is_point =
            points.iter().all(|p| p[..3] == points[0][..3]) && tangents.iter().all(|t| t[..3] == [0.0; 3]);
        let is_ball = matches!(segment, Segment::Cone { .. });
        let is_wide = points.iter().all(|p| p[3] >= 0.0) && points.iter().any(|p| p[3] > 0.0);
        if is_point && !is_ball || !is_wide {
            bad.zero_area += 1;
            return None;
        }
        Some(segment)
    }
}

/// Control points of the Bezier cubic that is the same curve.
fn bezier<const N: usize>(basis: CurveBasis, points: &[[f32; N]], tangents: &[[f32; N]]) -> [[f64; N]; 4] {
    let p = |i: usize, k: usize| f64::from(points[i][k]);
    let mut control = [[0.0; N]; 4];
    for k in 0..N {
        let of_axis = match basis {
            CurveBasis::Bezier => [p(0, k), p(1, k), p(2, k), p(3, k)],
            CurveBasis::Linear => {
                let step = (p(1, k) - p(0, k)) / 3.0;
                [p(0, k), p(0, k) + step, p(1, k) - step, p(1, k)]
            }
            CurveBasis::BSpline => [
                (p(0, k) + 4.0 * p(1, k) + p(2, k)) / 6.0,
                (2.0 * p(1, k) + p(2, k)) / 3.0,
                (p(1, k) + 2.0 * p(2, k)) / 3.0,
                (p(1, k) + 4.0 * p(2, k) + p(3, k)) / 6.0,
            ],
            CurveBasis::CatmullRom => {
                [p(1, k), p(1, k) + (p(2, k) - p(0, k)) / 6.0, p(2, k) - (p(3, k) - p(1, k)) / 6.0, p(2, k)]
            }
            CurveBasis::Hermite => {
                let t = |i: usize| f64::from(tangents[i][k]) / 3.0;
                [p(0, k), p(0, k) + t(0), p(1, k) - t(1), p(1, k)]
            }
        };
        for (point, x) in control.iter_mut().zip(of_axis) {
            point[k] = x;
        }
    }
    control
}

/// The same arrays, owned by a tree.
#[derive(Clone, Debug, Default)]
pub struct OwnedCurves {
    pub basis: CurveBasis,
    pub form: CurveForm,
    pub vertices: Vec<[f32; 4]>,
    pub indices: Vec<u32>,
    pub tangents: Vec<[f32; 4]>,
    pub normals: Vec<[f32; 3]>,
    pub normal_tangents: Vec<[f32; 3]>,
    pub joints: Vec<u8>,
    pub is_seen_from_outside: bool,
    pub pieces: u8,
    /// Of the indices.
    pub starts: Starts,
}

/// A copy for rays, which meet curves anywhere.
fn copied<T: Copy>(values: &[T]) -> Vec<T> {
    let mut copy = Vec::with_capacity(values.len());
    gnurt_simd::prefer_huge_pages(&copy);
    copy.extend_from_slice(values);
    copy
}

impl OwnedCurves {
    pub fn new(curves: &Curves) -> Self {
        Self {
            basis: curves.basis,
            form: curves.form,
            vertices: copied(curves.vertices),
            indices: copied(curves.indices),
            starts: Starts::new(curves.indices),
            tangents: curves.tangents.to_vec(),
            normals: curves.normals.to_vec(),
            normal_tangents: curves.normal_tangents.to_vec(),
            joints: curves.joints.to_vec(),
            is_seen_from_outside: curves.is_seen_from_outside,
            pieces: curves.pieces,
        }
    }

    #[must_use]
    #[inline]
    pub fn view(&self) -> Curves<'_> {
        Curves {
            basis: self.basis,
            form: self.form,
            vertices: &self.vertices,
            indices: &self.indices,
            tangents: &self.tangents,
            normals: &self.normals,
            normal_tangents: &self.normal_tangents,
            joints: &self.joints,
            is_seen_from_outside: self.is_seen_from_outside,
            pieces: self.pieces,
        }
    }

    /// See [`Curves::segment`].
    #[must_use]
    pub fn segment(&self, prim_id: u32) -> Option<Segment> {
        self.view().segment(prim_id)
    }

    /// Bytes of the arrays.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.vertices[..])
            + size_of_val(&self.indices[..])
            + self.starts.memory_bytes()
            + size_of_val(&self.tangents[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.normal_tangents[..])
            + self.joints.len()
    }
}
