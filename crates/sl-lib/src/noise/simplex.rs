// SPDX-License-Identifier: GPL-3.0-or-later
//! Simplex noise in 1 to 4 dimensions, with derivatives.
//! Source: [Gus05], with hashes instead of its table of permutations and the scales of OSL 1.14; results are in about [-1, 1].
//! Invariant: the bits of OSL's noise; derivatives differ from its by roundings, because here one formula serves all
//! dimensions. Tests: `tests/noise.rs`.

use super::hash::finish;
use super::perlin::{halved, three_halved};
use crate::number::{Number, Real, UInts};

/// A corner's gradients are 1, -1 or 0 along each axis: for each dimension and axis, which gradients are 1 and which -1.
const SIGNS_2: [(u32, u32); 2] = [(0x8a, 0x15), (0x58, 0xa1)];
const SIGNS_3: [(u32, u32); 3] = [(0x1311, 0x2c44), (0x4622, 0x8988), (0x300f, 0xc0f0)];
const SIGNS_4: [(u32, u32); 4] = [
    (0x0f0f_0f00, 0xf0f0_f000),
    (0x3333_000f, 0xcccc_00f0),
    (0x5500_3333, 0xaa00_cccc),
    (0x0055_5555, 0x00aa_aaaa),
];

/// By which part of the coordinates' sum a point is moved to where simplices are halves of cubes, and by which one back.
const SKEW: [f32; 4] = [0.0, 0.366_025_4, 0.333_333_34, 0.309_017];
const UNSKEW: [f32; 4] = [0.0, 0.211_324_87, 0.166_666_67, 0.138_196_6];
const SCALES: [f32; 4] = [0.36, 64.0, 68.0, 54.0];

/// A hash of three words.
#[inline(always)]
fn scramble<W: UInts>(a: W, b: W, c: W) -> W {
    finish([a, b, c ^ 0xdead_beef])
}

/// The gradient of a corner with these whole coordinates.
#[inline(always)]
fn gradient<R: Real, const D: usize>(corner: [R::UInts; D], seed: u32) -> [R; D] {
    let zero = corner[0].constant(0);
    let seed = corner[0].constant(seed);
    let mut out = [R::from_int(zero); D];
    if D == 1 {
        let h = scramble(corner[0], seed, zero);
        let slope = R::from_unsigned(h & 7) + 1.0;
        out[0] = slope.negated_where((h >> 3) & 1);
        return out;
    }
    let (h, signs): (R::UInts, &[(u32, u32)]) = match D {
        2 => (scramble(corner[0], corner[1], seed) & 7, &SIGNS_2),
        3 => (scramble(corner[0], corner[1], scramble(corner[2], seed, zero)) & 15, &SIGNS_3),
        _ => (scramble(corner[0], corner[1], scramble(corner[2], corner[3], seed)) & 31, &SIGNS_4),
    };
    for (out, &(plus, minus)) in out.iter_mut().zip(signs) {
        *out = R::from_unsigned(h.bit_of(plus)) - R::from_unsigned(h.bit_of(minus));
    }
    out
}

/// The sum of the axes from the first on.
#[inline(always)]
fn sum<R: Real, const D: usize>(x: [R; D]) -> R {
    let mut sum = x[0];
    for x in &x[1..] {
        sum = sum + *x;
    }
    sum
}

/// For each axis how many of the others its coordinate is ahead of; an axis leads the later ones by `>`, in three dimensions
/// by `>=`.
#[inline(always)]
fn ranks<R: Real, const D: usize>(x: [R; D]) -> [R::UInts; D] {
    let mut ranks = [x[0].bits().constant(0); D];
    for i in 0..D {
        for j in i + 1..D {
            let ahead = if D == 3 { x[j].at_most(x[i]) } else { x[j].less(x[i]) };
            let one = R::UInts::pick(ahead, ranks[i].constant(1), ranks[i].constant(0));
            ranks[i] = ranks[i] + one;
            ranks[j] = ranks[j] + (one ^ 1);
        }
    }
    ranks
}

