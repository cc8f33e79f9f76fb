// SPDX-License-Identifier: GPL-3.0-or-later
//! Splines over knots at equal distances, and their inverse.
//! Source: the OSL 1.14 language reference, "spline"; [CR74] and the standard bases; the inverse by regula falsi that falls
//! back to bisection. Positions are in [0, 1] from the first segment's start to the last one's end.
//! Invariant: sums are done in OSL's order, for its bits.
//! Proof: `tests/splines.rs`.

use crate::math::div;
use crate::number::{Number, Real, Words};

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

    /// How many segments so many knots make; 0 where there are fewer than four.
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

/// The knots as the function wants them: knot `i` of lane by lane different segments.
pub trait Knots<N: Number> {
    /// How many.
    fn count(&self) -> usize;
    /// Those at these places, all of which are below the count.
    fn at(&self, places: <N::Real as Real>::Words) -> N;
}

impl Knots<f32> for &[f32] {
    fn count(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn at(&self, places: <f32 as Real>::Words) -> f32 {
        self[places.0 as usize]
    }
}

impl Knots<crate::Dual<f32>> for &[f32] {
    fn count(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn at(&self, places: <f32 as Real>::Words) -> crate::Dual<f32> {
        self[places.0 as usize].into()
    }
}

impl Knots<crate::Dual<f32>> for &[crate::Dual<f32>] {
    fn count(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn at(&self, places: <f32 as Real>::Words) -> crate::Dual<f32> {
        self[places.0 as usize]
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
    fn at(&self, places: <f32 as Real>::Words) -> f32 {
        self.triples[places.0 as usize][self.index]
    }
}

impl Knots<crate::Dual<f32>> for Component<'_, [f32; 3]> {
    fn count(&self) -> usize {
        self.triples.len()
    }

    #[inline(always)]
    fn at(&self, places: <f32 as Real>::Words) -> crate::Dual<f32> {
        self.triples[places.0 as usize][self.index].into()
    }
}

impl Knots<crate::Dual<f32>> for Component<'_, crate::Dual<[f32; 3]>> {
    fn count(&self) -> usize {
        self.triples.len()
    }

    #[inline(always)]
    fn at(&self, places: <f32 as Real>::Words) -> crate::Dual<f32> {
        self.triples[places.0 as usize].components()[self.index]
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
    let segment = Words::pick(segment.below(segments as u32), segment, last);
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
#[must_use]
pub fn splineinverse(basis: Basis, y: f32, knots: &[f32]) -> f32 {
    let segments = basis.segments(knots.len());
    if segments == 0 {
        return 0.0;
    }
    let outer = usize::from(basis.step() == 1);
    let (low, high) = (knots[outer], knots[knots.len() - 1 - outer]);
    let rising = knots[1] < knots[knots.len() - 2];
    if if rising { y <= low } else { y >= low } {
        return 0.0;
    }
    if if rising { y >= high } else { y <= high } {
        return 1.0;
    }
    let at = |x: f32| spline(basis, x, knots);
    // Knots that rise may still make a curve that does not: each segment is searched by itself.
    let mut start = 0.0;
    let mut x = 0.0;
    for segment in 1..=segments {
        let end = (1.0 / segments as f32) * segment as f32;
        let (found, bracketed) = invert(at, y, start, end);
        x = found;
        if bracketed {
            break;
        }
        start = end;
    }
    x
}

/// [`splineinverse`] with derivatives: one over the spline's slope there, and 0 where it has none.
#[must_use]
pub fn splineinverse_dual(basis: Basis, y: crate::Dual<f32>, knots: &[f32]) -> crate::Dual<f32> {
    let x = splineinverse(basis, y.value, knots);
    let slope = spline(basis, crate::Dual::new(x, 1.0, 0.0), knots).dx;
    let inside = x > 0.0 && x < 1.0;
    y.chain(x, || if inside { div(1.0, slope) } else { 0.0 })
}

/// A place between two where a function is `y`, and whether it is so there at all.
fn invert(function: impl Fn(f32) -> f32, y: f32, mut start: f32, mut end: f32) -> (f32, bool) {
    const CLOSE: f32 = 1e-6;
    const STEPS: u32 = 32;
    let (mut at_start, mut at_end) = (function(start), function(end));
    let rising = at_start < at_end;
    let (low, high) = if rising { (at_start, at_end) } else { (at_end, at_start) };
    if y < low || y > high {
        return (if (y < low) == rising { start } else { end }, false);
    }
    let mut x = start;
    if (at_start - at_end).abs() < CLOSE {
        return (x, true);
    }
    for step in 0..STEPS {
        let t = if step < 3 * STEPS / 4 { (y - at_start) / (at_end - at_start) } else { 0.5 };
        let t = if t > 0.0 && t < 1.0 { t } else { 0.5 };
        x = start * (1.0 - t) + end * t;
        let value = function(x);
        if (value < y) == rising {
            (start, at_start) = (x, value);
        } else {
            (end, at_end) = (x, value);
        }
        if (end - start).abs() < CLOSE || (value - y).abs() < CLOSE {
            break;
        }
    }
    (x, true)
}
