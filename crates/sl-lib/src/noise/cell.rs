// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise without interpolation: one number for each cell between whole numbers, or for each point.
//! Source: OSL 1.14, `cellnoise` and `hashnoise`. Results are in [0, 1]; they have no derivatives.
//! Invariant: the bits of OSL's. Tests: `tests/noise.rs`.

use super::hash::{hash_words, unit};
use super::period::wrap;
use crate::number::{Real, Words};

/// Constant in each cell between whole numbers. `p` has 1 to 4 coordinates.
#[inline(always)]
pub fn cellnoise<R: Real, const N: usize>(p: [R; N]) -> R {
    unit(hash_words(cells(p)))
}

/// Three numbers for each cell.
#[inline(always)]
pub fn cellnoise3<R: Real, const N: usize>(p: [R; N]) -> [R; 3] {
    three(cells(p))
}

/// Another number for each point.
#[inline(always)]
pub fn hashnoise<R: Real, const N: usize>(p: [R; N]) -> R {
    unit(hash_words(bits(p)))
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
fn three<R: Real<Words = W>, W: Words, const N: usize>(key: [W; N]) -> [R; 3] {
    let last = [key[0].constant(0), key[0].constant(1), key[0].constant(2)];
    [followed(key, last[0]), followed(key, last[1]), followed(key, last[2])]
}

/// The hash of a key and one word more, as a float.
#[inline(always)]
fn followed<R: Real<Words = W>, W: Words, const N: usize>(key: [W; N], last: W) -> R {
    // An array of N + 1 has no type of its own yet: each dimension is written out.
    unit(match N {
        1 => hash_words([key[0], last]),
        2 => hash_words([key[0], key[1], last]),
        3 => hash_words([key[0], key[1], key[2], last]),
        _ => hash_words([key[0], key[1], key[2], key[3], last]),
    })
}

/// The cells that coordinates are in. Written out: in lanes a function that is handed to `map` may become a call.
#[inline(always)]
fn cells<R: Real, const N: usize>(p: [R; N]) -> [R::Words; N] {
    let mut words = [p[0].bits(); N];
    for (word, x) in words.iter_mut().zip(p) {
        *word = x.floor_int();
    }
    words
}

/// The bits of coordinates, all NaNs alike.
#[inline(always)]
fn bits<R: Real, const N: usize>(p: [R; N]) -> [R::Words; N] {
    let mut words = [p[0].bits(); N];
    for (word, x) in words.iter_mut().zip(p) {
        *word = x.known_bits();
    }
    words
}
