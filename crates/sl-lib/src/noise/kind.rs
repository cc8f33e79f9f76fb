// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise by name: `noise("simplex", ..)`, for one position with derivatives.
//! Source: OSL 1.14, "noise". Differs: the noise that is always 0.5 has derivatives of 0.
//! Tests: `tests/gabor.rs`.

use super::gabor::{GaborOptions, gabor, gabor3};
use super::{cell, perlin, simplex};
use crate::dual::Dual;
use crate::number::{Number, Real};

type D = Dual<f32>;

/// A kind of noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseKind {
    /// `uperlin`, `noise`.
    UPerlin,
    /// `perlin`, `snoise`.
    Perlin,
    /// `simplex`, `simplexnoise`.
    Simplex,
    /// `usimplex`, `usimplexnoise`.
    USimplex,
    /// `cell`.
    Cell,
    /// `hash`.
    Hash,
    /// `gabor`.
    Gabor,
    /// `null`: 0.
    Null,
    /// `unull`: 0.5.
    UNull,
}

impl NoiseKind {
    /// The kind of this name; otherwise the program's message is `Unknown noise type "name"`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "uperlin" | "noise" => Self::UPerlin,
            "perlin" | "snoise" => Self::Perlin,
            "simplex" | "simplexnoise" => Self::Simplex,
            "usimplex" | "usimplexnoise" => Self::USimplex,
            "cell" => Self::Cell,
            "hash" => Self::Hash,
            "gabor" => Self::Gabor,
            "null" => Self::Null,
            "unull" => Self::UNull,
            _ => return None,
        })
    }

    /// Whether `pnoise` supports it.
    #[must_use]
    pub fn can_repeat(self) -> bool {
        matches!(self, Self::UPerlin | Self::Perlin | Self::Cell | Self::Hash | Self::Gabor)
    }

    /// One noise. `p` has 1 to 4 coordinates, a period as many; kinds that cannot repeat ignore it.
    ///
    /// # Panics
    /// If there are no coordinates, or more than four.
    #[must_use]
    pub fn noise(self, p: &[D], period: Option<&[f32]>, options: &GaborOptions) -> D {
        match self {
            Self::Gabor => gabor(in_space(p, 0.0.into()), period.map(|p| in_space(p, 0.0)), options),
            _ => self.plain(p, period, false)[0],
        }
    }

    /// Three noises, otherwise as [`noise`](Self::noise).
    ///
    /// # Panics
    /// As there.
    #[must_use]
    pub fn noise3(self, p: &[D], period: Option<&[f32]>, options: &GaborOptions) -> [D; 3] {
        match self {
            Self::Gabor => gabor3(in_space(p, 0.0.into()), period.map(|p| in_space(p, 0.0)), options),
            _ => self.plain(p, period, true),
        }
    }

    /// One noise, repeated, or three, for any numbers. Gabor noise, which has options, is 0 here.
    ///
    /// # Panics
    /// As [`noise`](Self::noise).
    pub fn plain<N: Number>(self, p: &[N], period: Option<&[N::Real]>, three: bool) -> [N; 3] {
        match *p {
            [x] => self.of([x], period, three),
            [x, y] => self.of([x, y], period, three),
            [x, y, z] => self.of([x, y, z], period, three),
            [x, y, z, t] => self.of([x, y, z, t], period, three),
            _ => panic!("noise has 1 to 4 coordinates, not {}", p.len()),
        }
    }

    fn of<N: Number, const D: usize>(self, p: [N; D], period: Option<&[N::Real]>, three: bool) -> [N; 3] {
        let v = p.map(N::value);
        // 1 is the least period.
        let one = v[0].of(1.0);
        let period: Option<[N::Real; D]> =
            period.map(|q| std::array::from_fn(|i| q.get(i).copied().unwrap_or(one)));
        let all = |x: N| [x; 3];
        match (self, period, three) {
            (Self::UPerlin, None, false) => all(perlin::noise(p)),
            (Self::UPerlin, None, true) => perlin::noise3(p),
            (Self::UPerlin, Some(q), false) => all(perlin::pnoise(p, q)),
            (Self::UPerlin, Some(q), true) => perlin::pnoise3(p, q),
            (Self::Perlin, None, false) => all(perlin::snoise(p)),
            (Self::Perlin, None, true) => perlin::snoise3(p),
            (Self::Perlin, Some(q), false) => all(perlin::psnoise(p, q)),
            (Self::Perlin, Some(q), true) => perlin::psnoise3(p, q),
            (Self::Simplex, _, false) => all(simplex::simplex(p)),
            (Self::Simplex, _, true) => simplex::simplex3(p),
            (Self::USimplex, _, false) => all(simplex::usimplex(p)),
            (Self::USimplex, _, true) => simplex::usimplex3(p),
            (Self::Cell, None, false) => all(N::lift(cell::cellnoise(v))),
            (Self::Cell, None, true) => cell::cellnoise3(v).map(N::lift),
            (Self::Cell, Some(q), false) => all(N::lift(cell::pcellnoise(v, q))),
            (Self::Cell, Some(q), true) => cell::pcellnoise3(v, q).map(N::lift),
            (Self::Hash, None, false) => all(N::lift(cell::hashnoise(v))),
            (Self::Hash, None, true) => cell::hashnoise3(v).map(N::lift),
            (Self::Hash, Some(q), false) => all(N::lift(cell::phashnoise(v, q))),
            (Self::Hash, Some(q), true) => cell::phashnoise3(v, q).map(N::lift),
            (Self::Null | Self::Gabor, ..) => all(N::lift(one.of(0.0))),
            (Self::UNull, ..) => all(N::lift(one.of(0.5))),
        }
    }
}

/// The first three coordinates; zeros where there are fewer.
fn in_space<T: Copy>(p: &[T], zero: T) -> [T; 3] {
    std::array::from_fn(|i| p.get(i).copied().unwrap_or(zero))
}
