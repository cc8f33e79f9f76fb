// SPDX-License-Identifier: GPL-3.0-or-later
//! Splines over knots at equal distances, and their inverse.
//! Source: the OSL 1.14 language reference, "spline", for its bases; the inverse by regula falsi that falls
//! back to bisection. Positions are in [0, 1] from the first segment's start to the last one's end.
//! Invariant: sums are done in OSL's order, for its bits.
//! Tests: `tests/splines.rs`.

use crate::number::{Number, Real, UInts};

/// The kinds of spline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// Through all knots but the first and last.
    CatmullRom,
    /// Through every third knot.
    Bezier,
    /// Near the knots, with smooth curvature.
    BSpline,
    /// Pairs of a value and a slope.
    Hermite,
    /// Straight from knot to knot, but the first and last.
    Linear,
    /// The second of four knots.
    Constant,
}

impl Basis {
    /// The basis of this name; names that are none of a basis mean linear, as with OSL.
    #[must_use]
    pub fn named(name: &str) -> Self {
        match name {
            "catmull-rom" => Self::CatmullRom,
            "bezier" => Self::Bezier,
            "bspline" => Self::BSpline,
            "hermite" => Self::Hermite,
            "constant" => Self::Constant,
            _ => Self::Linear,
        }
    }

    /// Knots from one segment to the next.
    #[must_use]
    pub fn step(self) -> usize {
        match self {
            Self::Bezier => 3,
            Self::Hermite => 2,
            Self::CatmullRom | Self::BSpline | Self::Linear | Self::Constant => 1,
        }
    }

    /// How many segments this many knots make; 0 where there are fewer than four.
    #[must_use]
    pub fn segments(self, knots: usize) -> usize {
        if knots < 4 { 0 } else { (knots - 4) / self.step() + 1 }
    }

