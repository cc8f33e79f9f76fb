// SPDX-License-Identifier: GPL-3.0-or-later
//! The id of a name: its hash, changed where its bits would be no normal float.
//! Source: [FJ16] sections on hashing and conversion; MurmurHash3 of 32 bits, seed 0 [App11].
//! Tests: `tests`.

/// The bits of the float that identifies a name in Cryptomatte's channels.
#[must_use]
pub fn matte_id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    let exponent = hash >> 23 & 255;
    // Zero, denormal numbers, infinities and NaN do not survive compositing.
    if matches!(exponent, 0 | 255) { hash ^ 1 << 23 } else { hash }
}

fn murmur3(bytes: &[u8]) -> u32 {
    const FACTORS: [u32; 2] = [0xcc9e_2d51, 0x1b87_3593];
    let scramble = |block: u32| block.wrapping_mul(FACTORS[0]).rotate_left(15).wrapping_mul(FACTORS[1]);
    let (blocks, rest) = bytes.as_chunks::<4>();
    let mixed = blocks.iter().fold(0, |hash: u32, &block| {
        (hash ^ scramble(u32::from_le_bytes(block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let last = rest.iter().rev().fold(0, |last, &byte| last << 8 | u32::from(byte));
    let mut hash = mixed ^ scramble(last) ^ bytes.len() as u32;
    for (shift, factor) in [(16, 0x85eb_ca6b), (13, 0xc2b2_ae35)] {
        hash = (hash ^ hash >> shift).wrapping_mul(factor);
    }
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_others() {
        for (text, hash) in [
            ("", 0),
            ("hello", 0x248b_fa47),
            ("hello, world", 0x149b_bb7f),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text}");
        }
    }

    #[test]
    fn ids_are_normal_floats() {
        assert_eq!(matte_id("bunny"), 0x1385_1a76, "the example of the specification");
        for i in 0..5000 {
            assert!(f32::from_bits(matte_id(&format!("thing {i}"))).is_normal(), "{i}");
        }
        assert_eq!(matte_id(""), 1 << 23, "a name without letters");
    }
}
