// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise for terrain: values at lattice points, smoothly interpolated, summed over octaves.
//! Source: [Per85] (lattice noise), [Mus93] (ridged sums, K. Musgrave's dissertation). Range: about [-1, 1].
//! Deterministic: all chance comes from integer hashes. Tests: `tests::smooth_and_bounded`.

/// A number in `[0, 1)` from two integers and a seed.
pub(super) fn hash(x: i32, y: i32, seed: u32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9e37_79b1)
        ^ (y as u32).wrapping_mul(0x85eb_ca77)
        ^ seed.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^= h >> 15;
    (h >> 8) as f32 / (1 << 24) as f32
}

/// Smooth noise in `[-1, 1]`, one bump per unit.
pub(super) fn value(x: f32, y: f32, seed: u32) -> f32 {
    let (i, j) = (x.floor(), y.floor());
    // Zero first and second derivatives at the lattice: no seams in the shading.
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (fade(x - i), fade(y - j));
    let corner = |di: i32, dj: i32| hash(i as i32 + di, j as i32 + dj, seed) * 2.0 - 1.0;
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    lerp(lerp(corner(0, 0), corner(1, 0), u), lerp(corner(0, 1), corner(1, 1), u), v)
}

/// Octaves of noise, each with double frequency and half amplitude, each rotated so that the lattices are
/// invisible.
pub(super) fn octaves(x: f32, y: f32, count: u32, seed: u32, shape: fn(f32) -> f32) -> f32 {
    let (mut x, mut y, mut height, mut sum, mut total) = (x, y, 1.0, 0.0, 0.0);
    for octave in 0..count {
        sum += height * shape(value(x, y, seed.wrapping_add(octave)));
        total += height;
        height *= 0.5;
        (x, y) = (1.6 * x - 1.2 * y + 17.3, 1.2 * x + 1.6 * y - 5.7);
    }
    sum / total
}

/// Rolling hills.
pub(super) fn rolling(x: f32, y: f32, count: u32, seed: u32) -> f32 {
    octaves(x, y, count, seed, |n| n)
}

/// Sharp crests, in `[0, 1]`.
pub(super) fn ridged(x: f32, y: f32, count: u32, seed: u32) -> f32 {
    octaves(x, y, count, seed, |n| (1.0 - n.abs()) * (1.0 - n.abs()))
}

/// 0 below `from`, 1 above `to`, smooth between; `from` may be the greater one.
pub(super) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_and_bounded() {
        let mut last = rolling(-3.0, 0.3, 5, 1);
        for i in 1..600 {
            let x = -3.0 + i as f32 * 0.01;
            let next = rolling(x, 0.3, 5, 1);
            assert!(next.abs() <= 1.0, "bounded at {x}: {next}");
            assert!((next - last).abs() < 0.2, "no jump at {x}");
            last = next;
            assert!((0.0..=1.0).contains(&ridged(x, 0.3, 5, 1)), "ridges are bounded at {x}");
        }
    }
}
