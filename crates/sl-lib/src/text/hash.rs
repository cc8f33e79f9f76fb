// SPDX-License-Identifier: GPL-3.0-or-later
//! The hash of strings: FarmHash's 64 bits, which OSL's `hash(string)` takes the lower half of.
//! Source: FarmHash 1.1 (Geoff Pike, MIT), the variants `na`, `xo` and `uo` by length; the empty string has hash 0, as in OSL.
//! Tests: `tests/strings.rs`, against OpenImageIO's hashes.

const K0: u64 = 0xc3a5_c85c_97cb_3127;
const K1: u64 = 0xb492_b66f_be98_f273;
const K2: u64 = 0x9ae1_6a3b_2f90_404f;

/// Eight bytes from offset `at` on.
fn load(s: &[u8], at: usize) -> u64 {
    u64::from(half(s, at)) | u64::from(half(s, at + 4)) << 32
}

fn half(s: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([s[at], s[at + 1], s[at + 2], s[at + 3]])
}

fn add(a: u64, b: u64) -> u64 {
    a.wrapping_add(b)
}

fn times(a: u64, b: u64) -> u64 {
    a.wrapping_mul(b)
}

fn rotated(x: u64, by: u32) -> u64 {
    x.rotate_right(by)
}

fn shift_mix(x: u64) -> u64 {
    x ^ (x >> 47)
}

fn hash_two(u: u64, v: u64, mul: u64) -> u64 {
    let a = shift_mix(times(u ^ v, mul));
    times(shift_mix(times(v ^ a, mul)), mul)
}

fn up_to_16(s: &[u8]) -> u64 {
    let len = s.len();
    let mul = add(K2, len as u64 * 2);
    match len {
        8.. => {
            let (a, b) = (add(load(s, 0), K2), load(s, len - 8));
            let c = add(times(rotated(b, 37), mul), a);
            hash_two(c, times(add(rotated(a, 25), b), mul), mul)
        }
        4.. => {
            let a = u64::from(half(s, 0));
            hash_two(add(len as u64, a << 3), u64::from(half(s, len - 4)), mul)
        }
        1.. => {
            let y = u64::from(s[0]) + (u64::from(s[len >> 1]) << 8);
            let z = len as u64 + (u64::from(s[len - 1]) << 2);
            times(shift_mix(times(y, K2) ^ times(z, K0)), K2)
        }
        0 => K2,
    }
}

/// The common start for 17 bytes and more: two sums of the first and last 16 bytes.
fn ends(s: &[u8], mul: u64) -> (u64, u64) {
    let len = s.len();
    let (a, b) = (times(load(s, 0), K1), load(s, 8));
    let (c, d) = (times(load(s, len - 8), mul), times(load(s, len - 16), K2));
    let u = add(add(rotated(add(a, b), 43), rotated(c, 30)), d);
    (u, add(add(a, rotated(add(b, K2), 18)), c))
}

fn up_to_32(s: &[u8]) -> u64 {
    let mul = add(K2, s.len() as u64 * 2);
    let (u, v) = ends(s, mul);
    hash_two(u, v, mul)
}

fn of_32(s: &[u8], mul: u64, [seed0, seed1]: [u64; 2]) -> u64 {
    let (u, v) = ends(s, mul);
    let (u, v) = (add(u, seed0), add(v, seed1));
    let a = shift_mix(times(u ^ v, mul));
    shift_mix(times(v ^ a, mul))
}

fn up_to_64(s: &[u8]) -> u64 {
    let (mul0, mul1) = (K2.wrapping_sub(30), add(K2.wrapping_sub(30), 2 * s.len() as u64));
    let (h0, h1) = (of_32(&s[..32], mul0, [0; 2]), of_32(&s[s.len() - 32..], mul1, [0; 2]));
    times(add(times(h1, mul1), h0), mul1)
}

fn up_to_96(s: &[u8]) -> u64 {
    let (mul0, mul1) = (K2.wrapping_sub(114), add(K2.wrapping_sub(114), 2 * s.len() as u64));
    let (h0, h1) = (of_32(&s[..32], mul0, [0; 2]), of_32(&s[32..64], mul1, [0; 2]));
    let h2 = of_32(&s[s.len() - 32..], mul1, [h0, h1]);
    times(add(add(times(h2, 9), h0 >> 17), h1 >> 21), mul1)
}

/// 32 bytes from offset `at` on, with two seeds.
fn weak(s: &[u8], at: usize, a: u64, b: u64) -> (u64, u64) {
    let [w, x, y, z] = [0, 8, 16, 24].map(|i| load(s, at + i));
    let a = add(a, w);
    let b = rotated(add(add(b, a), z), 21);
    let c = a;
    let a = add(add(a, x), y);
    (add(a, z), add(add(b, rotated(a, 44)), c))
}

/// The state of variant `na` between blocks.
#[derive(Clone, Copy)]
struct State {
    x: u64,
    y: u64,
    z: u64,
    v: (u64, u64),
    w: (u64, u64),
}

