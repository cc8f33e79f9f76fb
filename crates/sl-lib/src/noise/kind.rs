// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise by name: `noise("simplex", ..)`, for one position with derivatives.
//! Source: OSL 1.14, "noise". Differs: the noise that is always 0.5 has derivatives of 0.
//! Tests: `tests/gabor.rs`.

use super::gabor::{GaborOptions, gabor, gabor3};
use super::{cell, perlin, simplex};
use crate::dual::Dual;

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
        match *p {
            [x] => self.one([x], fixed(period), options),
            [x, y] => self.one([x, y], fixed(period), options),
            [x, y, z] => self.one([x, y, z], fixed(period), options),
            [x, y, z, t] => self.one([x, y, z, t], fixed(period), options),
            _ => panic!("noise has 1 to 4 coordinates, not {}", p.len()),
        }
    }

    /// Three noises, otherwise as [`noise`](Self::noise).
    ///
    /// # Panics
    /// As there.
    #[must_use]
    pub fn noise3(self, p: &[D], period: Option<&[f32]>, options: &GaborOptions) -> [D; 3] {
        match *p {
            [x] => self.three([x], fixed(period), options),
            [x, y] => self.three([x, y], fixed(period), options),
            [x, y, z] => self.three([x, y, z], fixed(period), options),
            [x, y, z, t] => self.three([x, y, z, t], fixed(period), options),
            _ => panic!("noise has 1 to 4 coordinates, not {}", p.len()),
        }
    }

    fn one<const N: usize>(self, p: [D; N], period: Option<[f32; N]>, options: &GaborOptions) -> D {
        let values = p.map(|x| x.value);
        match (self, period) {
            (Self::UPerlin, None) => perlin::noise(p),
            (Self::UPerlin, Some(period)) => perlin::pnoise(p, period),
            (Self::Perlin, None) => perlin::snoise(p),
            (Self::Perlin, Some(period)) => perlin::psnoise(p, period),
            (Self::Simplex, _) => simplex::simplex(p),
            (Self::USimplex, _) => simplex::usimplex(p),
            (Self::Cell, None) => cell::cellnoise(values).into(),
            (Self::Cell, Some(period)) => cell::pcellnoise(values, period).into(),
            (Self::Hash, None) => cell::hashnoise(values).into(),
            (Self::Hash, Some(period)) => cell::phashnoise(values, period).into(),
            (Self::Gabor, period) => {
                gabor(in_space(p, 0.0.into()), period.map(|p| in_space(p, 0.0)), options)
            }
            (Self::Null, _) => 0.0.into(),
            (Self::UNull, _) => 0.5.into(),
        }
    }

    fn three<const N: usize>(self, p: [D; N], period: Option<[f32; N]>, options: &GaborOptions) -> [D; 3] {
        let values = p.map(|x| x.value);
        match (self, period) {
            (Self::UPerlin, None) => perlin::noise3(p),
            (Self::UPerlin, Some(period)) => perlin::pnoise3(p, period),
            (Self::Perlin, None) => perlin::snoise3(p),
            (Self::Perlin, Some(period)) => perlin::psnoise3(p, period),
            (Self::Simplex, _) => simplex::simplex3(p),
            (Self::USimplex, _) => simplex::usimplex3(p),
            (Self::Cell, None) => cell::cellnoise3(values).map(D::from),
            (Self::Cell, Some(period)) => cell::pcellnoise3(values, period).map(D::from),
            (Self::Hash, None) => cell::hashnoise3(values).map(D::from),
            (Self::Hash, Some(period)) => cell::phashnoise3(values, period).map(D::from),
            (Self::Gabor, period) => {
                gabor3(in_space(p, 0.0.into()), period.map(|p| in_space(p, 0.0)), options)
            }
            (Self::Null, _) => [0.0; 3].map(D::from),
            (Self::UNull, _) => [0.5; 3].map(D::from),
        }
    }
}

/// A period of as many numbers as there are coordinates; 1, the least one, where some are missing.
fn fixed<const N: usize>(period: Option<&[f32]>) -> Option<[f32; N]> {
    period.map(|period| std::array::from_fn(|i| period.get(i).copied().unwrap_or(1.0)))
}

/// The first three coordinates; zeros where there are fewer.
fn in_space<T: Copy, const N: usize>(p: [T; N], zero: T) -> [T; 3] {
    std::array::from_fn(|i| p.get(i).copied().unwrap_or(zero))
}