    /// By rows the powers 3 to 0 of the position in the segment, by columns the four knots.
    const fn matrix(self) -> [[f32; 4]; 4] {
        const SIXTH: f32 = 1.0 / 6.0;
        match self {
            Self::CatmullRom => {
                [[-0.5, 1.5, -1.5, 0.5], [1.0, -2.5, 2.0, -0.5], [-0.5, 0.0, 0.5, 0.0], [0.0, 1.0, 0.0, 0.0]]
            }
            Self::Bezier => {
                [[-1.0, 3.0, -3.0, 1.0], [3.0, -6.0, 3.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
            }
            Self::BSpline => [
                [-SIXTH, 0.5, -0.5, SIXTH],
                [0.5, -1.0, 0.5, 0.0],
                [-0.5, 0.0, 0.5, 0.0],
                [SIXTH, 4.0 / 6.0, SIXTH, 0.0],
            ],
            Self::Hermite => {
                [[2.0, 1.0, -2.0, 1.0], [-3.0, -2.0, 3.0, -1.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
            }
            Self::Linear | Self::Constant => {
                [[0.0; 4], [0.0; 4], [0.0, -1.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0]]
            }
        }
    }
}

/// The knots in the form that the function needs: knot `i` of segments that differ by lane.
pub trait Knots<N: Number> {
    /// How many.
    fn count(&self) -> usize;
    /// The knots at these indices, all of which are below the count.
    fn at(&self, indices: <N::Real as Real>::UInts) -> N;
}

impl Knots<f32> for &[f32] {
    fn count(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn at(&self, indices: <f32 as Real>::UInts) -> f32 {
        self[indices.0 as usize]
    }
}

impl Knots<crate::Dual<f32>> for &[f32] {
    fn count(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn at(&self, indices: <f32 as Real>::UInts) -> crate::Dual<f32> {
        self[indices.0 as usize].into()
    }
}

impl Knots<crate::Dual<f32>> for &[crate::Dual<f32>] {
    fn count(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn at(&self, indices: <f32 as Real>::UInts) -> crate::Dual<f32> {
        self[indices.0 as usize]
    }
}

/// One component of a list of triples as knots.
#[derive(Clone, Copy, Debug)]
pub struct Component<'a, T> {
    /// The triples.
    pub triples: &'a [T],
    /// Which component.
    pub index: usize,
}

impl Knots<f32> for Component<'_, [f32; 3]> {
    fn count(&self) -> usize {
        self.triples.len()
    }

    #[inline(always)]
    fn at(&self, indices: <f32 as Real>::UInts) -> f32 {
        self.triples[indices.0 as usize][self.index]
    }
}

impl Knots<crate::Dual<f32>> for Component<'_, [f32; 3]> {
    fn count(&self) -> usize {
        self.triples.len()
    }

    #[inline(always)]
    fn at(&self, indices: <f32 as Real>::UInts) -> crate::Dual<f32> {
        self.triples[indices.0 as usize][self.index].into()
    }
}

impl Knots<crate::Dual<f32>> for Component<'_, crate::Dual<[f32; 3]>> {
    fn count(&self) -> usize {
        self.triples.len()
    }

    #[inline(always)]
    fn at(&self, indices: <f32 as Real>::UInts) -> crate::Dual<f32> {
        self.triples[indices.0 as usize].components()[self.index]
    }
}

/// The spline at `x`, which is clamped to [0, 1]; 0 where there are fewer than four knots.
#[inline(always)]
pub fn spline<N: Number>(basis: Basis, x: N, knots: impl Knots<N>) -> N {
    let segments = basis.segments(knots.count());
    if segments == 0 {
        return x.constant(0.0);
    }
    let (value, one) = (x.value(), x.value().of(1.0));
    let lowered = N::pick(value.at_most(one), x, x.constant(1.0));
    let x = N::pick(one.of(0.0).at_most(value), lowered, x.constant(0.0)) * segments as f32;
    let segment = x.value().to_int();
    let last = segment.constant(segments as u32 - 1);
    let segment = UInts::pick(segment.below(segments as u32), segment, last);
    let first = match basis.step() {
        1 => segment,
        2 => segment + segment,
        _ => segment + segment + segment,
    };
    if basis == Basis::Constant {
        return N::lift(knots.at(first + 1).value());
    }
    let x = x.with_value(x.value() - N::Real::from_int(segment));
    let four = [knots.at(first), knots.at(first + 1), knots.at(first + 2), knots.at(first + 3)];
    let [cubic, square, linear, constant] =
        basis.matrix().map(|row| four[0] * row[0] + four[1] * row[1] + four[2] * row[2] + four[3] * row[3]);
    ((cubic * x + square) * x + linear) * x + constant
}

/// Where the spline is `y`: its inverse for knots that only rise or only fall. 0 and 1 beyond its ends.
///
/// Derivatives are those of the search's steps, as with OSL: within 1e-3 of one over the slope where the spline is smooth.
#[must_use]
pub fn splineinverse<'a, N>(basis: Basis, y: N, knots: &'a [f32]) -> N
where
    N: Number<Real = f32, Mask = bool>,
    &'a [f32]: Knots<N>,
{
    let zero = y.constant(0.0);
    let segments = basis.segments(knots.len());
    if segments == 0 {
        return zero;
    }
    let outer = usize::from(basis.step() == 1);
    let (low, high) = (knots[outer], knots[knots.len() - 1 - outer]);
    let rising = knots[1] < knots[knots.len() - 2];
    let value = y.value();
    if if rising { value <= low } else { value >= low } {
        return zero;
    }
    if if rising { value >= high } else { value <= high } {
        return y.constant(1.0);
    }
    let at = |x: N| spline(basis, x, knots);
    // Knots that rise may still make a curve that does not: each segment is searched by itself.
    let (mut start, mut x) = (zero, zero);
    for segment in 1..=segments {
        let end = y.constant((1.0 / segments as f32) * segment as f32);
        let (found, bracketed) = invert(at, y, start, end);
        x = found;
        if bracketed {
            break;
        }
        start = end;
    }
    x
}

/// A position between two where a function is `y`, and whether there is one.
fn invert<N: Number<Real = f32, Mask = bool>>(
    function: impl Fn(N) -> N,
    y: N,
    mut start: N,
    mut end: N,
) -> (N, bool) {
    const CLOSE: f32 = 1e-6;
    const STEPS: u32 = 32;
    let is_close = |a: N, b: N| (a.value() - b.value()).abs() < CLOSE;
    let (mut at_start, mut at_end) = (function(start), function(end));
    let rising = at_start.value() < at_end.value();
    let (low, high) = if rising { (at_start, at_end) } else { (at_end, at_start) };
    if y.value() < low.value() || y.value() > high.value() {
        return (if (y.value() < low.value()) == rising { start } else { end }, false);
    }
    let mut x = start;
    if is_close(at_start, at_end) {
        return (x, true);
    }
    for step in 0..STEPS {
        let falsi = (y - at_start) / (at_end - at_start);
        let sound = step < 3 * STEPS / 4 && falsi.value() > 0.0 && falsi.value() < 1.0;
        let t = if sound { falsi } else { y.constant(0.5) };
        x = start * t.subtracted_from(1.0) + end * t;
        let value = function(x);
        if (value.value() < y.value()) == rising {
            (start, at_start) = (x, value);
        } else {
            (end, at_end) = (x, value);
        }
        if is_close(end, start) || is_close(value, y) {
            break;
        }
    }
    (x, true)
}