impl State {
    fn round(self, s: &[u8], at: usize, mul: u64, nine: u64) -> Self {
        let Self { x, y, z, v, w } = self;
        let x = times(rotated(add(add(add(x, y), v.0), load(s, at + 8)), 37), mul);
        let y = times(rotated(add(add(y, v.1), load(s, at + 48)), 42), mul);
        let x = x ^ times(w.1, nine);
        let y = add(y, add(times(v.0, nine), load(s, at + 40)));
        let z = times(rotated(add(z, w.0), 33), mul);
        let v = weak(s, at, times(v.1, mul), add(x, w.0));
        let w = weak(s, at + 32, add(z, w.1), add(y, load(s, at + 16)));
        Self { x: z, y, z: x, v, w }
    }
}

/// The variant `na` for more than 64 bytes.
fn up_to_256(s: &[u8]) -> u64 {
    let y = add(times(81, K1), 113);
    let z = times(shift_mix(add(times(y, K2), 113)), K2);
    let mut state = State { x: add(times(81, K2), load(s, 0)), y, z, v: (0, 0), w: (0, 0) };
    for block in 0..(s.len() - 1) / 64 {
        state = state.round(s, block * 64, K1, 1);
    }
    let mul = add(K1, (state.z & 0xff) << 1);
    state.w.0 = add(state.w.0, ((s.len() - 1) & 63) as u64);
    state.v.0 = add(state.v.0, state.w.0);
    state.w.0 = add(state.w.0, state.v.0);
    let State { x, y, z, v, w } = state.round(s, s.len() - 64, mul, 9);
    let a = add(add(hash_two(v.0, w.0, mul), times(shift_mix(y), K0)), z);
    hash_two(a, add(hash_two(v.1, w.1, mul), x), mul)
}

fn last_of_long(x: u64, y: u64, mul: u64, by: u32) -> u64 {
    let a = shift_mix(times(x ^ y, mul));
    times(rotated(times(y ^ a, mul), by), mul)
}

/// The variant `uo`.
fn longer(s: &[u8]) -> u64 {
    let mut x: u64 = 81;
    let mut y: u64 = 113;
    let mut z = times(shift_mix(times(y, K2)), K2);
    let (mut v, mut w) = ((81_u64, 0_u64), (0_u64, 0_u64));
    let mut u = x.wrapping_sub(z);
    x = times(x, K2);
    let mul = add(K2, u & 0x82);
    for block in 0..(s.len() - 1) / 64 {
        let a: [u64; 8] = std::array::from_fn(|i| load(s, block * 64 + 8 * i));
        x = times(rotated(add(x, add(a[0], a[1])), 26), 9);
        y = rotated(add(y, a[2]), 29);
        z = times(add(z, a[3]), mul);
        v = (rotated(add(v.0, a[4]), 33), rotated(add(v.1, add(a[5], a[1])), 30));
        w = (times(add(w.0, a[6]) ^ x, 9), add(w.1, a[7]));
        z = add(rotated(z, 32), w.1);
        w.1 = add(w.1, z);
        z = times(z, 9);
        (u, y) = (y, u);
        z = add(z, add(a[0], a[6]));
        v = (add(v.0, a[2]), add(v.1, a[3]));
        w = (add(w.0, a[4]), add(w.1, add(a[5], a[6])));
        x = add(x, a[1]);
        y = add(add(y, a[7]), v.0);
        v.0 = add(v.0, x.wrapping_sub(y));
        v.1 = add(v.1, w.0);
        w.0 = add(w.0, v.1);
        w.1 = add(w.1, x.wrapping_sub(y));
        x = add(x, w.1);
        w.1 = rotated(w.1, 34);
        (u, z) = (z, u);
    }
    let at = s.len() - 64;
    u = times(u, 9);
    v = (rotated(v.0, 20), rotated(v.1, 28));
    w.0 = add(w.0, ((s.len() - 1) & 63) as u64);
    u = add(u, y);
    y = add(y, u);
    x = times(rotated(add(add(y.wrapping_sub(x), v.0), load(s, at + 8)), 37), mul);
    y = times(rotated(y ^ v.1 ^ load(s, at + 48), 42), mul);
    x ^= times(w.1, 9);
    y = add(y, add(v.0, load(s, at + 40)));
    z = times(rotated(add(z, w.0), 33), mul);
    v = weak(s, at, times(v.1, mul), add(x, w.0));
    w = weak(s, at + 32, add(z, w.1), add(y, load(s, at + 16)));
    let first = add(hash_two(add(v.0, x), w.0 ^ y, mul), z).wrapping_sub(u);
    let second = last_of_long(add(v.1, y), add(w.1, z), K2, 30) ^ x;
    last_of_long(first, second, K2, 31)
}

/// The hash of a string; 0 of the empty one.
#[must_use]
pub fn hash64(s: &str) -> u64 {
    let s = s.as_bytes();
    match s.len() {
        0 => 0,
        1..=16 => up_to_16(s),
        17..=32 => up_to_32(s),
        33..=64 => up_to_64(s),
        65..=96 => up_to_96(s),
        97..=256 => up_to_256(s),
        _ => longer(s),
    }
}

/// `hash(string)`: the lower half of [`hash64`].
#[must_use]
pub fn hash_string(s: &str) -> i32 {
    hash64(s) as i32
}
