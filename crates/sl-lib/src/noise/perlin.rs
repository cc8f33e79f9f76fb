// SPDX-License-Identifier: GPL-3.0-or-later
//! Perlin's gradient noise in 1 to 4 dimensions, with derivatives where coordinates have them.
//! Source: [Per02], with the hash, gradients and scales of OSL 1.14. Signed noise is in [-1, 1], unsigned noise in [0, 1].
//! Invariant: the bits of OSL's noise without derivatives, which interpolates along z, then x, y and w. Its noise with
//! derivatives takes another order in four dimensions and differs from that by a rounding; here both are the same.
//! Tests: `tests/noise.rs`.

use super::hash::hash_uints;
use super::period::whole_periods;
use crate::number::{Number, Real, UInts};

type UIntsOf<N> = <<N as Number>::Real as Real>::UInts;

/// Scales that bring each dimension's noise to about [-1, 1].
const SCALES: [f32; 4] = [0.25, 0.6616, 0.982, 0.8344];

/// a (1 - t) + b t.
#[inline(always)]
fn lerp<N: Number>(a: N, b: N, t: N) -> N {
    a * t.subtracted_from(1.0) + b * t
}

/// The blend of corners: 6 t^5 - 15 t^4 + 10 t^3.
#[inline(always)]
fn fade<N: Number>(t: N) -> N {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// The gradient that a hash chooses, times the offset `p` from its corner.
#[inline(always)]
fn gradient<N: Number, const D: usize>(hash: UIntsOf<N>, p: [N; D]) -> N {
    match D {
        1 => {
            let slope = N::Real::from_unsigned(hash & 7) + 1.0;
            N::lift(slope.negated_where((hash >> 3) & 1)) * p[0]
        }
        2 => {
            let low = (hash & 7).below(4);
            let (u, v) = (N::pick(low, p[0], p[1]), N::pick(low, p[1], p[0]) * 2.0);
            u.negated_where(hash & 1) + v.negated_where((hash >> 1) & 1)
        }
        3 => {
            let h = hash & 15;
            let u = N::pick(h.below(8), p[0], p[1]);
            let v = N::pick(h.below(4), p[1], N::pick(h.equal(12) | h.equal(14), p[0], p[2]));
            u.negated_where(hash & 1) + v.negated_where((hash >> 1) & 1)
        }
        _ => {
            let h = hash & 31;
            let u = N::pick(h.below(24), p[0], p[1]);
            let v = N::pick(h.below(16), p[1], p[2]);
            let s = N::pick(h.below(8), p[2], p[3]);
            u.negated_where(hash & 1) + v.negated_where((hash >> 1) & 1) + s.negated_where((hash >> 2) & 1)
        }
    }
}

/// A point between the corners of its cell.
#[derive(Clone, Copy)]
struct CellPoint<N: Number, const D: usize> {
    /// The lower corner.
    cell: [UIntsOf<N>; D],
    /// The offset from there, in [0, 1).
    rest: [N; D],
    /// How much of the upper corners to take.
    blend: [N; D],
    /// After how many cells the noise repeats.
    period: Option<[UIntsOf<N>; D]>,
}

impl<N: Number, const D: usize> CellPoint<N, D> {
    #[inline(always)]
    fn new(p: [N; D], period: Option<[UIntsOf<N>; D]>) -> Self {
        let (mut cell, mut rest, mut blend) = ([p[0].value().bits(); D], p, p);
        for i in 0..D {
            cell[i] = p[i].value().floor_int();
            rest[i] = p[i].with_value(p[i].value() - N::Real::from_int(cell[i]));
            blend[i] = fade(rest[i]);
        }
        Self { cell, rest, blend, period }
    }

    /// The hash of a corner: bit i of `corner` is set where coordinate i is the upper one.
    #[inline(always)]
    fn hash(&self, corner: usize) -> UIntsOf<N> {
        let mut key = self.cell;
        for i in 0..D {
            let at = if corner >> i & 1 == 1 { self.cell[i] + 1 } else { self.cell[i] };
            key[i] = if let Some(period) = self.period { at.wrapped(period[i]) } else { at };
        }
        hash_uints(key)
    }

    /// Contribution of a corner with this hash.
    #[inline(always)]
    fn contribution(&self, corner: usize, hash: UIntsOf<N>) -> N {
        let mut offset = self.rest;
        for (i, offset) in offset.iter_mut().enumerate() {
            if corner >> i & 1 == 1 {
                *offset = *offset - 1.0;
            }
        }
        gradient(hash, offset)
    }

    /// All corners blended; `hashes` are theirs.
    #[inline(always)]
    fn blended(&self, hashes: &[UIntsOf<N>; 16]) -> N {
        let noise = match D {
            1 => self.edge(hashes, 0, 1),
            2 => self.square(hashes),
            3 => self.cube(hashes, 0),
            _ => lerp(self.cube(hashes, 0), self.cube(hashes, 8), self.blend[D - 1]),
        };
        noise * SCALES[D - 1]
    }

    /// Two corners blended along the axis that bit `step` of their numbers is of.
    #[inline(always)]
    fn edge(&self, hashes: &[UIntsOf<N>; 16], low: usize, step: usize) -> N {
        let high = low + step;
        let axis = step.trailing_zeros() as usize;
        lerp(self.contribution(low, hashes[low]), self.contribution(high, hashes[high]), self.blend[axis])
    }

    /// Four corners blended along x, then y.
    #[inline(always)]
    fn square(&self, hashes: &[UIntsOf<N>; 16]) -> N {
        lerp(self.edge(hashes, 0, 1), self.edge(hashes, 2, 1), self.blend[D.min(2) - 1])
    }

    /// Eight corners blended along z, then x, then y.
    #[inline(always)]
    fn cube(&self, hashes: &[UIntsOf<N>; 16], low: usize) -> N {
        let near = lerp(self.edge(hashes, low, 4), self.edge(hashes, low + 1, 4), self.blend[0]);
        let far = lerp(self.edge(hashes, low + 2, 4), self.edge(hashes, low + 3, 4), self.blend[0]);
        lerp(near, far, self.blend[D.min(2) - 1])
    }

    #[inline(always)]
    fn hashes(&self) -> [UIntsOf<N>; 16] {
        let mut hashes = [self.cell[0]; 16];
        for (corner, hash) in hashes[..1 << D].iter_mut().enumerate() {
            *hash = self.hash(corner);
        }
        hashes
    }

    #[inline(always)]
    fn one(self) -> N {
        self.blended(&self.hashes())
    }

    /// Three noises from three bytes of each corner's hash.
    #[inline(always)]
    fn three(self) -> [N; 3] {
        let mut hashes = self.hashes();
        let mut noises = [self.rest[0]; 3];
        for noise in &mut noises {
            *noise = self.blended(&hashes);
            for hash in &mut hashes[..1 << D] {
                *hash = *hash >> 8;
            }
        }
        noises
    }
}

/// From [-1, 1] to [0, 1].
#[inline(always)]
pub(super) fn halved<N: Number>(x: N) -> N {
    (x + 1.0) * 0.5
}

/// Written out: in lanes a function that is handed to `map` may become a call.
#[inline(always)]
pub(super) fn three_halved<N: Number>([a, b, c]: [N; 3]) -> [N; 3] {
    [halved(a), halved(b), halved(c)]
}

/// Signed noise, in about [-1, 1]. `p` has 1 to 4 coordinates.
#[inline(always)]
pub fn snoise<N: Number, const D: usize>(p: [N; D]) -> N {
    N::Real::outline(
        #[inline(always)]
        || CellPoint::new(p, None).one(),
    )
}

/// Three signed noises.
#[inline(always)]
pub fn snoise3<N: Number, const D: usize>(p: [N; D]) -> [N; 3] {
    N::Real::outline(
        #[inline(always)]
        || CellPoint::new(p, None).three(),
    )
}

/// Noise in about [0, 1].
#[inline(always)]
pub fn noise<N: Number, const D: usize>(p: [N; D]) -> N {
    halved(snoise(p))
}

/// Three noises.
#[inline(always)]
pub fn noise3<N: Number, const D: usize>(p: [N; D]) -> [N; 3] {
    three_halved(snoise3(p))
}

/// Signed noise that repeats after `period`, which is rounded down and at least 1.
#[inline(always)]
pub fn psnoise<N: Number, const D: usize>(p: [N; D], period: [N::Real; D]) -> N {
    N::Real::outline(
        #[inline(always)]
        || CellPoint::new(p, Some(whole_periods(period))).one(),
    )
}

/// Three signed noises that repeat.
#[inline(always)]
pub fn psnoise3<N: Number, const D: usize>(p: [N; D], period: [N::Real; D]) -> [N; 3] {
    N::Real::outline(
        #[inline(always)]
        || CellPoint::new(p, Some(whole_periods(period))).three(),
    )
}

/// Noise that repeats.
#[inline(always)]
pub fn pnoise<N: Number, const D: usize>(p: [N; D], period: [N::Real; D]) -> N {
    halved(psnoise(p, period))
}

/// Three noises that repeat.
#[inline(always)]
pub fn pnoise3<N: Number, const D: usize>(p: [N; D], period: [N::Real; D]) -> [N; 3] {
    three_halved(psnoise3(p, period))
}
