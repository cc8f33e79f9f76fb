// SPDX-License-Identifier: GPL-3.0-or-later
//! The hash that all noise and `hash()` are made of: Bob Jenkins' lookup3 over 1 to 5 words.
//! Source: Bob Jenkins, lookup3.c (public domain), with the seeds that OSL starts from.
//! Invariant: the bits of OSL's. Tests: `tests/noise.rs`.

use crate::number::{Real, UInt, UInts};

/// The initial value of all three registers, before `keys` words are mixed in.
const fn start(keys: u32) -> u32 {
    0xdead_beef_u32.wrapping_add(keys << 2).wrapping_add(13)
}

#[inline(always)]
fn mix<W: UInts>([mut a, mut b, mut c]: [W; 3]) -> [W; 3] {
    a = (a - c) ^ c.rotated(4);
    c = c + b;
    b = (b - a) ^ a.rotated(6);
    a = a + c;
    c = (c - b) ^ b.rotated(8);
    b = b + a;
    a = (a - c) ^ c.rotated(16);
    c = c + b;
    b = (b - a) ^ a.rotated(19);
    a = a + c;
    c = (c - b) ^ b.rotated(4);
    b = b + a;
    [a, b, c]
}

/// The last step of the hash, which is also a hash of three words by itself.
#[inline(always)]
pub(crate) fn finish<W: UInts>([mut a, mut b, mut c]: [W; 3]) -> W {
    c = (c ^ b) - b.rotated(14);
    a = (a ^ c) - c.rotated(11);
    b = (b ^ a) - a.rotated(25);
    c = (c ^ b) - b.rotated(16);
    a = (a ^ c) - c.rotated(4);
    b = (b ^ a) - a.rotated(14);
    (c ^ b) - b.rotated(24)
}

/// The hash of 1 to 5 words.
#[inline(always)]
pub fn hash_uints<W: UInts, const N: usize>(k: [W; N]) -> W {
    const { assert!(1 <= N && N <= 5, "a hash of one to five words") };
    let zero = k[0].constant(start(N as u32));
    let second = if N > 1 { k[1] + start(N as u32) } else { zero };
    let third = if N > 2 { k[2] + start(N as u32) } else { zero };
    let mut registers = [k[0] + start(N as u32), second, third];
    if N > 3 {
        registers = mix(registers);
        registers[0] = registers[0] + k[3];
    }
    if N > 4 {
        registers[1] = registers[1] + k[4];
    }
    finish(registers)
}

/// Words as floats in [0, 1].
#[inline(always)]
pub(crate) fn unit<R: Real>(bits: R::UInts) -> R {
    R::from_unsigned(bits) * (1.0 / 4_294_967_295.0_f64) as f32
}

/// `hash(int)`.
#[must_use]
pub fn hash_int(x: i32) -> i32 {
    hash_uints([UInt(x as u32)]).0 as i32
}

/// `hash(float)`, `hash(float, float)`, `hash(point)` and `hash(point, float)`: of the bits, so 0 and -0 differ; NaNs do not.
#[must_use]
pub fn hash_floats<const N: usize>(x: [f32; N]) -> i32 {
    hash_uints(x.map(Real::known_bits)).0 as i32
}
