// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise without interpolation: one number for each cell between whole numbers, or for each point.
//! Source: OSL 1.14, `cellnoise` and `hashnoise`. Results are in [0, 1]; they have no derivatives.
//! Invariant: the bits of OSL's. Tests: `tests/noise.rs`.

use super::hash::{hash_uints, unit};
use super::period::wrap;
use crate::number::{Real, UInts};

/// Constant in each cell between whole numbers. `p` has 1 to 4 coordinates.
#[inline(always)]
pub fn cellnoise<R: Real, const N: usize>(p: [R; N]) -> R {
    unit(hash_uints(cells(p)))
}

/// Three numbers for each cell.
#[inline(always)]
pub fn cellnoise3<R: Real, const N: usize>(p: [R; N]) -> [R; 3] {
    three(cells(p))
}

/// Another number for each point.
#[inline(always)]
pub fn hashnoise<R: Real, const N: usize>(p: [R; N]) -> R {
    unit(hash_uints(bits(p)))
}

/// Three other numbers for each point.
#[inline(always)]
pub fn hashnoise3<R: Real, const N: usize>(p: [R; N]) -> [R; 3] {
    three(bits(p))
}

/// [`cellnoise`] that repeats.
#[inline(always)]
pub fn pcellnoise<R: Real, const N: usize>(p: [R; N], period: [R; N]) -> R {
    cellnoise(wrap(p, period))
}

/// [`cellnoise3`] that repeats.
#[inline(always)]
pub fn pcellnoise3<R: Real, const N: usize>(p: [R; N], period: [R; N]) -> [R; 3] {
    cellnoise3(wrap(p, period))
}

/// [`hashnoise`] that repeats.
#[inline(always)]
pub fn phashnoise<R: Real, const N: usize>(p: [R; N], period: [R; N]) -> R {
    hashnoise(wrap(p, period))
}

/// [`hashnoise3`] that repeats.
#[inline(always)]
pub fn phashnoise3<R: Real, const N: usize>(p: [R; N], period: [R; N]) -> [R; 3] {
    hashnoise3(wrap(p, period))
}

/// Hashes of a key with 0, 1 and 2 behind it.
#[inline(always)]
fn three<R: Real<UInts = W>, W: UInts, const N: usize>(key: [W; N]) -> [R; 3] {
    let last = [key[0].constant(0), key[0].constant(1), key[0].constant(2)];
    [followed(key, last[0]), followed(key, last[1]), followed(key, last[2])]
}

/// The hash of a key and one word more, as a float.
#[inline(always)]
fn followed<R: Real<UInts = W>, W: UInts, const N: usize>(key: [W; N], last: W) -> R {
    // Arrays of N + 1 have no type in stable Rust: each dimension is written out.
    unit(match N {
        1 => hash_uints([key[0], last]),
        2 => hash_uints([key[0], key[1], last]),
        3 => hash_uints([key[0], key[1], key[2], last]),
        _ => hash_uints([key[0], key[1], key[2], key[3], last]),
    })
}

/// The cells that coordinates are in. Written out: in lanes a function that is handed to `map` may become a call.
#[inline(always)]
fn cells<R: Real, const N: usize>(p: [R; N]) -> [R::UInts; N] {
    let mut keys = [p[0].bits(); N];
    for (key_bits, x) in keys.iter_mut().zip(p) {
        *key_bits = x.floor_int();
    }
    keys
}

/// The bits of coordinates, all NaNs alike.
#[inline(always)]
fn bits<R: Real, const N: usize>(p: [R; N]) -> [R::UInts; N] {
    let mut keys = [p[0].bits(); N];
    for (key_bits, x) in keys.iter_mut().zip(p) {
        *key_bits = x.known_bits();
    }
    keys
}