/// Noise and its slope along each axis.
#[inline(always)]
fn noise_with_slopes<R: Real, const D: usize>(p: [R; D], seed: u32) -> (R, [R; D]) {
    let zero = p[0].of(0.0);
    let skew = sum(p) * SKEW[D - 1];
    let mut cell = [p[0].bits(); D];
    for (cell, x) in cell.iter_mut().zip(p) {
        *cell = if D == 1 { x.floor_int() } else { (x + skew).floor_int() };
    }
    let mut whole = cell[0];
    for cell in &cell[1..] {
        whole = whole + *cell;
    }
    let back = R::from_int(whole) * UNSKEW[D - 1];
    let mut rest = p;
    for (rest, cell) in rest.iter_mut().zip(cell) {
        let corner = R::from_int(cell);
        *rest = if D == 1 { *rest - corner } else { *rest - (corner - back) };
    }
    let ranks = ranks(rest);

    let (mut noise, mut tilt, mut level) = (zero, [zero; D], [zero; D]);
    for k in 0..=D {
        let (mut corner, mut offset) = (cell, rest);
        for i in 0..D {
            // The offset to corner k goes along the k leading axes.
            let stepped = if k == 0 {
                ranks[i].constant(0)
            } else {
                one_where(!ranks[i].below((D - k) as u32), ranks[i])
            };
            corner[i] = corner[i] + stepped;
            offset[i] = match k {
                0 => offset[i],
                _ if D == 1 => offset[i] - 1.0,
                _ if k == D => (offset[i] - 1.0) + k as f32 * UNSKEW[D - 1],
                1 => (offset[i] - R::from_unsigned(stepped)) + UNSKEW[D - 1],
                _ => (offset[i] - R::from_unsigned(stepped)) + k as f32 * UNSKEW[D - 1],
            };
        }
        let mut reach = p[0].of(if D == 1 { 1.0 } else { 0.5 });
        for x in offset {
            reach = reach - x * x;
        }
        let reach = R::choose(zero.at_most(reach), reach, zero);
        let gradient = gradient::<R, D>(corner, seed);
        let (t2, mut slope) = (reach * reach, gradient[0] * offset[0]);
        for i in 1..D {
            slope = slope + gradient[i] * offset[i];
        }
        let t4 = t2 * t2;
        noise = noise + if D == 1 { (t4 * gradient[0]) * offset[0] } else { t4 * slope };
        let fall = t2 * reach * slope;
        for i in 0..D {
            tilt[i] = tilt[i] + fall * offset[i];
            level[i] = level[i] + t4 * gradient[i];
        }
    }
    let scale = SCALES[D - 1];
    for (tilt, level) in tilt.iter_mut().zip(level) {
        *tilt = (*tilt * -8.0 + level) * scale;
    }
    (noise * scale, tilt)
}

#[inline(always)]
fn one_where<W: UInts>(mask: W::Mask, like: W) -> W {
    W::pick(mask, like.constant(1), like.constant(0))
}

/// The values of coordinates.
#[inline(always)]
fn values<N: Number, const D: usize>(p: [N; D]) -> [N::Real; D] {
    let mut values = [p[0].value(); D];
    for (value, x) in values.iter_mut().zip(p) {
        *value = x.value();
    }
    values
}

/// Signed simplex noise; other seeds give other noises. `p` has 1 to 4 coordinates.
#[inline(always)]
fn seeded<N: Number, const D: usize>(p: [N; D], seed: u32) -> N {
    let (noise, slopes) = N::Real::outline(
        #[inline(always)]
        || noise_with_slopes(values(p), seed),
    );
    let mut out = N::lift(noise);
    for (x, slope) in p.into_iter().zip(slopes) {
        // The chain rule, one axis at a time; the value stays.
        out = (out + x.chain(noise, || slope)).with_value(noise);
    }
    out
}

/// Signed simplex noise in about [-1, 1].
#[inline(always)]
pub fn simplex<N: Number, const D: usize>(p: [N; D]) -> N {
    seeded(p, 0)
}

/// Three signed simplex noises.
#[inline(always)]
pub fn simplex3<N: Number, const D: usize>(p: [N; D]) -> [N; 3] {
    [seeded(p, 0), seeded(p, 1), seeded(p, 2)]
}

/// Simplex noise in about [0, 1].
#[inline(always)]
pub fn usimplex<N: Number, const D: usize>(p: [N; D]) -> N {
    halved(simplex(p))
}

/// Three simplex noises.
#[inline(always)]
pub fn usimplex3<N: Number, const D: usize>(p: [N; D]) -> [N; 3] {
    three_halved(simplex3(p))
}
