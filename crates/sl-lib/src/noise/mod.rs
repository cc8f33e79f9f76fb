// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise of every kind, in 1 to 4 dimensions.
//!
//! Points are arrays of their coordinates: a point and a time are `[x, y, z, t]`. Functions that end in 3 give three
//! noises; those that begin with p repeat.

mod cell;
mod gabor;
mod hash;
mod kind;
mod period;
mod perlin;
mod simplex;

pub use cell::{
    cellnoise, cellnoise3, hashnoise, hashnoise3, pcellnoise, pcellnoise3, phashnoise, phashnoise3,
};
pub use gabor::{GaborOptions, gabor, gabor3};
pub use hash::{hash_floats, hash_int, hash_uints};
pub use kind::NoiseKind;
pub use perlin::{noise, noise3, pnoise, pnoise3, psnoise, psnoise3, snoise, snoise3};
pub use simplex::{simplex, simplex3, usimplex, usimplex3};
