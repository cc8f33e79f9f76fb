// SPDX-License-Identifier: GPL-3.0-or-later
//! The transfer functions of sRGB, exactly as the standard's two pieces, and the luminance of its primaries.
//! From IEC 61966-2-1. Linear values are relative to white = 1; encoded values are in 0..1 or 0..255.
//! Invariants: the functions are monotone and odd pieces meet; `decode(encode(x)) = x` within rounding; bytes
//! survive a round trip exactly. Tests: `tests`.

use std::sync::LazyLock;

/// Encoded value of a linear one; negative values follow the straight piece, values above 1 the curved one.
#[must_use]
pub fn encode(linear: f32) -> f32 {
    encode_f64(f64::from(linear)) as f32
}

/// Linear value of an encoded one; negative values follow the straight piece, values above 1 the curved one.
#[must_use]
pub fn decode(encoded: f32) -> f32 {
    decode_f64(f64::from(encoded)) as f32
}

fn encode_f64(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn decode_f64(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Nearest byte of a linear value; clamps to 0..1, NaN becomes 0.
#[must_use]
pub fn encode_u8(linear: f32) -> u8 {
    // `as` saturates and turns NaN into 0; comparisons with NaN are false, so it reaches the cast.
    (encode(linear) * 255.0 + 0.5) as u8
}

/// Linear value of an sRGB byte, from a table.
#[inline]
#[must_use]
pub fn decode_u8(byte: u8) -> f32 {
    DECODED[usize::from(byte)]
}

/// [`decode_u8`] of all bytes, for callers that decode many.
#[inline]
pub(crate) fn decoded_bytes() -> &'static [f32; 256] {
    &DECODED
}

static DECODED: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| decode_f64(byte as f64 / 255.0) as f32));

/// Linear value of an sRGB value of 16 bits.
#[must_use]
pub fn decode_u16(value: u16) -> f32 {
    decode_f64(f64::from(value) / 65535.0) as f32
}

/// Luminance of a linear colour with the primaries of sRGB (Rec. 709).
#[must_use]
pub fn luminance(rgb: [f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_a_round_trip() {
        for byte in 0..=255 {
            assert_eq!(encode_u8(decode_u8(byte)), byte, "byte {byte} changed");
        }
    }

    #[test]
    fn values_survive_a_round_trip() {
        for i in 0..=4096 {
            let linear = i as f32 / 1024.0;
            let back = decode(encode(linear));
            assert!((back - linear).abs() <= 4e-7 * linear.max(0.01), "{linear} became {back}");
        }
    }

    #[test]
    fn known_values_of_the_standard() {
        let known = [(0.0, 0.0), (1.0, 1.0), (0.5, 0.735_357), (0.002, 0.025_84), (0.214_041_14, 0.5)];
        for (linear, encoded) in known {
            let found = encode(linear);
            assert!((found - encoded).abs() < 1e-6, "encode({linear}) = {found}, expected {encoded}");
        }
    }

    #[test]
    fn pieces_meet_and_rise() {
        let mut last = -1.0;
        for i in 0..100_000 {
            let encoded = encode(i as f32 * 1e-5);
            assert!(encoded > last, "encode falls at {}", i as f32 * 1e-5);
            last = encoded;
        }
    }

    #[test]
    fn odd_values_have_bytes() {
        let cases =
            [(f32::NAN, 0), (-1.0, 0), (f32::NEG_INFINITY, 0), (f32::INFINITY, 255), (7.0, 255), (-0.0, 0)];
        for (linear, byte) in cases {
            assert_eq!(encode_u8(linear), byte, "byte of {linear}");
        }
    }

    #[test]
    fn white_has_luminance_one() {
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-6, "the weights must sum to 1");
    }
}
